// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <new>

#include "bake/file/active_leaves.h"
#include "bake/file/checked_file.h"
#include "bake/file/output_set.h"
#include "bake/file/vdb.h"
#include "bake/file/voxel_encoding.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"
#include "bake/volume/checksum.h"
#include "bake/volume/pack.h"
#include "bake/volume/vdb_layout.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;

/// Writes the 512 values of a leaf, a voxel's components side by side; what they are where the leaf is not active does
/// not matter. Called from several threads.
using LeafValues = std::function<void(const ActiveLeaf&, float* values)>;

/// A grid to be written.
struct GridSource {
    VdbGridLayout layout;
    LeafValues values;
    const std::vector<ActiveLeaf>* leaves;
};

/// One channel of a leaf that is not Empty: 512 values, `constant` where it has but one.
const float* channelOf(const LightField& field, int slot, int channel, std::array<float, kVoxels>& constant) {
    const auto c = static_cast<std::size_t>(channel);
    if (field.state(slot) == LeafState::Dense) return field.dense(slot) + c * kVoxels;
    constant.fill(field.constant(slot)[c]);
    return constant.data();
}

bool isLit(const LightField& field, int slot) { return slot >= 0 && field.state(slot) != LeafState::Empty; }

LeafValues irradianceValues(const LightField& field, double reference, std::atomic<std::int64_t>& clamped) {
    return [&field, reference, &clamped](const ActiveLeaf& leaf, float* values) {
        const auto scale = static_cast<float>(1 / reference);
        const int colours = field.channels().irradiance;
        if (!isLit(field, leaf.slot)) {
            std::fill_n(values, kVoxels * colours, 0.0f);
            return;
        }
        std::int64_t cut = 0;
        std::array<float, kVoxels> constant;
        for (int c = 0; c < colours; ++c) {
            const float* from = channelOf(field, leaf.slot, c, constant);
            for (int i = 0; i < kVoxels; ++i) values[i * colours + c] = cutToRange(from[i] * scale, cut);
        }
        if (cut > 0) clamped += cut;
    };
}

LeafValues directionValues(const LightField& field, bool half) {
    return [&field, half](const ActiveLeaf& leaf, float* values) {
        if (!isLit(field, leaf.slot)) {
            std::fill_n(values, kVoxels * 3, 0.0f);
            return;
        }
        const bool dense = field.state(leaf.slot) == LeafState::Dense;
        const int f = field.channels().irradiance;
        std::array<float, kVoxels> mean, dx, dy, dz;
        meanIrradiance(field, leaf.slot, mean.data());
        const float* flux = dense ? field.dense(leaf.slot) + f * kVoxels : field.constant(leaf.slot).data() + f;
        const int next = dense ? kVoxels : 1;
        encodeDirections(mean.data(), flux, flux + next, flux + 2 * next, next, half, dx.data(), dy.data(), dz.data());
        for (std::size_t i = 0; i < kVoxels; ++i) {
            const std::size_t from = dense ? i : 0;
            values[3 * i] = dx[from], values[3 * i + 1] = dy[from], values[3 * i + 2] = dz[from];
        }
    };
}

LeafValues scalarValues(const LightField& field, std::atomic<std::int64_t>& clamped) {
    return [&field, &clamped](const ActiveLeaf& leaf, float* values) {
        const int slot = field.needed().slotOf(leaf.origin);
        if (!isLit(field, slot)) {
            std::fill_n(values, kVoxels, 0.0f);
            return;
        }
        std::int64_t cut = 0;
        std::array<float, kVoxels> constant;
        const float* from = channelOf(field, slot, 0, constant);
        const auto& needed = field.needed().mask(slot);
        for (int i = 0; i < kVoxels; ++i)
            values[i] = NeededVoxels::maskBit(needed, i) ? cutToRange(from[i], cut) : 0.0f;
        if (cut > 0) clamped += cut;
    };
}

// Typed where the contract says so; text that does not parse stays text.
VdbValue typed(const std::string& key, const std::string& text) {
    try {
        std::size_t used = 0;
        if (key == format::kMetaQuadrature || key == format::kMetaFrame) {
            if (const std::int32_t v = std::stoi(text, &used); used == text.size()) return v;
        } else if (key == format::kMetaIor) {
            if (const double v = std::stod(text, &used); used == text.size()) return v;
        } else if (key == format::kMetaPrefilter && (text == "true" || text == "false")) {
            return text == "true";
        }
    } catch (const std::logic_error&) {
        // not a number
    }
    return text;
}

