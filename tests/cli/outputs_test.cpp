// SPDX-License-Identifier: Apache-2.0
// What a verb may write onto, and what is left of files when it may not.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "bake/image/image.h"
#include "tests/cli/program.h"

namespace photic::test {
namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

/// Every file of a workplace, with its bytes.
std::map<std::string, std::string> contents(const Workplace& place) {
    std::map<std::string, std::string> files;
    for (const std::string& name : place.names())
        if (fs::is_regular_file(place / name)) files[name] = place.read(name);
    return files;
}

/// The command is refused with `code`, says `word`, and changes no file.
void expectRefused(const Workplace& place, const Strings& command, int code, const std::string& word) {
    const auto before = contents(place);
    const Outcome outcome = photic(place, command);
    EXPECT_EQ(outcome.code, code) << command[0] << ": " << outcome.err;
    EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    EXPECT_EQ(contents(place), before) << command[0] << ": " << outcome.err;
}

void bakePool(const Workplace& place, const PoolText& pool = {}) {
    place.write("pool.toml", pool.text());
    const Outcome baked = photic(place, {"bake", "pool.toml"});
    ASSERT_EQ(baked.code, 0) << baked.err;
}

Image flatImage(int side, float value) {
    Image image{side, side, 1, {}};
    image.pixels.assign(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), value);
    return image;
}

TEST(Outputs, NoVerbWritesOntoWhatItReads) {
    const Workplace place;
    bakePool(place);
    writeExr((place / "a.exr").string(), flatImage(8, 1));
    fs::copy(place / "a.exr", place / "b.exr");
    fs::copy(place / "pool.vdb", place / "pool.nvdb");
    fs::create_symlink("pool.vdb", place / "link.vdb");
    fs::create_symlink("a.exr", place / "a.png");
    const std::string words = "are one file";
    expectRefused(place, {"export", "pool.nvdb", "-o", "pool.nvdb"}, 2, words);
    expectRefused(place, {"compare", "a.exr", "b.exr", "--difference", "a.exr"}, 2, words);
    expectRefused(place, {"compare", "a.exr", "b.exr", "--difference", "./b.exr"}, 2, words);
    expectRefused(place, {"compare", "a.exr", "b.exr", "--difference", "a.png"}, 2, words);
    expectRefused(place, {"post", "pool.vdb", "--step", "sharpen=1,2", "-o", "pool.vdb"}, 2, words);
    expectRefused(place, {"post", "pool.vdb", "--step", "sharpen=1,2", "-o", "link.vdb"}, 2, words);
    EXPECT_TRUE(fs::is_symlink(place / "link.vdb"));
}

TEST(Outputs, APictureDoesNotReplaceWhatTheSceneReads) {
    const Workplace place;
    PoolText pool;
    pool.surface = "file = \"o_floor.exr\"";
    writeExr((place / "o_floor.exr").string(), flatImage(8, 0));
    place.write("e.toml", pool.text());
    ASSERT_EQ(photic(place, {"bake", "e.toml", "-o", "o.vdb"}).code, 0);
    expectRefused(place, {"picture", "e.toml", "o.vdb"}, 2, "o_floor.exr");
    // Elsewhere there is room.
    EXPECT_EQ(photic(place, {"picture", "e.toml", "o.vdb", "-o", "pictures", "--resolution", "16"}).code, 0);
    EXPECT_TRUE(place.has("pictures/o_floor.exr"));
}

TEST(Outputs, ABakeDoesNotReplaceWhatItReads) {
    const Workplace place;
    PoolText pool;
    pool.surface = "file = \"heights.exr\"";
    pool.extra = "[[object]]\nname = \"rock\"\nfile = \"rock.obj\"\n";
    writeExr((place / "heights.exr").string(), flatImage(8, 0));
    place.write("rock.obj", "v -0.2 -0.2 -0.6\nv 0.2 -0.2 -0.6\nv 0 0.2 -0.6\nf 1 2 3\n");
    place.write("pool.toml", pool.text());
    fs::create_symlink("rock.obj", place / "report.json");
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    for (const char* input : {"heights.exr", "rock.obj", "./rock.obj", "report.json", "pool.toml", "pool.vdb"})
        expectRefused(place, {"bake", "pool.toml", "--report", input}, 2, "one file");
    // A device would fail, or swallow all, only after the bake.
    expectRefused(place, {"bake", "pool.toml", "--report", "/dev/full"}, 4, "device");
    expectRefused(place, {"bake", "pool.toml", "--frames", "1-2", "--report", "pool.0002.vdb"}, 2, "one file");
}

