// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "bake/scene/load_toml.h"

namespace photic::test {

/// Keeps warnings.
class Warnings final : public Monitor {
public:
    void warn(const std::string& message) override { messages.push_back(message); }
    std::vector<std::string> messages;
};

/// A scene in its shortest form, in parts that a test replaces.
struct SceneText {
    std::string head = "photic = 1\n";
    std::string domain = "[domain]\nmin = [-1, -1, -2]\nmax = [1, 1, 0.5]\nvoxel_size = 0.1\n";
    std::string light = "[[light]]\ntype = \"sun\"\ndirection = [0, 0, -1]\n";
    std::string surface = "[[surface]]\nname = \"water\"\nflat = true\nsize = [4, 4]\n";
    std::string rest;
    std::string all() const { return head + domain + light + surface + rest; }
};

/// Scenes from text, beside files in a temporary directory.
class SceneTest : public testing::Test {
protected:
    void SetUp() override {
        std::string name = (std::filesystem::temp_directory_path() / "photic_scene_XXXXXX").string();
        ASSERT_NE(mkdtemp(name.data()), nullptr);
        directory_ = name;
    }
    void TearDown() override { std::filesystem::remove_all(directory_); }
    std::string path(const std::string& name) const { return (directory_ / name).string(); }
    void write(const std::string& name, const std::string& bytes) const {
        std::ofstream(path(name), std::ios::binary) << bytes;
    }

    Scene load(const std::string& text, int frame = 0) {
        return parseScene(text, "s.toml", directory_.string(), frame, warnings_);
    }
    Scene load(const SceneText& text, int frame = 0) { return load(text.all(), frame); }

    /// Expects an input error at `where` (a place, or its beginning) whose message has all `words`.
    void refused(const std::string& text, const std::string& where, const std::vector<std::string>& words) {
        try {
            load(text);
            ADD_FAILURE() << "nothing was thrown for\n" << text;
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
            EXPECT_EQ(error.where().substr(0, where.size()), where) << error.what();
            for (const std::string& word : words)
                EXPECT_NE(std::string(error.what()).find(word), std::string::npos)
                    << "'" << word << "' in: " << error.what();
        }
    }
    void refused(const SceneText& text, const std::string& where, const std::vector<std::string>& words) {
        refused(text.all(), where, words);
    }
    /// The same for a [[surface]] whose keys are `keys`, one a line; the first is on line 10.
    void refusedSurface(const std::string& keys, const std::string& where, const std::vector<std::string>& words) {
        SceneText text;
        text.surface = "[[surface]]\n" + keys + "\n";
        refused(text, where, words);
    }
    Scene loadSurfaceKeys(const std::string& keys, int frame = 0) {
        SceneText text;
        text.surface = "[[surface]]\n" + keys + "\n";
        return load(text, frame);
    }

    std::filesystem::path directory_;
    Warnings warnings_;
};

}  // namespace photic::test
