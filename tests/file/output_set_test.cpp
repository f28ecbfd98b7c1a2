// SPDX-License-Identifier: Apache-2.0
#include "bake/file/output_set.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "bake/file/sidecar.h"
#include "bake/report/error.h"
#include "tests/file/file_test_support.h"

namespace photic {
namespace {

namespace fs = std::filesystem;

/// The error that `body` ends with.
template <class Body>
Error errorOf(const Body& body) {
    try {
        body();
    } catch (const Error& error) {
        return error;
    }
    ADD_FAILURE() << "nothing was refused";
    return {ErrorCode::Cancelled, ""};
}

TEST(OutputSet, AnOutputThatIsAnInputIsRefusedWhateverItIsCalled) {
    const TemporaryFolder folder;
    writeBytes(folder / "scene.toml", "a scene");
    writeBytes(folder / "water.obj", "a mesh");
    fs::create_directory(folder / "sub");
    fs::create_symlink("water.obj", folder / "link.obj");
    fs::create_symlink(".", folder / "here");
    fs::create_hard_link(folder / "water.obj", folder / "hard.obj");
    for (const char* name :
         {"water.obj", "./water.obj", "sub/../water.obj", "link.obj", "here/water.obj", "here/link.obj", "hard.obj"}) {
        // Whichever is known first.
        for (const bool reads_first : {true, false}) {
            OutputSet outputs;
            const Error error = errorOf([&] {
                if (reads_first) outputs.reads("a file of the scene", {folder / "scene.toml", folder / "water.obj"});
                outputs.writes("the report", folder / name);
                outputs.reads("a file of the scene", {folder / "scene.toml", folder / "water.obj"});
            });
            EXPECT_EQ(error.code(), ErrorCode::Usage);
            const std::string words = error.what();
            EXPECT_NE(words.find("a file of the scene and the report are one file"), std::string::npos) << words;
            EXPECT_EQ(error.where(), folder / name);
        }
    }
    EXPECT_EQ(bytesOf(folder / "water.obj"), "a mesh");
}

TEST(OutputSet, TwoOutputsThatAreOneFileAreRefused) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "sub");
    fs::create_symlink(".", folder / "here");
    fs::create_symlink("a.vdb", folder / "link.vdb");  // to nothing yet
    for (const char* name : {"a.vdb", "sub/../a.vdb", "here/a.vdb", "link.vdb"}) {
        OutputSet outputs;
        outputs.writes("the volume", folder / "a.vdb");
        outputs.writes("another file", folder / "b.vdb");
        EXPECT_EQ(errorOf([&] { outputs.writes("the report", folder / name); }).code(), ErrorCode::Usage) << name;
    }
    // Frames that are alike may be stored once: writing one leaves the other.
    writeBytes(folder / "1.vdb", "still water");
    fs::create_hard_link(folder / "1.vdb", folder / "2.vdb");
    OutputSet outputs;
    outputs.writes("the volume", folder / "1.vdb");
    outputs.writes("the volume", folder / "2.vdb");
    outputs.write(folder / "1.vdb", "waves");
    outputs.commit();
    EXPECT_EQ(bytesOf(folder / "1.vdb"), "waves");
    EXPECT_EQ(bytesOf(folder / "2.vdb"), "still water");
}

TEST(OutputSet, WhatCannotBeWrittenIsRefusedBeforeWork) {
    const TemporaryFolder folder;
    OutputSet outputs;
    for (const std::string& path :
         {std::string("/dev/full"), std::string("/dev/null"), folder / "", std::string("/dev/null/no/a")}) {
        EXPECT_EQ(errorOf([&] { outputs.writes("the report", path); }).code(), ErrorCode::Failed) << path;
    }
}

