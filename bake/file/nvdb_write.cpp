// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cstring>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <vector>

#include "bake/file/active_leaves.h"
#include "bake/file/checked_file.h"
#include "bake/file/compressed_light.h"
#include "bake/file/nvdb.h"
#include "bake/file/output_set.h"
#include "bake/file/runtime_metadata.h"
#include "bake/file/voxel_encoding.h"
#include "bake/libraries/nanovdb.h"
#include "bake/report/error.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;
constexpr std::uint64_t kAlignment = NANOVDB_DATA_ALIGNMENT;

// NanoVDB's own buffer is not cleared, and its nodes have gaps: files would hold stray bytes of memory.
class ClearedBuffer {
public:
    static ClearedBuffer create(std::uint64_t size, const ClearedBuffer* = nullptr) {
        ClearedBuffer buffer;
        buffer.data_.reset(static_cast<std::uint8_t*>(::operator new[](size, std::align_val_t{kAlignment})));
        buffer.size_ = size;
        std::memset(buffer.data_.get(), 0, size);
        return buffer;
    }
    std::uint8_t* data() { return data_.get(); }
    const std::uint8_t* data() const { return data_.get(); }
    std::uint64_t size() const { return size_; }
    void clear() { data_.reset(), size_ = 0; }

private:
    struct Free {
        void operator()(std::uint8_t* p) const { ::operator delete[](p, std::align_val_t{kAlignment}); }
    };
    std::unique_ptr<std::uint8_t[], Free> data_;
    std::uint64_t size_ = 0;
};
using Handle = nanovdb::GridHandle<ClearedBuffer>;

nanovdb::Map mapOf(const GridFrame& frame) {
    // Rows in, transposed by Map::set: the images of the axes.
    const glm::dmat3& inverse = frame.indexFromWorld();
    double rows[3][3], inverse_rows[3][3];
    for (int axis = 0; axis < 3; ++axis)
        for (int i = 0; i < 3; ++i)
            rows[axis][i] = frame.worldFromIndex()[axis][i], inverse_rows[axis][i] = inverse[axis][i];
    const double origin[3] = {frame.origin_world.x, frame.origin_world.y, frame.origin_world.z};
    nanovdb::Map map;
    map.set(rows, inverse_rows, origin, 1.0);
    return map;
}

// Light of a leaf in units of the reference, cut to what halves can hold.
struct LeafLight {
    std::array<std::array<float, kVoxels>, 3> flux{}, rgb{};
    std::array<float, kVoxels> irradiance{};

    std::int64_t read(const LightField& field, int slot, float scale) {
        *this = {};
        if (slot < 0 || field.state(slot) == LeafState::Empty) return 0;
        std::int64_t cut = 0;
        const bool dense = field.state(slot) == LeafState::Dense;
        const auto channel = [&](int c, int i) {
            return (dense ? field.dense(slot)[c * kVoxels + i] : field.constant(slot)[static_cast<std::size_t>(c)]) *
                   scale;
        };
        const int colours = field.channels().irradiance;
        meanIrradiance(field, slot, irradiance.data());
        for (std::size_t i = 0; i < kVoxels; ++i) {
            const int n = static_cast<int>(i);
            irradiance[i] = cutToRange(irradiance[i] * scale, cut);
            for (std::size_t c = 0; colours == 3 && c < 3; ++c)
                rgb[c][i] = cutToRange(channel(static_cast<int>(c), n), cut);
            for (std::size_t a = 0; field.channels().flux && a < 3; ++a)
                flux[a][i] = cutToRange(channel(colours + static_cast<int>(a), n), cut);
        }
        return cut;
    }
};