TEST(Outputs, AKilledBakeDoesNotBlockItsRetry) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 64;
    place.write("pool.toml", pool.text());
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    const auto duration = Clock::now() - start;
    const auto end = Clock::now() + std::chrono::seconds(30);
    const auto whole = contents(place);
    // What former versions left, with a process number that none has.
    place.write(".pool.vdb.4194305-0.tmp", "half");
    place.write("pool.vdb.4194305.part", "half");
    for (int step = 12; step <= 24 && Clock::now() < end; ++step) {
        Program program(place, {"bake", "pool.toml"});
        std::this_thread::sleep_for(duration * step / 24);
        kill(program.pid(), SIGKILL);
        program.wait();
        ASSERT_EQ(place.read("pool.vdb"), whole.at("pool.vdb")) << step;
    }
    ASSERT_EQ(photic(place, {"bake", "pool.toml"}).code, 0);
    EXPECT_EQ(contents(place), whole);
}

TEST(Outputs, AStandardErrorThatIsGoneIsBakedAgain) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    const Strings command{"bake",  "pool.toml",           "--frames",         "1-1",   "--method", "photons",
                          "--set", "photons.count=20000", "--standard-error", "se.vdb"};
    ASSERT_EQ(photic(place, command).code, 0);
    const auto whole = contents(place);
    EXPECT_NE(photic(place, command).err.find("unchanged"), std::string::npos);
    fs::remove(place / "se.0001.vdb");
    ASSERT_EQ(photic(place, command).code, 0);
    EXPECT_EQ(contents(place), whole);
}

TEST(Outputs, SidecarsOfEveryFormatLieBesideOneAnother) {
    const Workplace place;
    bakePool(place);
    place.write("pool.json", R"({"mine": 1})");
    std::map<std::string, std::string> sidecars;
    for (const std::string ending : {"dds", "vf", "exr", "ktx2", "nvdb"}) {
        const Outcome outcome = photic(place, {"export", "pool.vdb", "-o", "pool." + ending});
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        if (ending == "ktx2" || ending == "nvdb") continue;
        sidecars["pool." + ending + ".json"] = place.read("pool." + ending + ".json");
    }
    EXPECT_EQ(place.read("pool.json"), R"({"mine": 1})");
    for (const auto& [name, bytes] : sidecars) EXPECT_EQ(place.read(name), bytes) << name;
    EXPECT_EQ(nlohmann::json::parse(sidecars.at("pool.dds.json"))["handedness"], "right");
    EXPECT_EQ(nlohmann::json::parse(sidecars.at("pool.vf.json"))["handedness"], "left");
    EXPECT_TRUE(nlohmann::json::parse(sidecars.at("pool.exr.json")).contains("photic_atlas"));
    // Once more over its own files, and never over another's.
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "pool.dds"}).code, 0);
    place.write("pool.exr.json", R"({"mine": 2})");
    expectRefused(place, {"export", "pool.vdb", "-o", "pool.exr"}, 2, "sidecar");
    place.write("pool_flux.vf", "a letter");
    expectRefused(place, {"export", "pool.vdb", "-o", "pool.vf"}, 2, "flux");
}

TEST(Outputs, ASetThatCannotBeWrittenWhollyIsNotWrittenAtAll) {
    const Workplace place;
    bakePool(place);
    for (const std::string name : {"a.dds", "a.vf", "a.exr"})
        ASSERT_EQ(photic(place, {"export", "pool.vdb", "-o", name}).code, 0);
    // Room for the small files of each set, and not for the large one.
    const auto before = contents(place);
    for (const std::string name : {"a.dds", "a.vf", "a.exr"}) {
        const auto sidecar = static_cast<std::int64_t>(before.at(name + ".json").size());
        EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", name}, sidecar + 4096).code, 4) << name;
        EXPECT_EQ(contents(place), before) << name;
    }
    const auto smallest = [&] {
        std::int64_t bytes = 1 << 30;
        for (const auto& [name, text] : contents(place))
            if (name.starts_with("pool_")) bytes = std::min(bytes, static_cast<std::int64_t>(text.size()));
        return bytes;
    };
    ASSERT_EQ(photic(place, {"picture", "pool.toml", "pool.vdb", "--resolution", "64"}).code, 0);
    const auto pictures = contents(place);
    EXPECT_EQ(photic(place, {"picture", "pool.toml", "pool.vdb", "--resolution", "64"}, smallest() + 100).code, 4);
    EXPECT_EQ(contents(place), pictures);
}