VdbValues fileMetadata(const LightVolume& volume, std::int64_t clamped) {
    VdbValues values;
    for (const auto& [name, text] : volume.metadata) {
        const std::string key = format::kPrefix + name;
        values[key] = typed(key, text);
    }
    values[format::kMetaVersion] = std::int32_t{format::kVersion};
    values[format::kMetaReferenceIrradiance] = volume.reference_irradiance;
    values[format::kMetaUpAxis] = std::string("Z");
    values[format::kMetaClamped] = clamped;
    return values;
}

std::uint32_t compressionFlags(Compression compression) {
    switch (compression) {
        case Compression::None:
            return 0;
        case Compression::Blosc:
            return kPackedBlosc | kPackedActive;
        case Compression::Zip:
            return kPackedZip | kPackedActive;
        case Compression::Mask:
            break;
    }
    return kPackedActive;
}

// OpenVDB numbers each file at random; a number made of the contents keeps equal bakes equal byte for byte.
std::string numberFrom(std::uint64_t hash) {
    const std::uint64_t other = (hash ^ hash >> 29) * 0xbf58476d1ce4e5b9ull;
    return fmt::format("{:08x}-{:04x}-8{:03x}-{:04x}-{:012x}", hash >> 32, hash >> 16 & 0xffff, hash & 0xfff,
                       0x8000 | (other >> 48 & 0x3fff), other & 0xffffffffffffull);
}

/// Writes a file in parts that several threads make, and reads all of it back.
class PartedFile {
public:
    explicit PartedFile(CheckedFile& file) : file_(file) {}

    std::int64_t size() const { return size_; }
    /// Leaves room for bytes that are known later.
    std::int64_t reserve(std::size_t count) {
        size_ += static_cast<std::int64_t>(count);
        return size_ - static_cast<std::int64_t>(count);
    }
    void put(std::int64_t position, const std::string& bytes) {
        file_.writeAt(position, bytes.data(), bytes.size());
        parts_.push_back({position, bytes.size(), checksum(bytes.data(), bytes.size())});
    }
    /// Appends the bytes of `count` leaves: encode(i, to) returns how many it wrote, `most` at most.
    template <class Encode>
    void putLeaves(std::int64_t count, std::size_t most, Encode encode) {
        const std::int64_t chunks = (count + kLeaves - 1) / kLeaves, batch = std::int64_t{16} * threadCount();
        std::vector<std::unique_ptr<char[]>> buffers(static_cast<std::size_t>(std::min(chunks, batch)));
        for (std::int64_t first = 0; first < chunks; first += batch) {
            const std::int64_t here = std::min(batch, chunks - first);
            const std::size_t first_part = parts_.size();
            parts_.resize(first_part + static_cast<std::size_t>(here));
            parallelFor(here, [&](std::int64_t i) {
                auto& buffer = buffers[static_cast<std::size_t>(i)];
                if (!buffer) buffer = std::make_unique_for_overwrite<char[]>(static_cast<std::size_t>(kLeaves) * most);
                std::size_t used = 0;
                const std::int64_t leaf = (first + i) * kLeaves;
                for (std::int64_t k = leaf; k < std::min(count, leaf + kLeaves); ++k)
                    used += encode(k, buffer.get() + used);
                parts_[first_part + static_cast<std::size_t>(i)] = {0, used, checksum(buffer.get(), used)};
            });
            for (std::size_t i = first_part; i < parts_.size(); ++i) parts_[i].position = reserve(parts_[i].size);
            parallelFor(here, [&](std::int64_t i) {
                const Part& part = parts_[first_part + static_cast<std::size_t>(i)];
                file_.writeAt(part.position, buffers[static_cast<std::size_t>(i)].get(), part.size);
            });
        }
    }
    /// Of all parts so far.
    std::uint64_t checksumOfAll() const {
        std::uint64_t hash = 0;
        for (const Part& part : parts_)
            hash = checksum(reinterpret_cast<const char*>(&part.sum), sizeof(part.sum), hash);
        return hash;
    }
    /// Whether the file holds every byte that was put into it.
    bool readsBack() const {
        const int descriptor = ::open(file_.temporaryPath().c_str(), O_RDONLY | O_CLOEXEC);
        if (descriptor < 0) return false;
        std::atomic<bool> whole{true};
        constexpr std::size_t kAtOnce = 8;  // parts: a buffer serves several
        const std::size_t groups = (parts_.size() + kAtOnce - 1) / kAtOnce;
        parallelFor(static_cast<std::int64_t>(groups), [&](std::int64_t g) {
            std::vector<char> bytes;
            const std::size_t first = static_cast<std::size_t>(g) * kAtOnce;
            for (std::size_t i = first; i < std::min(parts_.size(), first + kAtOnce); ++i)
                if (!isThere(descriptor, parts_[i], bytes)) whole = false;
        });
        ::close(descriptor);
        return whole;
    }

private:
    static constexpr std::int64_t kLeaves = 64;  // in a part
    struct Part {
        std::int64_t position = 0;
        std::size_t size = 0;
        std::uint64_t sum = 0;
    };