/// A grid on `leaves`: fill(leaf, values) writes 512 values, of which the active ones are kept.
template <class Value, class Build, class Fill>
Handle buildGrid(const std::string& name, const GridFrame& frame, const std::vector<ActiveLeaf>& leaves,
                 const std::string& blind, Fill fill) {
    const auto& m = frame.worldFromIndex();
    const nanovdb::Vec3d voxel_size(glm::length(m[0]), glm::length(m[1]), glm::length(m[2]));
    std::array<Value, kVoxels> values;
    return nano::build<Value, Build, ClearedBuffer>({name, mapOf(frame), voxel_size, blind}, [&](auto& accessor) {
        for (const ActiveLeaf& leaf : leaves) {
            fill(leaf, values.data());
            for (int i = 0; i < kVoxels; ++i) {
                if (!NeededVoxels::maskBit(leaf.mask, i)) continue;
                accessor.setValue(
                    nanovdb::Coord(leaf.origin.x + (i >> 6), leaf.origin.y + (i >> 3 & 7), leaf.origin.z + (i & 7)),
                    values[static_cast<std::size_t>(i)]);
            }
        }
    });
}

/// The grids of one lobe.
class LobeGrids {
public:
    /// @param suffix  of the grids' names
    /// @param blind   text that the first of them carries
    LobeGrids(const LightField& field, double reference, const std::vector<ActiveLeaf>& leaves, std::string suffix,
              std::string blind)
        : field_(field),
          scale_(static_cast<float>(1 / reference)),
          leaves_(leaves),
          suffix_(std::move(suffix)),
          blind_(std::move(blind)) {}

    /// @param clamped  counts values that were cut
    std::vector<Handle> make(NvdbPrecision precision, std::int64_t& clamped) {
        std::vector<Handle> grids;
        const bool coloured = field_.channels().irradiance == 3;
        if (precision == NvdbPrecision::Float) {
            add<nanovdb::Vec4f, nanovdb::Vec4f>(grids, "flux", [&](std::size_t i) {
                return nanovdb::Vec4f(light_->flux[0][i], light_->flux[1][i], light_->flux[2][i],
                                      light_->irradiance[i]);
            });
            if (coloured)
                add<nanovdb::Vec3f, nanovdb::Vec3f>(grids, "irradiance_rgb", [&](std::size_t i) {
                    return nanovdb::Vec3f(light_->rgb[0][i], light_->rgb[1][i], light_->rgb[2][i]);
                });
        } else {
            const auto addChannel = [&](const char* name, const std::array<float, kVoxels>& channel) {
                add<float, nanovdb::Fp16>(grids, name, [&](std::size_t i) { return channel[i]; });
            };
            addChannel("irradiance", light_->irradiance);
            constexpr const char* kFlux[] = {"flux_x", "flux_y", "flux_z"};
            for (std::size_t a = 0; a < 3; ++a) addChannel(kFlux[a], light_->flux[a]);
            constexpr const char* kColours[] = {"irradiance_r", "irradiance_g", "irradiance_b"};
            for (std::size_t c = 0; coloured && c < 3; ++c) addChannel(kColours[c], light_->rgb[c]);
        }
        clamped += clamped_;
        return grids;
    }

private:
    template <class Value, class Build, class ValueOf>
    void add(std::vector<Handle>& grids, const std::string& name, const ValueOf& valueOf) {
        const auto fill = [&](const ActiveLeaf& leaf, Value* values) {
            // Each value is read for one grid or more; the first pass counts what is cut.
            const std::int64_t cut = light_->read(field_, leaf.slot, scale_);
            if (grids.empty()) clamped_ += cut;
            for (std::size_t i = 0; i < kVoxels; ++i) values[i] = valueOf(i);
        };
        grids.push_back(buildGrid<Value, Build>(name + suffix_, field_.frame(), leaves_,
                                                grids.empty() ? blind_ : std::string(), fill));
    }

    const LightField& field_;
    float scale_;
    const std::vector<ActiveLeaf>& leaves_;
    std::string suffix_, blind_;
    std::unique_ptr<LeafLight> light_ = std::make_unique<LeafLight>();
    std::int64_t clamped_ = 0;
};

