// SPDX-License-Identifier: Apache-2.0
/// tinygltf 2.5 to 2.9; one source defines TINYGLTF_IMPLEMENTATION before it includes this. Geometry only: images are
/// neither decoded nor looked for, and files are opened by the caller's own callbacks.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace photic::gltf {

/// How the files that a glTF refers to are found and read; nothing is ever written.
struct FileAccess {
    bool (*exists)(const std::string& path, void* user_data);
    std::string (*expand)(const std::string& path, void* user_data);
    bool (*read)(std::vector<unsigned char>* out, std::string* error, const std::string& path, void* user_data);
    bool (*size)(std::size_t* bytes, std::string* error, const std::string& path, void* user_data);
    void* user_data;
};

/// Makes `loader` read through `access`. From 2.9 on the callbacks have one member more, and none may be null.
template <class Callbacks = tinygltf::FsCallbacks>
void useFiles(tinygltf::TinyGLTF& loader, const FileAccess& access) {
    Callbacks callbacks{};
    callbacks.FileExists = access.exists;
    callbacks.ExpandFilePath = access.expand;
    callbacks.ReadWholeFile = access.read;
    callbacks.WriteWholeFile = [](std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
        return false;
    };
    if constexpr (requires { callbacks.GetFileSizeInBytes; }) {
        callbacks.GetFileSizeInBytes = access.size;
    }
    callbacks.user_data = access.user_data;
    loader.SetFsCallbacks(callbacks);
}

}  // namespace photic::gltf