TEST(Outputs, WhatIsNoFileIsRefusedBeforeTheWork) {
    const Workplace place;
    bakePool(place);
    ASSERT_EQ(::mkfifo((place / "pipe.nvdb").c_str(), 0600), 0);
    fs::create_symlink("/dev/full", place / "full.vdb");
    writeExr((place / "a.exr").string(), flatImage(8, 1));
    expectRefused(place, {"export", "pool.vdb", "-o", "pipe.nvdb"}, 4, "pipe");
    expectRefused(place, {"post", "pool.vdb", "--step", "sharpen=1,2", "-o", "full.vdb"}, 4, "device");
    expectRefused(place, {"compare", "a.exr", "a.exr", "--difference", "/dev/full"}, 4, "device");
    expectRefused(place, {"export", "pool.vdb", "-o", "a.exr/a.nvdb"}, 4, "directory");
}

TEST(Outputs, FoldersAreMade) {
    const Workplace place;
    bakePool(place);
    EXPECT_EQ(photic(place, {"export", "pool.vdb", "-o", "new/er/a.nvdb"}).code, 0);
    EXPECT_TRUE(place.has("new/er/a.nvdb"));
}

TEST(Outputs, LinksAreFollowedAndPermissionsKept) {
    const Workplace place;
    bakePool(place);
    fs::create_directory(place / "store");
    place.write("store/a.nvdb", "old");
    ASSERT_EQ(::chmod((place / "store/a.nvdb").c_str(), 0604), 0);
    fs::create_symlink("store/a.nvdb", place / "a.nvdb");
    ASSERT_EQ(photic(place, {"export", "pool.vdb", "-o", "a.nvdb"}).code, 0);
    EXPECT_TRUE(fs::is_symlink(place / "a.nvdb"));
    EXPECT_NE(place.read("store/a.nvdb"), "old");
    EXPECT_EQ(fs::status(place / "store/a.nvdb").permissions(), fs::perms(0604));
    EXPECT_EQ(std::distance(fs::directory_iterator(place / "store"), {}), 1);
}

/// Kills an export at one moment after another, bounded in number and time, and looks at what it leaves.
TEST(Outputs, KilledRunsLeaveWholeFilesAndTheNextOneSweeps) {
    const Workplace place;
    PoolText pool;
    pool.voxel_size = 2.0 / 48;
    bakePool(place, pool);
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    ASSERT_EQ(photic(place, {"export", "pool.vdb", "-o", "a.vf"}).code, 0);
    const auto duration = Clock::now() - start;
    const auto end = Clock::now() + std::chrono::seconds(30);
    const auto whole = contents(place);
    int killed = 0;
    for (int step = 1; step <= 24 && Clock::now() < end; ++step) {
        Program program(place, {"export", "pool.vdb", "-o", "a.vf"});
        std::this_thread::sleep_for(duration * step / 24);
        kill(program.pid(), SIGKILL);
        const bool was_killed = program.wait().code == 1000 + SIGKILL;
        killed += was_killed;
        // Equal volumes give equal bytes, so that each file must be what it was.
        auto now = contents(place);
        std::erase_if(now, [](const auto& file) { return file.first.starts_with("."); });
        ASSERT_EQ(now, whole) << step;
    }
    EXPECT_GT(killed, 0);
    ASSERT_EQ(photic(place, {"export", "pool.vdb", "-o", "a.vf"}).code, 0);
    EXPECT_EQ(contents(place), whole);
}

