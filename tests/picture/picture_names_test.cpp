// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/picture_names.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <set>
#include <string>
#include <vector>

#include "bake/report/printable.h"

namespace photic {
namespace {

TEST(PictureNames, PlainNamesAreFileNames) {
    for (const char* name :
         {"floor", "a_b", "east wall", "Boden (süd)", "maps", "striped", "slices", "日本", "-", "..."})
        EXPECT_EQ(receiverFileName(name), name);
}

TEST(PictureNames, NoTwoReceiversShareAFile) {
    const std::string longest(300, 'n');
    const std::vector<std::string> names{"a/b",
                                         "a_b",
                                         "a//b",
                                         "a_/b",
                                         std::string("a\0b", 3),
                                         "a\nb",
                                         "a\x1b[31mb",
                                         "a\x7f"
                                         "b",
                                         "a\xc2\x9b"
                                         "b",
                                         "a\xff"
                                         "b",
                                         "a\xe2\x80\xae"
                                         "b",
                                         "floor_map",
                                         "floor",
                                         "view",
                                         "slice_z=0",
                                         "xray_y",
                                         "floor_strip",
                                         "../up",
                                         "/",
                                         "",
                                         longest,
                                         longest + "1",
                                         longest + "2"};
    std::set<std::string> files;
    for (const std::string& name : names) {
        const std::string file = receiverFileName(name);
        EXPECT_TRUE(files.insert(file).second) << file;
        EXPECT_EQ(file, receiverFileName(name));
        EXPECT_LE(file.size(), 120u);
        EXPECT_EQ(file.find('/'), std::string::npos);
        EXPECT_EQ(printable(file), file);
        EXPECT_FALSE(file.ends_with("_map") || file.ends_with("_strip") || file == "view") << file;
        // A name that was made from another must not be one that stays as it is.
        EXPECT_EQ(std::count(names.begin(), names.end(), file), file == name ? 1 : 0) << file;
    }
}

// Disks of Windows and of macOS take "Floor" and "floor" for one file; a volume's pictures may be carried to one.
TEST(PictureNames, CapitalsAloneTellNoFilesApart) {
    const std::vector<std::string> all{"Floor", "floor", "FLOOR", "wall", "Wand \xc3\x84", "wand \xc3\x84"};
    std::set<std::string> files;
    for (const std::string& name : all) {
        std::string file = receiverFileName(name, all);
        EXPECT_EQ(file == name, name == "wall") << file;
        std::transform(file.begin(), file.end(), file.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        EXPECT_TRUE(files.insert(file).second) << file;
    }
    EXPECT_EQ(receiverFileName("Floor", {"Floor", "wall"}), "Floor");
}

TEST(PictureNames, WhatWindowsKeepsForItselfIsReplaced) {
    std::set<std::string> files;
    for (const char c : std::string("<>:\"\\|?*/")) {
        const std::string file = receiverFileName(std::string("a") + c + "b");
        EXPECT_EQ(file.substr(0, 4), "a_b-") << file;
        EXPECT_TRUE(files.insert(file).second) << file;
    }
}

TEST(Printable, ShowsWhatATerminalWouldActOn) {
    EXPECT_EQ(printable("Höhe 3 µm, 日本"), "Höhe 3 µm, 日本");
    EXPECT_EQ(printable("\x1b[2J\n\t"), "\\x1b[2J\\x0a\\x09");
    EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
    EXPECT_EQ(printable("\xc2\x9b"
                        "31m"),
              "\\xc2\\x9b31m");  // the one-character form of ESC [
    EXPECT_EQ(printable("\xe2\x80\xae"
                        "gpj"),
              "\\xe2\\x80\\xaegpj");  // turns the direction of writing
    EXPECT_EQ(printable("\xff\xc3"), "\\xff\\xc3");
}

}  // namespace
}  // namespace photic