    static bool isThere(int descriptor, const Part& part, std::vector<char>& bytes) {
        if (bytes.size() < part.size) bytes.resize(part.size);
        for (std::size_t done = 0; done < part.size;) {
            const ssize_t n = ::pread(descriptor, bytes.data() + done, part.size - done,
                                      static_cast<off_t>(part.position + static_cast<std::int64_t>(done)));
            if (n < 0 && errno == EINTR) continue;
            if (n <= 0) return false;
            done += static_cast<std::size_t>(n);
        }
        return checksum(bytes.data(), part.size) == part.sum;
    }

    CheckedFile& file_;
    std::int64_t size_ = 0;
    std::vector<Part> parts_;
};

/// The leaves of a file, and those of them where the second lobe has light.
struct FileLeaves {
    std::vector<ActiveLeaf> all, second;
};

FileLeaves leavesOf(const LightVolume& volume) {
    FileLeaves leaves{activeLeaves(volume, ActiveBy::LightOrMedium), {}};
    std::sort(leaves.all.begin(), leaves.all.end(),
              [](const ActiveLeaf& a, const ActiveLeaf& b) { return beforeInTree(a.origin, b.origin); });
    leaves.second = secondLobeLeaves(volume, leaves.all);
    return leaves;
}

std::vector<GridSource> gridsOf(const LightVolume& volume, const FileLeaves& leaves, const VdbOptions& options,
                                std::atomic<std::int64_t>& clamped) {
    VdbGridLayout common;
    common.half = options.half, common.compression = compressionFlags(options.compression);
    const GridFrame& frame = volume.field.frame();
    common.transform = {frame.worldFromIndex(), frame.origin_world};
    std::vector<GridSource> grids;
    const auto add = [&](const char* name, int components, const char* vector_type, LeafValues values,
                         const std::vector<ActiveLeaf>& where) {
        grids.push_back({common, std::move(values), &where});
        VdbGridLayout& layout = grids.back().layout;
        layout.name = name, layout.components = components;
        if (components == 3) layout.metadata["vector_type"] = std::string(vector_type);
        // Ten bits would leave millimetres of an arrival time.
        layout.half = layout.half && layout.name != format::kArrivalTime;
    };
    const auto addLight = [&](const char* irradiance, const char* direction, const LightField& field,
                              const std::vector<ActiveLeaf>& where) {
        if (volume.has_irradiance)
            add(irradiance, field.channels().irradiance, "invariant",
                irradianceValues(field, volume.reference_irradiance, clamped), where);
        if (volume.has_direction && field.channels().flux)
            add(direction, 3, "contravariant relative", directionValues(field, options.half), where);
    };
    addLight(format::kIrradiance, format::kDirection, volume.field, leaves.all);
    if (!leaves.second.empty()) addLight(format::kIrradiance2, format::kDirection2, *volume.second, leaves.second);
    for (const auto& [name, field] : volume.scalars) add(name.c_str(), 1, "", scalarValues(field, clamped), leaves.all);
    return grids;
}

