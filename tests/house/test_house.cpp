// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "tests/house/house_rules.h"

namespace photic::house {
namespace {

namespace fs = std::filesystem;

const fs::path kSource = PHOTIC_SOURCE_DIR;

std::string inWords(const std::vector<Breach>& breaches) {
    std::string out;
    for (const auto& b : breaches) out += b.file + ":" + std::to_string(b.line) + ": " + b.what + "\n";
    return out;
}

/// A made-up tree in a temporary folder, removed at the end.
class MadeUpHouse : public testing::Test {
protected:
    void SetUp() override {
        root_ = fs::temp_directory_path() / ("photic_house_" + std::to_string(::getpid()));
        fs::remove_all(root_);
    }
    void TearDown() override { fs::remove_all(root_); }

    void write(const std::string& name, const std::string& text) {
        fs::create_directories((root_ / name).parent_path());
        std::ofstream(root_ / name) << text;
    }

    fs::path root_;
};

// The tree as it stands.

TEST(House, NoIncludeGoesBack) { EXPECT_EQ(inWords(backArrows(kSource)), ""); }

TEST(House, NoLinkGoesBack) { EXPECT_EQ(inWords(linksAgainstArrows(kSource)), ""); }

TEST(House, ArrowsHaveNoCycle) {
    // Rooms in an order in which each uses only earlier ones.
    std::set<std::string> placed;
    bool progress = true;
    while (progress) {
        progress = false;
        for (const auto& [room, uses] : arrows()) {
            if (placed.count(room)) continue;
            bool ready = true;
            for (const auto& u : uses) ready = ready && placed.count(u);
            if (ready) progress = placed.insert(room).second || progress;
        }
    }
    EXPECT_EQ(placed.size(), arrows().size());
}

TEST(House, FewFilesIncludeOpenVdb) {
    const auto files = filesIncludingOpenVdb(kSource);
    std::string names;
    for (const auto& f : files) names += f + "\n";
    EXPECT_LE(files.size(), 15u) << names;
}

TEST(House, VersionsAreKnownInOnePlace) { EXPECT_EQ(inWords(versionedHeaders(kSource)), ""); }

TEST(House, HeadersAreNamedWhereTheyAreNeeded) { EXPECT_EQ(inWords(missingHeaders(kSource)), ""); }

TEST(House, EverySourceNamesItsLicence) { EXPECT_EQ(inWords(missingLicence(kSource)), ""); }

TEST(House, NoFileIsLongerThan500Lines) { EXPECT_EQ(inWords(longFiles(kSource, 500)), ""); }

TEST(House, EveryRoomSaysWhatItIs) { EXPECT_EQ(inWords(missingReadmes(kSource)), ""); }

TEST(House, NoMethodIsNamedOutsideItsRow) { EXPECT_EQ(inWords(namedMethods(kSource)), ""); }

TEST(House, NoMachinePaths) { EXPECT_EQ(inWords(machinePaths(kSource)), ""); }

TEST(House, TheTreeIsThere) {
    // The rules above would hold for an empty folder too.
    EXPECT_GT(sourceFiles(kSource).size(), 50u);
    for (const auto& [room, uses] : arrows()) {
        if (room == "format" || room == "runtime" || room == "vdb" || room == "headless" || room == "viewer" ||
            room == "numerics")
            continue;
        EXPECT_TRUE(fs::exists(kSource / "bake" / room / "README.md")) << room;
    }
}

// Each rule must be able to fail.

TEST_F(MadeUpHouse, BackArrowIsFound) {
    write("bake/scene/scene.h", "// a\n#include \"bake/image/image.h\"\n#include \"bake/report/error.h\"\n");
    write("bake/tubes/tube.cpp", "#include \"bake/scene/scene.h\"\n");
    EXPECT_EQ(inWords(backArrows(root_)), "");

    write("bake/scene/guilty.cpp", "// one\n  #  include \"bake/tubes/tube.h\"  // why not\n");
    const auto breaches = backArrows(root_);
    ASSERT_EQ(breaches.size(), 1u);
    EXPECT_EQ(breaches[0].file, "bake/scene/guilty.cpp");
    EXPECT_EQ(breaches[0].line, 2);
    EXPECT_NE(breaches[0].what.find("'scene' may not use 'tubes'"), std::string::npos) << breaches[0].what;
}

TEST_F(MadeUpHouse, EveryArrowTurnedRoundIsFound) {
    for (const auto& [from, uses] : arrows()) {
        for (const auto& to : uses) {
            if (to == "format") continue;  // lives in runtime/
            const std::string file = "bake/" + to + "/turned_" + from + ".cpp";
            write(file, "#include <bake/" + from + "/x.h>\n");
            EXPECT_EQ(backArrows(root_).size(), 1u) << file;
            fs::remove(root_ / file);
        }
    }
}

TEST_F(MadeUpHouse, ReportAndFormatUseNothing) {
    write("bake/report/error.h", "#include \"bake/threads/parallel_for.h\"\n");
    write("runtime/format/light_volume_format.h", "#include \"bake/field/light_field.h\"\n");
    EXPECT_EQ(backArrows(root_).size(), 2u);
}

TEST_F(MadeUpHouse, RuntimeUsesNothingOfTheBaker) {
    write("runtime/src/a.cpp", "#include \"runtime/format/f.h\"\n#include \"runtime/include/photic/r.h\"\n");
    EXPECT_EQ(inWords(backArrows(root_)), "");
    write("runtime/src/b.cpp", "#include \"bake/field/light_field.h\"\n");
    write("runtime/include/photic/c.h", "#include \"bake/threads/parallel_for.h\"\n");
    EXPECT_EQ(backArrows(root_).size(), 2u) << inWords(backArrows(root_));
}

TEST_F(MadeUpHouse, UnknownRoomIsFound) {
    write("bake/cellar/a.cpp", "#include \"bake/scene/scene.h\"\n");
    EXPECT_EQ(backArrows(root_).size(), 1u);
    write("bake/cli/a.cpp", "#include \"bake/cellar/a.h\"\n");
    EXPECT_EQ(backArrows(root_).size(), 2u);
}

TEST_F(MadeUpHouse, LinkAgainstTheArrowsIsFound) {
    write("bake/scene/CMakeLists.txt", "photic_room(scene SOURCES a.cpp ROOMS report image)\n");
    EXPECT_EQ(inWords(linksAgainstArrows(root_)), "");
    write("bake/image/CMakeLists.txt",
          "photic_room(image SOURCES a.cpp ROOMS report\n  scene PRIVATE_LIBRARIES fmt::fmt)\n");
    write("bake/optics/CMakeLists.txt", "target_link_libraries(x PRIVATE photic_build_flags photic_field)\n");
    EXPECT_EQ(linksAgainstArrows(root_).size(), 2u) << inWords(linksAgainstArrows(root_));
}

TEST_F(MadeUpHouse, OpenVdbIsCounted) {
    write("bake/file/vdb.cpp", "#include <openvdb/openvdb.h>\n#include <openvdb/io/File.h>\n");
    write("bake/file/other.cpp", "// #include <openvdb/openvdb.h> is not here\n");
    write("bake/file/thin.cpp", "#include \"bake/libraries/openvdb.h\"\n");
    EXPECT_EQ(filesIncludingOpenVdb(root_), (std::vector<std::string>{"bake/file/thin.cpp", "bake/file/vdb.cpp"}));
}

TEST_F(MadeUpHouse, VersionedHeaderIsFound) {
    write("bake/libraries/toml.h", "#include <toml++/toml.h>\n");
    write("runtime/viewer/imgui_headers.h", "#include <imgui/imgui.h>\n");
    write("tests/file/a.cpp", "#include <openvdb/tools/Interpolation.h>\n#include \"bake/libraries/toml.h\"\n");
    EXPECT_EQ(inWords(versionedHeaders(root_)), "");
    write("bake/scene/a.cpp", "#include <fmt/format.h>\n#include <toml++/toml.h>\n#include <tiny_gltf.h>\n");
    write("runtime/viewer/c.cpp", "#include <imgui/imgui.h>\n");
    write("tests/file/b.cpp", "#include <openvdb/openvdb.h>\n#include <openvdb/io/File.h>\n");
    write("bake/file/c.cpp", "#include <nanovdb/util/IO.h>\n#include <embree3/rtcore.h>\n");
    EXPECT_EQ(versionedHeaders(root_).size(), 7u);
    const std::string join = std::string("std::string t = fmt::") + "join(names, \", \");\n";
    write("bake/scene/joined.cpp", "#include <fmt/format.h>\n#include <fmt/ranges.h>\n" + join);
    EXPECT_EQ(versionedHeaders(root_).size(), 7u);
    write("bake/scene/joined.cpp", "#include <fmt/format.h>\n" + join);
    EXPECT_EQ(versionedHeaders(root_).size(), 8u);
    const std::string expressions = std::string("#include <") + "regex>\n";
    write("tests/house/rules.cpp", expressions);
    EXPECT_EQ(versionedHeaders(root_).size(), 8u);
    write("tests/scene/names.cpp", expressions);
    EXPECT_EQ(versionedHeaders(root_).size(), 9u);
}

TEST_F(MadeUpHouse, MissingHeadersAreFound) {
    // In two halves, so that this file is none of its own findings.
    const std::string space = std::string("std") + "::";
    const std::string clamped = space + "clamp(1, 2, 3)", root = space + "sqrt(2.0)", larger = space + "max(1, 2)";
    write("bake/scene/a.h", "#include <algorithm>\n#include <vector>\n");
    write("bake/scene/a.cpp", "#include \"bake/scene/a.h\"\nint a = " + clamped + ";  // " + root + "\n");
    EXPECT_EQ(inWords(missingHeaders(root_)), "");
    write("bake/scene/b.cpp", "#include <vector>\nint a = " + larger + ", b = " + larger + ";\n");
    write("bake/scene/c.cpp", "#include <algorithm>\ndouble d = " + root + ", e = " + clamped + ";\n");
    const auto found = missingHeaders(root_);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].file, "bake/scene/b.cpp");
    EXPECT_EQ(found[0].line, 2);
    EXPECT_NE(found[1].what.find("<cmath>"), std::string::npos);
}