TEST(Outputs, APipeAsAnInputIsRefusedInsteadOfWaiting) {
    const Workplace place;
    bakePool(place);
    for (const char* name : {"pipe.toml", "pipe.vdb", "pipe.exr"}) ASSERT_EQ(::mkfifo((place / name).c_str(), 0600), 0);
    for (const Strings& command :
         {Strings{"bake", "pipe.toml", "-o", "a.vdb"}, Strings{"inspect", "pipe.vdb"},
          Strings{"compare", "pool.vdb", "pipe.vdb"}, Strings{"compare", "pipe.exr", "pipe.exr"},
          Strings{"picture", "pool.toml", "pipe.vdb"}, Strings{"export", "pipe.vdb", "-o", "a.nvdb"}}) {
        const Outcome outcome = photic(place, command);
        EXPECT_EQ(outcome.code, 3) << command[0] << ' ' << outcome.err;
        EXPECT_NE(outcome.err.find("a device or a pipe"), std::string::npos) << outcome.err;
    }
}

TEST(Outputs, ReceiversHaveAFileEach) {
    const Workplace place;
    PoolText pool;
    // A slash, what it used to become, the pictures' own endings, a way out of the folder, and a very long name.
    Strings receivers{"a/b", "a_b", "floor_map", "view", "../up", std::string(300, 'n')};
    for (std::size_t i = 0; i < receivers.size(); ++i)
        pool.extra += "[[object]]\nname = \"" + receivers[i] + "\"\nrole = \"movable\"\nplane = { point = [0, 0, -0." +
                      std::to_string(i + 1) + "], normal = [0, 0, 1] }\n";
    place.write("pool.toml", pool.text());
    const Outcome baked = photic(place, {"bake", "pool.toml"});
    ASSERT_EQ(baked.code, 0) << baked.err;
    const Outcome outcome = photic(place, {"picture", "pool.toml", "pool.vdb", "-o", "p", "--resolution", "16"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    std::set<std::string> names, bytes;
    for (const auto& entry : fs::directory_iterator(place / "p")) {
        const std::string name = entry.path().filename().string();
        ASSERT_TRUE(std::all_of(name.begin(), name.end(), [](unsigned char c) { return c >= 0x20 && c != 0x7f; }));
        names.insert(name);
        if (name.ends_with(".exr")) bytes.insert(place.read("p/" + name));
    }
    // Three files for each receiver, the floor included, and two of the x-ray.
    EXPECT_EQ(names.size(), 3 * (receivers.size() + 1) + 2);
    EXPECT_EQ(bytes.size(), receivers.size() + 2);
    EXPECT_TRUE(names.count("pool_a_b.exr"));
    EXPECT_TRUE(names.count("pool_floor.exr"));
    EXPECT_FALSE(place.has("up.exr"));
    EXPECT_EQ(outcome.err.find('\x1b'), std::string::npos);
    // A receiver alone has the file that it has among the others.
    fs::remove_all(place / "p");
    ASSERT_EQ(photic(place, {"picture", "pool.toml", "pool.vdb", "-o", "p", "--resolution", "16", "--receiver", "a/b",
                             "--receiver", "a/b"})
                  .code,
              0);
    for (const auto& entry : fs::directory_iterator(place / "p"))
        EXPECT_TRUE(names.count(entry.path().filename().string())) << entry.path();
    EXPECT_FALSE(place.has("p/pool_a_b.exr"));
}

TEST(Outputs, MessagesDoNotSpeakToTheTerminal) {
    const Workplace place;
    bakePool(place);
    const Outcome outcome = photic(place, {"picture", "pool.toml", "pool.vdb", "--receiver", "\x1b[2Jgone\nnext"});
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.err.find('\x1b'), std::string::npos);
    EXPECT_NE(outcome.err.find("\\x1b[2Jgone\\x0anext"), std::string::npos) << outcome.err;
}

// As when a farm hands one frame to two machines: whichever is last, the file is whole, and both say that all is well.
TEST(Outputs, TwoBakesOfOneFileAtOnceLeaveItWhole) {
    const Workplace place;
    place.write("pool.toml", PoolText{}.text());
    ASSERT_EQ(photic(place, {"bake", "pool.toml", "-o", "alone.vdb"}).code, 0);
    for (int times = 0; times < 3; ++times) {
        Program one(place, {"bake", "pool.toml", "-o", "pool.vdb"}),
            two(place, {"bake", "pool.toml", "-o", "pool.vdb"});
        EXPECT_EQ(one.wait().code, 0);
        EXPECT_EQ(two.wait().code, 0);
        EXPECT_TRUE(place.read("pool.vdb") == place.read("alone.vdb"));
        EXPECT_EQ(place.names(), (Strings{"alone.vdb", "pool.toml", "pool.vdb"}));
    }
}

}  // namespace
}  // namespace photic::test
