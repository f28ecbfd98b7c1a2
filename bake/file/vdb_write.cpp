// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>
#include <map>

#include "bake/file/active_leaves.h"
#include "bake/file/checked_file.h"
#include "bake/file/output_set.h"
#include "bake/file/vdb.h"
#include "bake/file/voxel_encoding.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;

// Builds a grid leaf by leaf: fill(leaf, values) writes 512 values, of which the active ones are kept.
template <class Grid, class Fill>
typename Grid::Ptr buildGrid(const std::vector<ActiveLeaf>& leaves, Fill fill) {
    using Leaf = typename Grid::TreeType::LeafNodeType;
    using Value = typename Grid::ValueType;
    const Value zero = openvdb::zeroVal<Value>();
    std::vector<std::unique_ptr<Leaf>> nodes(leaves.size());
    parallelFor(static_cast<std::int64_t>(leaves.size()), [&](std::int64_t n) {
        const ActiveLeaf& from = leaves[static_cast<std::size_t>(n)];
        auto node = std::make_unique<Leaf>(openvdb::Coord(from.origin.x, from.origin.y, from.origin.z), zero, false);
        Value* values = node->buffer().data();
        fill(from, values);
        auto mask = node->getValueMask();
        for (std::size_t w = 0; w < 8; ++w) {
            mask.template getWord<std::uint64_t>(static_cast<openvdb::Index>(w)) = from.mask[w];
            if (from.mask[w] != ~0ull)
                for (std::size_t i = 0; i < 64; ++i)
                    if (!(from.mask[w] >> i & 1)) values[w * 64 + i] = zero;
        }
        node->setValueMask(mask);
        nodes[static_cast<std::size_t>(n)] = std::move(node);
    });
    auto grid = Grid::create(zero);
    for (auto& node : nodes) grid->tree().addLeaf(node.release());
    return grid;
}

template <class Value>
void fillZero(Value* values) {
    std::fill_n(values, kVoxels, openvdb::zeroVal<Value>());
}

openvdb::GridBase::Ptr irradianceGrid(const LightVolume& volume, const std::vector<ActiveLeaf>& leaves,
                                      std::atomic<std::int64_t>& clamped) {
    const LightField& field = volume.field;
    const auto scale = static_cast<float>(1 / volume.reference_irradiance);
    const auto channel = [&field](int slot, std::size_t c, int i) {
        return field.state(slot) == LeafState::Dense ? field.dense(slot)[c * kVoxels + static_cast<std::size_t>(i)]
                                                     : field.constant(slot)[c];
    };
    const auto lit = [&field](const ActiveLeaf& leaf) {
        return leaf.slot >= 0 && field.state(leaf.slot) != LeafState::Empty;
    };
    if (field.channels().irradiance == 1) {
        return buildGrid<openvdb::FloatGrid>(leaves, [&](const ActiveLeaf& leaf, float* values) {
            if (!lit(leaf)) return fillZero(values);
            std::int64_t cut = 0;
            for (int i = 0; i < kVoxels; ++i) values[i] = cutToRange(channel(leaf.slot, 0, i) * scale, cut);
            if (cut > 0) clamped += cut;
        });
    }
    auto grid = buildGrid<openvdb::Vec3SGrid>(leaves, [&](const ActiveLeaf& leaf, openvdb::Vec3f* values) {
        if (!lit(leaf)) return fillZero(values);
        std::int64_t cut = 0;
        for (int i = 0; i < kVoxels; ++i)
            for (int c = 0; c < 3; ++c)
                values[i][c] = cutToRange(channel(leaf.slot, static_cast<std::size_t>(c), i) * scale, cut);
        if (cut > 0) clamped += cut;
    });
    grid->setVectorType(openvdb::VEC_INVARIANT);
    return grid;
}

openvdb::GridBase::Ptr directionGrid(const LightVolume& volume, const std::vector<ActiveLeaf>& leaves, bool half) {
    const LightField& field = volume.field;
    const auto f = static_cast<std::size_t>(field.channels().irradiance);
    auto grid = buildGrid<openvdb::Vec3SGrid>(leaves, [&](const ActiveLeaf& leaf, openvdb::Vec3f* values) {
        if (leaf.slot < 0 || field.state(leaf.slot) == LeafState::Empty) return fillZero(values);
        std::array<float, kVoxels> mean, dx, dy, dz;
        meanIrradiance(field, leaf.slot, mean.data());
        if (field.state(leaf.slot) == LeafState::Dense) {
            const float* flux = field.dense(leaf.slot) + f * kVoxels;
            encodeDirections(mean.data(), flux, flux + kVoxels, flux + 2 * kVoxels, kVoxels, half, dx.data(), dy.data(),
                             dz.data());
            for (std::size_t i = 0; i < kVoxels; ++i) values[i] = {dx[i], dy[i], dz[i]};
        } else {
            const float* flux = field.constant(leaf.slot).data() + f;
            encodeDirections(mean.data(), flux, flux + 1, flux + 2, 1, half, dx.data(), dy.data(), dz.data());
            std::fill_n(values, kVoxels, openvdb::Vec3f(dx[0], dy[0], dz[0]));
        }
    });
    grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
    return grid;
}