void clearInactive(const NeededVoxels::Mask& active, int components, float* values) {
    for (int i = 0; i < kVoxels; ++i)
        if (!NeededVoxels::maskBit(active, i)) std::fill_n(values + i * components, components, 0.0f);
}

/// Writes the grids behind one another. What stands before a grid's values says how much was clamped in all of them:
/// it comes last.
void writeGrids(CheckedFile& file, const LightVolume& volume, std::vector<GridSource>& grids,
                std::atomic<std::int64_t>& clamped) {
    const std::string no_number(36, '0');
    const auto topologyOf = [](const GridSource& grid) {
        std::vector<VdbTopology> topology;
        topology.reserve(grid.leaves->size());
        for (const auto& leaf : *grid.leaves) topology.push_back({leaf.origin, leaf.mask});
        return topology;
    };
    const HalfConversion convert = halfConversion();

    PartedFile parts(file);
    std::string head = vdbFileHead(no_number, fileMetadata(volume, 0), static_cast<int>(grids.size()));
    parts.reserve(head.size());
    struct Placed {
        std::int64_t at, blocks, end;
    };
    std::vector<Placed> places;
    const VdbValues none = fileMetadata(volume, 0);  // as many bytes as the last will have
    for (GridSource& grid : grids) {
        VdbGridLayout as_large = grid.layout;
        as_large.metadata.insert(none.begin(), none.end());
        const std::int64_t at = parts.reserve(vdbGridHead(as_large, topologyOf(grid)).bytes.size());
        const std::int64_t blocks = parts.size();
        const std::size_t most = mostBytesOfLeaf(grid.layout);
        parts.putLeaves(static_cast<std::int64_t>(grid.leaves->size()), most, [&](std::int64_t i, char* to) {
            const ActiveLeaf& leaf = (*grid.leaves)[static_cast<std::size_t>(i)];
            float values[3 * kVoxels];
            grid.values(leaf, values);
            if (!(grid.layout.compression & kPackedActive)) clearInactive(leaf.mask, grid.layout.components, values);
            return encodeLeaf(grid.layout, convert, leaf.mask, values, to);
        });
        places.push_back({at, blocks, parts.size()});
    }

    const VdbValues metadata = fileMetadata(volume, clamped);
    for (std::size_t i = 0; i < grids.size(); ++i) {
        grids[i].layout.metadata.insert(metadata.begin(), metadata.end());
        VdbGridHead grid = vdbGridHead(grids[i].layout, topologyOf(grids[i]));
        const std::int64_t offsets[3] = {
            places[i].at + static_cast<std::int64_t>(grid.offsets + 3 * sizeof(std::int64_t)), places[i].blocks,
            places[i].end};
        std::memcpy(grid.bytes.data() + grid.offsets, offsets, sizeof(offsets));
        parts.put(places[i].at, grid.bytes);
    }
    head = vdbFileHead(no_number, metadata, static_cast<int>(grids.size()));
    const std::uint64_t sum = checksum(head.data(), head.size(), parts.checksumOfAll());
    head.replace(kVdbNumberAt, no_number.size(), numberFrom(sum));
    parts.put(0, head);
    file.finish();
    if (!parts.readsBack()) file.fail(0);
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
    if (!(volume.reference_irradiance > 0) || !std::isfinite(volume.reference_irradiance))
        throw Error(ErrorCode::Failed,
                    fmt::format("cannot write {}: the reference irradiance is {} W/m2; it must be positive", path,
                                volume.reference_irradiance),
                    path);
    CheckedFile& file = outputs.open(path);  // before the work: a folder that cannot be written to shows at once
    try {
        const FileLeaves leaves = leavesOf(volume);
        std::atomic<std::int64_t> clamped{0};
        std::vector<GridSource> grids = gridsOf(volume, leaves, options, clamped);
        if (grids.empty())
            throw Error(ErrorCode::Failed,
                        fmt::format("cannot write {}: no grid was asked for; add one to grids", path), path);
        writeGrids(file, volume, grids, clamped);
        std::int64_t active = 0;
        for (const auto& leaf : leaves.all) active += leaf.count();
        return active;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::Failed,
                    fmt::format("cannot write {}: out of memory; use larger voxels or where = "
                                "\"receivers\"",
                                path),
                    path);
    }
}

}  // namespace photic