/// What is written, and how many voxels a reader must find active in each grid.
struct FileGrids {
    std::vector<Handle> grids;
    std::vector<std::int64_t> active;
};

FileGrids gridsOf(const LightVolume& volume, const std::vector<ActiveLeaf>& leaves, NvdbPrecision precision,
                  std::int64_t& clamped) {
    const std::string blind =
        runtimeMetadata(volume).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    FileGrids file;
    const auto addLobe = [&](const LightField& field, const std::vector<ActiveLeaf>& where, const char* suffix,
                             const std::string& text) {
        std::int64_t active = 0;
        for (const ActiveLeaf& leaf : where) active += leaf.count();
        for (Handle& grid :
             LobeGrids(field, volume.reference_irradiance, where, suffix, text).make(precision, clamped)) {
            file.grids.push_back(std::move(grid));
            file.active.push_back(active);
        }
    };
    addLobe(volume.field, leaves, "", blind);
    if (const std::vector<ActiveLeaf> second = secondLobeLeaves(volume, leaves); !second.empty())
        addLobe(*volume.second, second, "_2", {});
    constexpr const char* kLobes[] = {"", "_2"};
    for (std::size_t lobe = 0; lobe < 2; ++lobe) {
        if (!volume.compressed[lobe]) continue;
        // A grid that has nothing but its blind data.
        file.grids.push_back(buildGrid<float, float>(std::string(format::kBlocksGrid) + kLobes[lobe],
                                                     volume.field.frame(), {}, volume.compressed[lobe]->bytes(),
                                                     [](const ActiveLeaf&, float*) {}));
        file.active.push_back(0);
    }
    return file;
}

nanovdb::io::Codec codecOf(NvdbCodec codec) {
    switch (codec) {
        case NvdbCodec::Zip:
            return nanovdb::io::Codec::ZIP;
        case NvdbCodec::Blosc:
            return nanovdb::io::Codec::BLOSC;
        case NvdbCodec::None:
            break;
    }
    return nanovdb::io::Codec::NONE;
}

// What a reader sees first: every grid with every active voxel.
bool readsBack(const std::string& path, const std::vector<std::int64_t>& active) {
    const auto found = nanovdb::io::readGridMetaData(path);
    return std::equal(found.begin(), found.end(), active.begin(), active.end(), [](const auto& m, std::int64_t count) {
        return static_cast<std::int64_t>(m.voxelCount) == count;
    });
}

}  // namespace

NvdbWritten writeNvdb(const std::string& path, const LightVolume& volume, const NvdbOptions& options) {
    OutputSet outputs;
    const NvdbWritten written = writeNvdb(outputs, path, volume, options);
    outputs.commit();
    return written;
}

NvdbWritten writeNvdb(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                      const NvdbOptions& options) {
    CheckedFile& file = outputs.open(path);  // before the work: a folder that cannot be written to shows at once
    try {
        NvdbWritten written;
        const std::vector<ActiveLeaf> leaves = activeLeaves(volume, ActiveBy::Light);
        for (const ActiveLeaf& leaf : leaves) written.active_voxels += leaf.count();
        const FileGrids grids = gridsOf(volume, leaves, options.precision, written.clamped);
        nanovdb::io::writeGrids(file.stream(), grids.grids, codecOf(options.codec));
        file.finish();
        if (!readsBack(file.temporaryPath(), grids.active)) file.fail(0);
        return written;
    } catch (const std::ios_base::failure&) {
        file.fail(file.buffer().failure());
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw Error(
            ErrorCode::Failed,
            fmt::format("cannot write {}: out of memory while its grids were made; export fewer voxels (--budget)",
                        path),
            path);
    } catch (const std::runtime_error& e) {
        if (file.buffer().failure() != 0) file.fail(file.buffer().failure());
        throw Error(ErrorCode::Failed, fmt::format("cannot write {}: {}", path, e.what()), path);
    }
}

}  // namespace photic