openvdb::GridBase::Ptr scalarGrid(const LightField& field, const std::vector<ActiveLeaf>& leaves,
                                  std::atomic<std::int64_t>& clamped) {
    return buildGrid<openvdb::FloatGrid>(leaves, [&](const ActiveLeaf& leaf, float* values) {
        const int slot = field.needed().slotOf(leaf.origin);
        if (slot < 0 || field.state(slot) == LeafState::Empty) return fillZero(values);
        std::int64_t cut = 0;
        const auto& needed = field.needed().mask(slot);
        for (int i = 0; i < kVoxels; ++i) {
            const float v = field.state(slot) == LeafState::Dense ? field.dense(slot)[i] : field.constant(slot)[0];
            values[i] = NeededVoxels::maskBit(needed, i) ? cutToRange(v, cut) : 0.0f;
        }
        if (cut > 0) clamped += cut;
    });
}

// Row vectors in OpenVDB: a row for the image of each axis, and one for the origin.
openvdb::math::Transform::Ptr gridTransform(const GridFrame& frame) {
    const auto& m = frame.worldFromIndex();
    const auto& o = frame.origin_world;
    return openvdb::math::Transform::createLinearTransform(openvdb::math::Mat4d(
        m[0].x, m[0].y, m[0].z, 0.0, m[1].x, m[1].y, m[1].z, 0.0, m[2].x, m[2].y, m[2].z, 0.0, o.x, o.y, o.z, 1.0));
}

// Typed where the contract says so; text that does not parse stays text.
openvdb::MetaMap fileMetadata(const LightVolume& volume, std::int64_t clamped) {
    openvdb::MetaMap meta;
    for (const auto& [name, text] : volume.metadata) {
        const std::string key = format::kPrefix + name;
        try {
            std::size_t used = 0;
            if (key == format::kMetaQuadrature || key == format::kMetaFrame) {
                if (const int v = std::stoi(text, &used); used == text.size()) {
                    meta.insertMeta(key, openvdb::Int32Metadata(v));
                    continue;
                }
            } else if (key == format::kMetaIor) {
                if (const double v = std::stod(text, &used); used == text.size()) {
                    meta.insertMeta(key, openvdb::DoubleMetadata(v));
                    continue;
                }
            } else if (key == format::kMetaPrefilter && (text == "true" || text == "false")) {
                meta.insertMeta(key, openvdb::BoolMetadata(text == "true"));
                continue;
            }
        } catch (const std::logic_error&) {
            // not a number
        }
        meta.insertMeta(key, openvdb::StringMetadata(text));
    }
    const auto set = [&meta](const char* key, const openvdb::Metadata& value) {
        meta.removeMeta(key);
        meta.insertMeta(key, value);
    };
    set(format::kMetaVersion, openvdb::Int32Metadata(format::kVersion));
    set(format::kMetaReferenceIrradiance, openvdb::DoubleMetadata(volume.reference_irradiance));
    set(format::kMetaUpAxis, openvdb::StringMetadata("Z"));
    set(format::kMetaClamped, openvdb::Int64Metadata(clamped));
    return meta;
}

// OpenVDB's archive on a stream of ours, with the offsets that let readers open one grid alone.
class SeekableArchive : public openvdb::io::Archive {
public:
    void writeTo(std::ostream& os, const openvdb::GridPtrVec& grids, const openvdb::MetaMap& meta) const {
        Archive::write(os, grids, true, meta);
    }
};

std::uint32_t compressionFlags(Compression compression) {
    switch (compression) {
        case Compression::None:
            return openvdb::io::COMPRESS_NONE;
        case Compression::Blosc:
            return openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK;
        case Compression::Zip:
            return openvdb::io::COMPRESS_ZIP | openvdb::io::COMPRESS_ACTIVE_MASK;
        case Compression::Mask:
            break;
    }
    return openvdb::io::COMPRESS_ACTIVE_MASK;
}

