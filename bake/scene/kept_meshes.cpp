// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/kept_meshes.h"

#include <map>
#include <mutex>
#include <utility>

#include "bake/image/atomic_file.h"

namespace photic {
namespace {

/// Hands everything on, and remembers what was said.
class RememberingMonitor final : public Monitor {
public:
    explicit RememberingMonitor(Monitor& to) : to_(to) {}
    void progress(std::string_view stage, double fraction) override { to_.progress(stage, fraction); }
    bool cancelled() const override { return to_.cancelled(); }
    void warn(const std::string& message) override { said.emplace_back(&Monitor::warn, message), to_.warn(message); }
    void note(const std::string& message) override { said.emplace_back(&Monitor::note, message), to_.note(message); }

    std::vector<std::pair<void (Monitor::*)(const std::string&), std::string>> said;

private:
    Monitor& to_;
};

struct Kept {
    std::uint64_t bytes = 0;  ///< hash of the file's
    LoadedMesh loaded;
    std::vector<std::pair<void (Monitor::*)(const std::string&), std::string>> said;
    int scene = 0;  ///< that asked for it last
};

struct Shelf {
    std::mutex mutex;
    std::map<std::pair<std::string, std::string>, Kept> meshes;  ///< by path and keys
    int holders = 0, scene = 0;
};

Shelf& shelf() {
    static Shelf all;
    return all;
}

std::uint64_t hashOf(std::string_view bytes) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    return hash;
}

}  // namespace

KeptMeshes::KeptMeshes() {
    const std::lock_guard lock(shelf().mutex);
    ++shelf().holders;
}

KeptMeshes::~KeptMeshes() {
    const std::lock_guard lock(shelf().mutex);
    if (--shelf().holders == 0) shelf().meshes.clear();
}

LoadedMesh keptMesh(
    const std::string& path, const std::string& keys, const std::function<void(std::string_view)>& use_bytes,
    Monitor& monitor,
    const std::function<LoadedMesh(Monitor& monitor, const std::function<void(std::string_view)>& use_bytes)>& load) {
    Shelf& all = shelf();
    const auto place = std::pair(path, keys);
    bool keeps = false, known = false;
    {
        const std::lock_guard lock(all.mutex);
        keeps = all.holders > 0, known = all.meshes.count(place) > 0;
    }
    if (!keeps) return load(monitor, use_bytes);
    if (known) {
        const std::string bytes = readFileBytes(path);
        const std::uint64_t hash = hashOf(bytes);
        std::unique_lock lock(all.mutex);
        const auto found = all.meshes.find(place);
        if (found != all.meshes.end() && found->second.bytes == hash) {
            found->second.scene = all.scene;
            const Kept kept = found->second;
            lock.unlock();
            use_bytes(bytes);
            for (const auto& [say, message] : kept.said) (monitor.*say)(message);
            return kept.loaded;
        }
    }
    RememberingMonitor remembering(monitor);
    Kept kept;
    int files = 0;
    kept.loaded = load(remembering, [&](std::string_view bytes) {
        if (files++ == 0) kept.bytes = hashOf(bytes);
        use_bytes(bytes);
    });
    kept.said = std::move(remembering.said);
    const std::lock_guard lock(all.mutex);
    kept.scene = all.scene;
    // What is made of several files is read again: one of the others may change.
    if (files == 1 && all.holders > 0) all.meshes.insert_or_assign(place, kept);
    return kept.loaded;
}

void beginSceneOfKeptMeshes() {
    Shelf& all = shelf();
    const std::lock_guard lock(all.mutex);
    ++all.scene;
    std::erase_if(all.meshes, [&](const auto& entry) { return entry.second.scene < all.scene - 1; });
}

}  // namespace photic