TEST_F(MadeUpHouse, MissingLicenceIsFound) {
    const std::string spdx = std::string("SPDX-License-") + "Identifier: ";
    write("bake/a.h", "// " + spdx + "Apache-2.0\n");
    write("scripts/go", "#!/usr/bin/env bash\n# " + spdx + "Apache-2.0\n");
    write("blender_addon/photic/__init__.py", "# " + spdx + "GPL-3.0-or-later\n");
    EXPECT_EQ(inWords(missingLicence(root_)), "");
    write("bake/b.cpp", "int x;\n// too\n// " + spdx + "Apache-2.0\n");
    write("blender_addon/photic/wrong.py", "# " + spdx + "Apache-2.0\n");
    write("CMakeLists.txt", "");
    EXPECT_EQ(missingLicence(root_).size(), 3u);
}

TEST_F(MadeUpHouse, LongFileIsFound) {
    std::string text;
    for (int i = 0; i < 500; ++i) text += "//\n";
    write("bake/a.h", text);
    EXPECT_EQ(inWords(longFiles(root_, 500)), "");
    write("bake/a.h", text + "//\n");
    EXPECT_EQ(longFiles(root_, 500).size(), 1u);
}

TEST_F(MadeUpHouse, MissingReadmeIsFound) {
    write("bake/scene/a.h", "");
    EXPECT_EQ(missingReadmes(root_).size(), 1u);
    write("bake/scene/README.md", "# scene\n");
    EXPECT_EQ(missingReadmes(root_).size(), 1u);
    write("bake/scene/README.md", "# scene\n\nWhat the artist describes.\n");
    EXPECT_EQ(inWords(missingReadmes(root_)), "");
}