// OpenVDB numbers each file at random; one made of the contents keeps equal bakes equal byte for byte.
std::string uuidFrom(std::uint64_t hash) {
    const std::uint64_t other = (hash ^ hash >> 29) * 0xbf58476d1ce4e5b9ull;
    return fmt::format("{:08x}-{:04x}-8{:03x}-{:04x}-{:012x}", hash >> 32, hash >> 16 & 0xffff, hash & 0xfff,
                       0x8000 | (other >> 48 & 0x3fff), other & 0xffffffffffffull);
}
constexpr std::int64_t kUuidPosition = 21;  // after magic, three versions and the flag for offsets

// What a reader sees: every grid with every active voxel.
bool readsBack(const std::string& path, const openvdb::GridPtrVec& grids, std::int64_t active) {
    openvdb::io::File file(path);
    file.open(true);
    const auto found = file.readAllGridMetadata();
    if (found->size() != grids.size()) return false;
    for (const auto& grid : *found) {
        const auto count = grid->getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
        if (!count || count->value() != active) return false;
    }
    return true;
}

}  // namespace

std::int64_t writeVdb(const std::string& path, const LightVolume& volume, const VdbOptions& options) {
    OutputSet outputs;
    const std::int64_t active = writeVdb(outputs, path, volume, options);
    outputs.commit();
    return active;
}

std::int64_t writeVdb(OutputSet& outputs, const std::string& path, const LightVolume& volume,
                      const VdbOptions& options) {
    openvdb::initialize();
    if (!(volume.reference_irradiance > 0) || !std::isfinite(volume.reference_irradiance))
        throw Error(ErrorCode::Failed,
                    fmt::format("cannot write {}: the reference irradiance is {} W/m2; it must be positive", path,
                                volume.reference_irradiance),
                    path);
    CheckedFile& file = outputs.open(path);  // before the work: a folder that cannot be written to shows at once
    try {
        const std::vector<ActiveLeaf> leaves = activeLeaves(volume, ActiveBy::LightOrMedium);
        std::int64_t active = 0;
        for (const auto& leaf : leaves) active += leaf.count();

        std::atomic<std::int64_t> clamped{0};
        openvdb::GridPtrVec grids;
        const auto add = [&](const char* name, const openvdb::GridBase::Ptr& grid) {
            grid->setName(name);
            grids.push_back(grid);
        };
        if (volume.has_irradiance) add(format::kIrradiance, irradianceGrid(volume, leaves, clamped));
        if (volume.has_direction && volume.field.channels().flux)
            add(format::kDirection, directionGrid(volume, leaves, options.half));
        for (const auto& [name, field] : volume.scalars) add(name.c_str(), scalarGrid(field, leaves, clamped));
        if (grids.empty())
            throw Error(ErrorCode::Failed,
                        fmt::format("cannot write {}: no grid was asked for; add one to grids", path), path);

        const auto transform = gridTransform(volume.field.frame());
        const openvdb::MetaMap meta = fileMetadata(volume, clamped);
        for (const auto& grid : grids) {
            grid->setTransform(transform);
            grid->setGridClass(openvdb::GRID_FOG_VOLUME);
            // Ten bits would leave millimetres of an arrival time.
            grid->setSaveFloatAsHalf(options.half && grid->getName() != format::kArrivalTime);
            for (auto it = meta.beginMeta(); it != meta.endMeta(); ++it) grid->insertMeta(it->first, *it->second);
        }
        SeekableArchive archive;
        archive.setCompression(compressionFlags(options.compression));
        archive.setGridStatsMetadataEnabled(true);
        archive.writeTo(file.stream(), grids, meta);
        file.finish();
        file.patch(kUuidPosition, uuidFrom(file.buffer().hash()));
        if (!readsBack(file.temporaryPath(), grids, active)) file.fail(0);
        return active;
    } catch (const std::ios_base::failure&) {
        file.fail(file.buffer().failure());
    } catch (const openvdb::Exception& e) {
        if (file.buffer().failure() != 0) file.fail(file.buffer().failure());
        throw Error(ErrorCode::Failed, fmt::format("cannot write {}: {}", path, e.what()), path);
    } catch (const std::bad_alloc&) {
        throw Error(
            ErrorCode::Failed,
            fmt::format(
                "cannot write {}: out of memory while its grids were made; use larger voxels or where = \"receivers\"",
                path),
            path);
    }
}

}  // namespace photic
