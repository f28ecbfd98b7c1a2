// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bake/report/error.h"
#include "bake/report/monitor.h"
#include "bake/scene/load_toml.h"
#include "tests/scene/gltf_text.h"
#include "tests/scene/scene_texts.h"

namespace photic::test {

/// A file with a table, a ball (here a box) and whatever lights a test adds. Y is up.
struct GltfRoom : GltfText {
    GltfRoom() {
        const int positions =
                      add<float>({-1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1, -1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1},
                                 5126, "VEC3"),
                  indices = add<std::uint16_t>({0, 1, 2, 0, 2, 3, 5, 4, 7, 5, 7, 6, 4, 0, 3, 4, 3, 7,
                                                1, 5, 6, 1, 6, 2, 3, 2, 6, 3, 6, 7, 4, 5, 1, 4, 1, 0},
                                               5123, "SCALAR");
        root["meshes"].push_back(
            {{"primitives", {{{"attributes", {{"POSITION", positions}}}, {"indices", indices}, {"material", 0}}}}});
        root["materials"] = {{{"name", "clear"},
                              {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
                              {"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}}};
        root["nodes"].push_back(
            {{"mesh", 1}, {"name", "block"}, {"scale", {0.25, 0.5, 0.25}}, {"translation", {0.1, 1, 0.2}}});
        root["scenes"][0]["nodes"] = {0, 1};
        node()["name"] = "table";
    }
    nlohmann::json& block() { return root["nodes"][1]; }
    nlohmann::json& material() { return root["materials"][0]; }
    void light(const nlohmann::json& what, const nlohmann::json& node) {
        auto& lights = root["extensions"]["KHR_lights_punctual"]["lights"];
        if (lights.is_null()) lights = nlohmann::json::array();
        lights.push_back(what);
        nlohmann::json with = node;
        with["extensions"]["KHR_lights_punctual"]["light"] = lights.size() - 1;
        root["nodes"].push_back(with);
        root["scenes"][0]["nodes"].push_back(root["nodes"].size() - 1);
    }
};

class Notes final : public Monitor {
public:
    void warn(const std::string& message) override { warnings += message + "\n"; }
    void note(const std::string& message) override { notes += message + "\n"; }
    std::string warnings, notes;
};

/// Scenes that are one glTF. A Room has `binary()`: the bytes of its .glb.
class GltfFileTest : public SceneTest {
protected:
    template <class Room>
    Scene open(const Room& room, int frame = 0) {
        write("room.glb", room.binary());
        notes_ = {};
        return loadScene(path("room.glb"), frame, notes_);
    }
    template <class Room>
    void refusedRoom(const Room& room, const std::vector<std::string>& words) {
        try {
            open(room);
            ADD_FAILURE() << "nothing was thrown";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Input);
            for (const std::string& word : words)
                EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in: " << error.what();
        }
    }
    void noted(const std::string& words) const {
        EXPECT_NE(notes_.notes.find(words), std::string::npos) << words << " in:\n" << notes_.notes;
    }
    Notes notes_;
};

}  // namespace photic::test
