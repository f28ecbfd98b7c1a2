// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "tests/cli/program.h"
#include "tests/cli/schema.h"

namespace photic::test {
namespace {

using Strings = std::vector<std::string>;

void expectUsage(const Strings& arguments, const Strings& words) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Outcome outcome = photic(place, arguments);
    EXPECT_EQ(outcome.code, 2) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    for (const std::string& word : words)
        EXPECT_NE(outcome.err.find(word), std::string::npos) << "'" << word << "' is not in: " << outcome.err;
    EXPECT_EQ(place.names(), Strings{"pool.toml"});
}

TEST(Usage, MistakesExitWithTwo) {
    expectUsage({}, {"--help"});
    expectUsage({"bak", "pool.toml"}, {"bak", "did you mean 'bake'"});
    expectUsage({"bake"}, {"SCENE", "photic bake --help"});
    expectUsage({"bake", "pool.toml", "--frob"}, {"--frob"});
    expectUsage({"bake", "pool.toml", "--threads", "many"}, {"--threads"});
    expectUsage({"bake", "pool.toml", "--compression", "lzma"}, {"lzma", "zip"});
    expectUsage({"bake", "pool.toml", "--method", "beems"}, {"beems", "did you mean 'beams'"});
    expectUsage({"bake", "pool.toml", "--grids", "irradiance,directoin"}, {"directoin", "did you mean 'direction'"});
    expectUsage({"bake", "pool.toml", "--voxel-size", "1", "--resolution", "9"}, {"--voxel-size", "--resolution"});
    expectUsage({"bake", "pool.toml", "--tolerance", "nan"}, {"--tolerance"});
    expectUsage({"compare", "a.vdb", "b.exr"}, {"a.vdb", "b.exr"});
    expectUsage({"compare", "a.vdb", "b.vdb", "--max-error", "-1"}, {"--max-error"});
    expectUsage({"export", "a.vdb", "-o", "a.png"}, {".exr"});
    expectUsage({"picture", "pool.toml", "a.vdb", "b.vdb"}, {"--film-strip"});
    for (const char* option : {"--exposure", "--max", "--fov", "--tiles", "--shafts", "--shafts-g"})
        expectUsage({"picture", "pool.toml", "a.vdb", "--view", option, "nan"}, {option, "nan"});
    expectUsage({"compare", "a.vdb", "b.vdb", "--max-error", "nan"}, {"--max-error", "nan"});
    expectUsage({"bake", "pool.toml", "--set", "beams.mesh=-5"}, {"mesh", "-5"});
    for (const char* step : {"frob=1,2", "sharpen=0,1", "dissipate=-0.5,9"})
        expectUsage({"bake", "pool.toml", "--post", step}, {step});
    expectUsage({"bake", "pool.toml", "--max-memory", "-1"}, {"--max-memory", "-1"});
}

// Also where the verb's file is missing, or one dash of two.
TEST(Usage, OptionsThatAreMisspeltAreSuggested) {
    expectUsage({"bake", "--hlep"}, {"--hlep", "did you mean --help?"});
    expectUsage({"inspect", "--jsn"}, {"--jsn", "did you mean --json?"});
    expectUsage({"bake", "pool.toml", "-voxel-size", "0.1"}, {"-voxel-size", "did you mean --voxel-size?"});
    expectUsage({"bake", "pool.toml", "--voxelsize=0.1"}, {"--voxelsize", "did you mean --voxel-size?"});
}

TEST(Usage, NumbersOutOfRangeAreSaidInWords) {
    expectUsage({"bake", "pool.toml", "--threads", "5000"}, {"--threads: 5000", "from 0 to 1024"});
    expectUsage({"picture", "pool.toml", "a.vdb", "--exposure=-1"}, {"--exposure: -1", "must be above 0;"});
    expectUsage({"picture", "pool.toml", "a.vdb", "--exposure", "0"}, {"--exposure: 0", "must be above 0;"});
    expectUsage({"picture", "pool.toml", "a.vdb", "--tiles=-1"}, {"--tiles: -1", "must be not below 0;"});
    expectUsage({"picture", "pool.toml", "a.vdb", "--fov", "999"}, {"--fov: 999", "from 1 to 150"});
}

// As when the scene and the volume change places.
TEST(Usage, FilesOfAnotherKindAreNamed) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    for (const char* name : {"light.vdb", "light.nvdb", "water.obj", "pool.blend"}) place.write(name, "\xff\xfe");
    const auto refused = [&](const Strings& arguments, const std::string& words) {
        const Outcome outcome = photic(place, arguments);
        EXPECT_EQ(outcome.code, 3) << outcome.err;
        EXPECT_NE(outcome.err.find(words), std::string::npos) << outcome.err;
    };
    refused({"bake", "light.vdb", "-o", "out.vdb"}, "is a volume, which photic bake makes of a scene");
    refused({"bake", "light.nvdb", "-o", "out.vdb"}, "is a volume for games");
    refused({"bake", "water.obj", "-o", "out.vdb"}, "is a mesh");
    refused({"bake", "pool.blend", "-o", "out.vdb"}, "export a .glb");
    refused({"inspect", "pool.toml"}, "it is a scene");
    refused({"inspect", "light.nvdb"}, "give the .vdb that it was made of");
}