TEST(OutputSet, AGroupAppearsTogether) {
    const TemporaryFolder folder;
    writeBytes(folder / "a", "old a");
    writeBytes(folder / "b", "old b");
    OutputSet outputs;
    outputs.write(folder / "a", "new a");
    outputs.write(folder / "b", "new b");
    outputs.write(folder / "c", "new c");
    EXPECT_EQ(outputs.pendingBytes(folder / "c"), 5);
    EXPECT_EQ(bytesOf(folder / "a"), "old a");
    EXPECT_EQ(bytesOf(folder / "b"), "old b");
    EXPECT_FALSE(fs::exists(folder / "c"));
    outputs.commit();
    EXPECT_EQ(bytesOf(folder / "a"), "new a");
    EXPECT_EQ(bytesOf(folder / "b"), "new b");
    EXPECT_EQ(bytesOf(folder / "c"), "new c");
    EXPECT_EQ(folder.fileCount(), 3u);
    // Another group, of which nothing comes.
    outputs.write(folder / "a", "newer a");
    outputs.discard();
    outputs.write(folder / "b", "newer b");
    outputs.commit();
    EXPECT_EQ(bytesOf(folder / "a"), "new a");
    EXPECT_EQ(bytesOf(folder / "b"), "newer b");
    EXPECT_EQ(folder.fileCount(), 3u);
}

TEST(OutputSet, AFailureLeavesAllOldFiles) {
    const TemporaryFolder folder;
    writeBytes(folder / "a", "old a");
    ASSERT_EQ(::chmod((folder / "a").c_str(), 0640), 0);
    OutputSet outputs;
    for (const char* name : {"a", "b", "c"}) outputs.write(folder / name, "new");
    // Someone makes a folder where the last would go: its rename fails after two have gone well.
    fs::create_directory(folder / "c");
    EXPECT_EQ(errorOf([&] { outputs.commit(); }).code(), ErrorCode::Failed);
    EXPECT_EQ(bytesOf(folder / "a"), "old a");
    EXPECT_EQ(fs::status(folder / "a").permissions(), fs::perms(0640));
    EXPECT_FALSE(fs::exists(folder / "b"));
    outputs.discard();
    EXPECT_EQ(folder.fileCount(), 2u);
}

TEST(OutputSet, AFileThatItsWriterDidNotFinishIsNeverRenamed) {
    const TemporaryFolder folder;
    OutputSet outputs;
    outputs.open(folder / "a").stream() << "half";
    EXPECT_THROW(outputs.commit(), std::logic_error);
    outputs.discard();
    EXPECT_EQ(folder.fileCount(), 0u);
}

TEST(OutputSet, OnlyASidecarIsReplacedAsOne) {
    const TemporaryFolder folder;
    const auto claim = [&](const std::string& name) {
        OutputSet outputs;
        outputs.writesBeside("the sidecar", folder / name, isSidecar);
    };
    writeBytes(folder / "report.json", R"({"mine": 1})");
    writeBytes(folder / "text.json", "no JSON at all");
    writeBytes(folder / "list.json", "[1, 2]");
    writeBytes(folder / "atlas.json", R"({"photic_atlas": 1})");
    writeBytes(folder / "texture.json", R"({"texture": "a.dds", "world_from_texture": []})");
    for (const char* name : {"report.json", "text.json", "list.json"}) {
        const Error error = errorOf([&] { claim(name); });
        EXPECT_EQ(error.code(), ErrorCode::Usage) << name;
        EXPECT_NE(std::string(error.what()).find("the sidecar would replace"), std::string::npos) << error.what();
    }
    for (const char* name : {"atlas.json", "texture.json", "none_yet.json"}) EXPECT_NO_THROW(claim(name)) << name;
    writeBytes(folder / "a_rgb.dds", "DDS and so on");
    writeBytes(folder / "b_rgb.dds", "a letter");
    EXPECT_TRUE(isTexture(folder / "a_rgb.dds"));
    EXPECT_FALSE(isTexture(folder / "b_rgb.dds"));
}

}  // namespace
}  // namespace photic