TEST_F(MadeUpHouse, NamedMethodIsFound) {
    write("bake/methods/rods.cpp",
          "Method rodsMethod() {\n    return {\"rods\",\n            \"Rods of light\"};\n}\n");
    write("bake/methods/wave.cpp", "Method waveMethod() {\n    return {\"wave\", \"use rods\"};\n}\n");
    write("bake/scene/a.cpp", "// \"rods\" are told here\nthrow Error(\"a wave of 3 m\", \"fishing_rods\");\n");
    EXPECT_EQ(inWords(namedMethods(root_)), "");
    write("bake/cli/a.cpp", "if (name == \"wave\") {}\nsay(\"use rods\");\nsay(\"--set wave.cells=2\");\n");
    EXPECT_EQ(namedMethods(root_).size(), 3u) << inWords(namedMethods(root_));
}

TEST_F(MadeUpHouse, MachinePathIsFound) {
    // In pieces: this file must not hold what the rule looks for either.
    const std::string slash = "/";
    write("README.md", "Run scripts/test; see bake" + slash + "root/x.h, https://example.org" + slash +
                           "home/page and ${TMPDIR:-" + slash + "tmp}.\n");
    EXPECT_EQ(inWords(machinePaths(root_)), "");
    write("docs/a.md", "Look in " + slash + "home/me/photic.\n");
    write("tests/a.cpp", "open(\"" + slash + "tmp/x\");\n");
    EXPECT_EQ(machinePaths(root_).size(), 2u);
}

}  // namespace
}  // namespace photic::house