TEST(Usage, SetNamesItsMistake) {
    expectUsage({"bake", "pool.toml", "--set", "mesh=512"}, {"METHOD.OPTION=VALUE"});
    expectUsage({"bake", "pool.toml", "--set", "beems.mesh=512"}, {"did you mean 'beams'"});
    expectUsage({"bake", "pool.toml", "--set", "beams.mehs=512"}, {"did you mean 'mesh'"});
    expectUsage({"bake", "pool.toml", "--set", "beams.mesh=many"}, {"many", "whole number"});
}

TEST(Usage, HelpAndVersionGoToStdout) {
    const Workplace place;
    const Outcome version = photic(place, {"--version"});
    EXPECT_EQ(version.code, 0);
    EXPECT_TRUE(version.out.starts_with("photic 0.")) << version.out;
    const Outcome help = photic(place, {"--help"});
    EXPECT_EQ(help.code, 0);
    for (const char* verb : {"bake", "scene", "inspect", "compare", "picture", "export", "sample", "methods"})
        EXPECT_NE(help.out.find(verb), std::string::npos);
    // The catalogue's rows are in the help.
    const Outcome bake = photic(place, {"bake", "--help"});
    EXPECT_EQ(bake.code, 0);
    for (const char* word : {"beams.mesh", "photons.count", "--dry-run"})
        EXPECT_NE(bake.out.find(word), std::string::npos) << bake.out;
    EXPECT_EQ(help.err + bake.err + version.err, "");
}

TEST(Usage, HelpIsFoundHoweverItIsAskedFor) {
    const Workplace place;
    const std::string page = photic(place, {"bake", "--help"}).out;
    EXPECT_EQ(photic(place, {"help", "bake"}).out, page);
    EXPECT_EQ(photic(place, {"bake", "-h"}).out, page);
    EXPECT_EQ(photic(place, {"help"}).out, photic(place, {"--help"}).out);
    EXPECT_EQ(photic(place, {"-V"}).out, photic(place, {"--version"}).out);
    const Outcome unknown = photic(place, {"help", "bak"});
    EXPECT_EQ(unknown.code, 2);
    EXPECT_NE(unknown.err.find("did you mean 'bake'"), std::string::npos) << unknown.err;
}

TEST(Usage, EachVerbShowsAnExampleAndNothingOfTheParser) {
    const Workplace place;
    for (const char* verb : {"bake", "scene", "inspect", "compare", "picture", "export", "merge", "methods", "post",
                             "completions", "man"}) {
        const std::string page = photic(place, {"help", verb}).out;
        EXPECT_NE(page.find(std::string("  photic ") + verb), std::string::npos) << page;
        EXPECT_NE(page.find("Example"), std::string::npos) << page;
        for (const char* raw : {"ENUM", "TEXT", "INT", "FLOAT", "{", " in [", "REQUIRED", "Excludes"})
            EXPECT_EQ(page.find(raw), std::string::npos) << verb << " shows " << raw << ":\n" << page;
    }
}

TEST(Usage, PagesAreWrappedAtTheTerminalsWidth) {
    const Workplace place;
    for (const int columns : {60, 80, 120}) {
        setenv("COLUMNS", std::to_string(columns).c_str(), 1);
        for (const char* verb : {"bake", "picture", "export"}) {
            std::istringstream page(photic(place, {"help", verb}).out);
            bool in_examples = false;
            for (std::string line; std::getline(page, line);) {
                if (!line.starts_with(' ')) in_examples = line.starts_with("Example");
                // Examples are to be copied, and long words cannot be broken.
                if (in_examples || line.find_first_of(' ', line.find_first_not_of(' ')) == std::string::npos) continue;
                EXPECT_LE(line.size(), static_cast<std::size_t>(columns)) << verb << ": " << line;
            }
        }
    }
    unsetenv("COLUMNS");
}

