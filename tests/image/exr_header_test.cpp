// SPDX-License-Identifier: Apache-2.0
// Headers of EXR files by which OpenEXR would take gigabytes: they are refused before it sees them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "bake/image/image.h"
#include "bake/report/error.h"

namespace photic {
namespace {

namespace fs = std::filesystem;

class ExrHeader : public testing::Test {
protected:
    void SetUp() override {
        std::string name = (fs::temp_directory_path() / "photic_header_XXXXXX").string();
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        folder_ = name;
    }
    void TearDown() override { fs::remove_all(folder_); }

    /// What is said of a file of these bytes; empty when it is read.
    std::string refusal(const std::string& bytes) const {
        const std::string path = (folder_ / "a.exr").string();
        std::ofstream(path, std::ios::binary) << bytes;
        try {
            exrChannelNames(path);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
            return error.what();
        }
        return {};
    }

    fs::path folder_;
};

const std::string kStart("\x76\x2f\x31\x01\x02\0\0\0", 8);
const std::string kChannel("Y\0\x02\0\0\0\0\0\0\0\x01\0\0\0\x01\0\0\0", 18);
const std::string kLongOne("a\0string\0\xff\xff\xff\x60", 13);  // 1.6 GB

// 38 bytes that made OpenEXR take 1.8 GB for an attribute that is not there, without their end.
TEST_F(ExrHeader, ThatSaysTooMuchIsRefusedBeforeItTakesMemory) {
    const std::string bytes(
        "\x76\x2f\x31\x01\x02\0\0\0chan\0list\0\x73\0\xff\x63"
        "chl",
        25);
    EXPECT_NE(refusal(bytes).find("truncated (25 bytes): an attribute of its header is said to be 1677656179 bytes"),
              std::string::npos)
        << refusal(bytes);
    EXPECT_NE(refusal(kStart + kLongOne).find("is said to be 1627389951 bytes"), std::string::npos);
}

// OpenEXR goes by what attributes hold: the one that is said to be long begins where theirs end.
TEST_F(ExrHeader, WhoseAttributesHaveOtherLengthsThanTheirContentsIsRefused) {
    const std::string list("channels\0chlist\0\x12\0\0\0", 20);
    for (const std::string& bytes : {kStart + list + kChannel + kChannel + '\0' + kLongOne, kStart + list + kChannel})
        EXPECT_NE(refusal(bytes).find("of the type chlist is said to be 18 bytes long"), std::string::npos)
            << refusal(bytes);
    const std::string number("n\0int\0\x05\0\0\0\0\0\0\0", 14);
    EXPECT_NE(refusal(kStart + number + kLongOne).find("of the type int is said to be 5 bytes long"), std::string::npos)
        << refusal(kStart + number + kLongOne);
}

}  // namespace
}  // namespace photic
