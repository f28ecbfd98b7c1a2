// SPDX-License-Identifier: Apache-2.0
// The only file that includes NanoVDB's headers.
#include <fmt/format.h>
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>

#include <array>
#include <cstring>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <vector>

#include "bake/file/active_leaves.h"
#include "bake/file/checked_file.h"
#include "bake/file/nvdb.h"
#include "bake/file/output_set.h"
#include "bake/file/runtime_metadata.h"
#include "bake/file/voxel_encoding.h"
#include "bake/report/error.h"

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

// What the builder leaves open: voxel sizes along the axes, and the description of the blind data that it made room
// for.
template <class Build>
void complete(Handle& handle, const GridFrame& frame, const std::string& blind) {
    auto* grid = handle.template grid<Build>();
    auto* data = grid->data();
    const auto& m = frame.worldFromIndex();
    data->mVoxelSize = nanovdb::Vec3R(glm::length(m[0]), glm::length(m[1]), glm::length(m[2]));
    if (!blind.empty()) {
        auto* meta = nanovdb::PtrAdd<nanovdb::GridBlindMetaData>(data, data->mBlindMetadataOffset);
        meta->mElementCount = blind.size();
        meta->mFlags = 0;
        meta->mSemantic = nanovdb::GridBlindDataSemantic::Unknown;
        meta->mDataClass = nanovdb::GridBlindDataClass::Unknown;
        meta->mDataType = nanovdb::GridType::Unknown;  // bytes: there is no type for them
        std::strncpy(meta->mName, "photic", nanovdb::GridBlindMetaData::MaxNameSize - 1);
        std::memcpy(const_cast<char*>(meta->template getBlindData<char>()), blind.data(), blind.size());
    }
    nanovdb::updateChecksum(*grid, nanovdb::ChecksumMode::Full);
}

/// A grid on `leaves`: fill(leaf, values) writes 512 values, of which the active ones are kept.
template <class Value, class Build, class Fill>
Handle buildGrid(const std::string& name, const GridFrame& frame, const std::vector<ActiveLeaf>& leaves,
                 const std::string& blind, Fill fill) {
    // A whole number of aligned blocks, so that whatever follows the grid is aligned too.
    const std::uint64_t room = (blind.size() + kAlignment - 1) / kAlignment * kAlignment;
    nanovdb::GridBuilder<Value, Build> builder(Value(0), nanovdb::GridClass::Unknown, room);
    builder.setChecksum(nanovdb::ChecksumMode::Disable);
    auto accessor = builder.getAccessor();
    std::array<Value, kVoxels> values;
    for (const ActiveLeaf& leaf : leaves) {
        fill(leaf, values.data());
        for (int i = 0; i < kVoxels; ++i) {
            if (!NeededVoxels::maskBit(leaf.mask, i)) continue;
            accessor.setValue(
                nanovdb::Coord(leaf.origin.x + (i >> 6), leaf.origin.y + (i >> 3 & 7), leaf.origin.z + (i & 7)),
                values[static_cast<std::size_t>(i)]);
        }
    }
    Handle handle = builder.template getHandle<nanovdb::AbsDiff, ClearedBuffer>(mapOf(frame), name);
    complete<Build>(handle, frame, blind);
    return handle;
}

std::vector<Handle> gridsOf(const LightVolume& volume, const std::vector<ActiveLeaf>& leaves, NvdbPrecision precision,
                            std::int64_t& clamped) {
    const LightField& field = volume.field;
    const auto scale = static_cast<float>(1 / volume.reference_irradiance);
    std::string blind = runtimeMetadata(volume).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    auto light = std::make_unique<LeafLight>();
    std::vector<Handle> grids;
    // Each value is read for one grid or more; the first pass counts what is cut.
    bool counted = false;
    const auto readLeaf = [&](const ActiveLeaf& leaf) {
        const std::int64_t cut = light->read(field, leaf.slot, scale);
        if (!counted) clamped += cut;
    };
    const bool coloured = field.channels().irradiance == 3;
    if (precision == NvdbPrecision::Float) {
        grids.push_back(buildGrid<nanovdb::Vec4f, nanovdb::Vec4f>(
            "flux", field.frame(), leaves, blind, [&](const ActiveLeaf& leaf, nanovdb::Vec4f* values) {
                readLeaf(leaf);
                for (std::size_t i = 0; i < kVoxels; ++i)
                    values[i] =
                        nanovdb::Vec4f(light->flux[0][i], light->flux[1][i], light->flux[2][i], light->irradiance[i]);
            }));
        counted = true;
        if (coloured) {
            grids.push_back(buildGrid<nanovdb::Vec3f, nanovdb::Vec3f>(
                "irradiance_rgb", field.frame(), leaves, {}, [&](const ActiveLeaf& leaf, nanovdb::Vec3f* values) {
                    readLeaf(leaf);
                    for (std::size_t i = 0; i < kVoxels; ++i)
                        values[i] = nanovdb::Vec3f(light->rgb[0][i], light->rgb[1][i], light->rgb[2][i]);
                }));
        }
        return grids;
    }
    const auto add = [&](const char* name, const std::array<float, kVoxels>& channel) {
        grids.push_back(buildGrid<float, nanovdb::Fp16>(name, field.frame(), leaves,
                                                        grids.empty() ? blind : std::string(),
                                                        [&](const ActiveLeaf& leaf, float* values) {
                                                            readLeaf(leaf);
                                                            std::copy(channel.begin(), channel.end(), values);
                                                        }));
        counted = true;
    };
    add("irradiance", light->irradiance);
    constexpr const char* kFlux[] = {"flux_x", "flux_y", "flux_z"};
    for (std::size_t a = 0; a < 3; ++a) add(kFlux[a], light->flux[a]);
    constexpr const char* kColours[] = {"irradiance_r", "irradiance_g", "irradiance_b"};
    for (std::size_t c = 0; coloured && c < 3; ++c) add(kColours[c], light->rgb[c]);
    return grids;
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
bool readsBack(const std::string& path, std::size_t grids, std::int64_t active) {
    const auto found = nanovdb::io::readGridMetaData(path);
    return found.size() == grids && std::all_of(found.begin(), found.end(), [&](const auto& m) {
               return static_cast<std::int64_t>(m.voxelCount) == active;
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
        const std::vector<Handle> grids = gridsOf(volume, leaves, options.precision, written.clamped);
        nanovdb::io::writeGrids(file.stream(), grids, codecOf(options.codec));
        file.finish();
        if (!readsBack(file.temporaryPath(), grids.size(), written.active_voxels)) file.fail(0);
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
