// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <string>
#include <string_view>

#include "bake/report/monitor.h"
#include "bake/scene/index_volume.h"
#include "bake/scene/mesh_file.h"
#include "bake/scene/mesh_shape.h"
#include "bake/scene/scene.h"
#include "bake/scene/spline_field.h"
#include "bake/scene/table_reader.h"

namespace photic {

/// What the loaders of all tables share.
struct LoadContext {
    std::string name;       ///< of the scene file
    std::string directory;  ///< that relative files are looked up in
    int frame = 0;
    double frame_rate = 24;  ///< [1/s]
    Monitor& monitor;
    /// Whether something depends on the frame's number other than through a file's name, and after how many frames all
    /// of it is as it was; 0: never.
    bool animated = false;
    std::int64_t loop_frames = 0;
    std::uint64_t hash = 0xcbf29ce484222325u;  ///< 64-bit FNV-1a of all bytes so far
    std::vector<Medium> media{};               ///< Scene::media, to which surfaces add "air" where they name it
    std::vector<GradedObject> graded{};        ///< media whose index varies; `media` has each as well
    std::map<std::string, std::shared_ptr<const RawMesh>> gltf{};  ///< files of which tables take parts, by path
    Medium water{};                                                ///< Scene::medium
    std::optional<RefractiveIndex> water_index{};                  ///< of the water, where its own table gives one

    void hashBytes(std::string_view bytes) {
        for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    }
    /// Something moves, and comes again after so many frames; 0: never.
    void animate(std::int64_t loop) {
        constexpr std::int64_t kLongest = 1000000;
        loop_frames = loop == 0 || (animated && loop_frames == 0) ? 0 : animated ? std::lcm(loop_frames, loop) : loop;
        if (loop_frames > kLongest) loop_frames = 0;
        animated = true;
    }
    /// A file's path, with "####" replaced by the frame's number, relative to the scene's directory.
    std::string path(const std::string& file) const;
};

/// Calls `body` and gives errors without a place that of `key`.
template <typename Body>
auto placed(const TableReader& table, const std::string& key, const Body& body) {
    try {
        return body();
    } catch (const Error& error) {
        if (error.code() == ErrorCode::Cancelled || !error.where().empty()) throw;
        throw Error(error.code(), error.what(), table.where(key));
    }
}

/// A table or an array of tables as a list of tables.
std::vector<const ConfigValue*> tablesOf(const ConfigValue* value, const std::string& title);

Light loadLight(const ConfigValue& table, std::size_t number);
/// Gives a light that has a place the irradiance (and a point the direction) that it has at the centre of what it
/// shines on.
/// @param least_distance  [m] that it counts as standing away at least
/// @throws Error{Input} when it stands there, and that is 0
void aimLight(Light& light, const glm::dvec3& center, const std::string& name, double least_distance = 0);
/// @param domain  footprint for a surface without `size`; null when the file has no box
Surface loadSurface(const ConfigValue& table, std::size_t number, const Domain* domain, LoadContext& context);
Object loadObject(const ConfigValue& table, std::size_t number, LoadContext& context);
Camera loadCamera(const ConfigValue& table, std::size_t number);
/// [medium], the water, or all [[medium]], into the context. To be called before surfaces, which name them.
void loadMedia(const ConfigValue& value, LoadContext& context);
/// The place in the context's media of the one that a key names, or -1 without the key; "air", "vacuum" and "water" are
/// known without a table.
int mediumNamed(const TableReader& table, const std::string& key, LoadContext& context);
/// The medium of this name whose index varies; null: its index, if there is one, is the same everywhere.
GradedObject* gradedNamed(LoadContext& context, const std::string& name);
/// Its index at a place, as one number or three.
RefractiveIndex indexAt(const GradedObject& object, const glm::dvec3& world);
/// @param medium  index where the volume holds none
std::shared_ptr<const IndexVolume> loadIndex(const ConfigValue& table, double medium, LoadContext& context);
/// `index` of a named medium: one, or three for red, green and blue.
std::vector<std::shared_ptr<const GradedIndex>> loadGradedIndex(const ConfigValue& value, LoadContext& context);
/// `absorption_volume`, `emission_volume` or `anisotropy_volume` of such a medium: a file, or a table with its place;
/// null where it is not given.
std::shared_ptr<const MediumVolume> loadMediumVolume(const TableReader& table, const MediumQuantity& quantity,
                                                     LoadContext& context);
BakeSettings loadBake(const ConfigValue& table);

/// A mesh file with its `up`, its place in the scene, and `smooth`.
/// @param shape  of the welded mesh, when it is wanted
std::shared_ptr<const TriangleMesh> loadMeshKeys(const TableReader& table, const std::string& file,
                                                 LoadContext& context, MeshShape* shape = nullptr);

/// [domain] as given: min == max when the box is to come from the scene's bounds.
struct DomainRequest {
    Domain domain;
    bool has_box = false;
    bool fits_light = false;  ///< the box is lightBounds(), otherwise sceneBounds()
    bool is_sized = false;    ///< voxel_size or resolution was given
    int resolution = 0;       ///< cells along the longest side; 0: voxel_size is given
    std::string where;
};
DomainRequest loadDomain(const ConfigValue* table, const std::string& name);
/// Gives the domain its box and voxel size from the scene's bounds where the file doesn't, and refuses impossible
/// grids.
void finishDomain(const DomainRequest& request, Scene& scene);

/// Where a height field lies, and what its own tables add.
struct HeightFieldPlace {
    glm::dvec2 size{0};    ///< [m]; 0: not given
    glm::dvec3 center{0};  ///< [m]
    Outside outside = Outside::Flat;
    bool outside_given = false;
    double frame_rate = 24;
};

/// One source of heights each. They may change `place.outside` to what the source implies.
std::shared_ptr<const HeightField> loadHeightMap(const TableReader& surface, const HeightFieldPlace& place,
                                                 LoadContext& context);
std::shared_ptr<const HeightField> loadWaves(const TableReader& surface, HeightFieldPlace& place, LoadContext& context);
std::shared_ptr<const HeightField> loadBump(const TableReader& surface, const HeightFieldPlace& place,
                                            LoadContext& context);
std::shared_ptr<const HeightField> loadSea(const TableReader& surface, const HeightFieldPlace& place,
                                           LoadContext& context);

/// "bicubic" unless `interpolation` says otherwise.
Interpolation loadInterpolation(const TableReader& table);
/// Warns when horizontal displacement folds the surface over itself.
void warnOfFolds(const TableReader& table, const std::string& key, const HeightField& field,
                 const SplineFieldShape& shape, int width, int height, Monitor& monitor);

}  // namespace photic