TEST(Usage, MisspeltOptionsAndWordsGetASuggestion) {
    expectUsage({"bake", "pool.toml", "--prefiler"}, {"--prefiler", "did you mean --prefilter"});
    expectUsage({"export", "a.vdb", "-o", "a.nvdb", "--bugdet=3"}, {"--bugdet", "did you mean --budget"});
    expectUsage({"bake", "pool.toml", "--where", "recievers"}, {"'recievers'", "did you mean 'receivers'"});
    expectUsage({"completions", "csh"}, {"csh", "bash, zsh, fish"});
}

TEST(Usage, NothingOfTheParserIsSaid) {
    expectUsage({"bake", "pool.toml", "--where"}, {"--where wants a value"});
    expectUsage({"bake", "pool.toml", "--where", "media", "--where", "media"}, {"--where is given more than once"});
    expectUsage({"bake", "pool.toml", "--resolution", "99999999999999"}, {"--resolution", "no number"});
    expectUsage({"bake", "pool.toml", "other.toml"}, {"more than the verb takes: other.toml"});
}

TEST(Usage, QuietSaysNothingButWhatIsWrong) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Outcome quiet = photic(place, {"bake", "pool.toml", "--quiet"});
    EXPECT_EQ(quiet.code, 0);
    EXPECT_EQ(quiet.err, "");
    EXPECT_NE(photic(place, {"bake", "pool.toml"}).err, "");
    EXPECT_NE(photic(place, {"bake", "none.toml", "-q"}).err.find("none.toml"), std::string::npos);
}

TEST(Usage, CompletionsAndTheManualKnowEveryVerbAndOption) {
    const Workplace place;
    const std::string help = photic(place, {"help", "bake"}).out;
    std::vector<std::string> pages;
    for (const char* shell : {"bash", "zsh", "fish"}) pages.push_back(photic(place, {"completions", shell}).out);
    pages.push_back(photic(place, {"man"}).out);
    for (const char* word : {"bake", "inspect", "picture", "voxel", "prefilter", "receivers"}) {
        for (const std::string& page : pages) EXPECT_NE(page.find(word), std::string::npos) << word;
        EXPECT_NE((help + "inspect picture").find(word), std::string::npos);
    }
    // The bash script completes in a shell.
    place.write("photic.bash", pages[0]);
    const std::string script =
        ". '" + (place / "photic.bash").string() +
        "'; COMP_WORDS=(photic bake --where rec); COMP_CWORD=3; _photic; echo \"${COMPREPLY[@]}\";"
        "COMP_WORDS=(photic ins); COMP_CWORD=1; _photic; echo \"${COMPREPLY[@]}\";"
        "COMP_WORDS=(photic bake --voxel); COMP_CWORD=2; _photic; echo \"${COMPREPLY[@]}\"";
    place.write("run.sh", script);
    const std::string out = (place / "out.txt").string();
    ASSERT_EQ(std::system(("bash '" + (place / "run.sh").string() + "' > '" + out + "' 2>&1").c_str()), 0);
    EXPECT_EQ(place.read("out.txt"), "receivers\ninspect\n--voxel-size\n");
}

TEST(Usage, MethodsAreListedAsDocumented) {
    const Workplace place;
    const Outcome outcome = photic(place, {"methods", "--json"});
    ASSERT_EQ(outcome.code, 0);
    EXPECT_EQ(schemaBreaches(outcome.json(), "methods.md"), Strings{});
    Strings names;
    const auto document = outcome.json();
    for (const auto& method : document["methods"]) {
        names.push_back(method["name"]);
        for (const auto& option : method["options"]) {
            EXPECT_NE(option["help"], "");
            const std::string type = option["type"];
            if (type == "flag") {
                EXPECT_TRUE(option["default"].is_boolean()) << option;
            } else if (type == "choice") {
                const auto& choices = option["choices"];
                EXPECT_NE(std::find(choices.begin(), choices.end(), option["default"]), choices.end()) << option;
            } else {
                EXPECT_LE(option["min"].get<double>(), option["default"].get<double>()) << option;
                EXPECT_GE(option["max"].get<double>(), option["default"].get<double>()) << option;
            }
        }
    }
    EXPECT_EQ(names, (Strings{"beams", "wavefront", "photons", "eikonal", "wave"}));
    EXPECT_NE(photic(place, {"methods"}).out.find("photons"), std::string::npos);
}

TEST(Usage, EventsCarryUsageErrorsToo) {
    const Workplace place;
    const Outcome outcome = photic(place, {"bake", "x.toml", "--progress=json", "--frob"});
    EXPECT_EQ(outcome.code, 2);
    ASSERT_EQ(outcome.events().size(), 1U);
    EXPECT_EQ(outcome.events()[0]["code"], 2);
}

}  // namespace
}  // namespace photic::test
