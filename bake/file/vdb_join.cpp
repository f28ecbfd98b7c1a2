// SPDX-License-Identifier: Apache-2.0
#include "bake/file/vdb_join.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <list>
#include <mutex>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "bake/file/file_bytes.h"
#include "bake/file/grid_writer.h"
#include "bake/report/error.h"
#include "bake/volume/byte_cursor.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr std::size_t kMaskBytes = 64;

[[noreturn]] void refuse(const std::string& name, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("cannot read {}: {}", name, why), name);
}

std::int64_t bitsIn(const VdbGrid::Mask& mask) {
    std::int64_t bits = 0;
    for (const std::uint64_t word : mask) bits += std::popcount(word);
    return bits;
}

/// Whether a grid holds one voxel, and that is 0: what stands for no light at all.
bool isDark(const VdbGrid& grid) {
    if (grid.leaves.size() != 1) return false;
    const VdbGrid::Mask mask = grid.mask(grid.leaves.front());
    if (bitsIn(mask) != 1) return false;
    float values[3 * VdbGrid::kVoxels];
    grid.values(grid.leaves.front(), values);
    for (int i = 0; i < VdbGrid::kVoxels; ++i)
        for (int c = 0; c < grid.components && (mask[static_cast<std::size_t>(i >> 6)] >> (i & 63) & 1); ++c)
            if (values[i * grid.components + c] != 0) return false;
    return true;
}

VdbPart::Grid gridOf(const std::string& name, const VdbGrid& from) {
    if (from.components == 0 || !from.tiles.empty() || !from.transform)
        refuse(name, fmt::format("its grid {} is none that photic bake writes", from.name));
    VdbPart::Grid grid;
    VdbGridLayout& layout = grid.layout;
    layout.name = from.name, layout.components = from.components, layout.half = from.storedAsHalf();
    layout.compression = from.compression(), layout.transform = *from.transform;
    if (const auto type = from.metadata.find("vector_type"); type != from.metadata.end())
        layout.metadata["vector_type"] = type->second;
    grid.leaves.reserve(from.leaves.size()), grid.bytes.reserve(from.leaves.size());
    const std::size_t most = mostBytesOfLeaf(layout);
    for (const VdbLeaf& leaf : from.leaves) {
        const std::size_t size = from.bytesOf(leaf);
        if (size > most) refuse(name, fmt::format("its grid {} is packed as photic bake packs none", from.name));
        grid.leaves.push_back({leaf.origin, from.mask(leaf)});
        grid.bytes.push_back({static_cast<std::int64_t>(leaf.mask), static_cast<std::uint32_t>(size)});
    }
    return grid;
}

/// The order in which writeVdb() writes grids.
std::pair<int, std::string> place(const std::string& name) {
    constexpr std::string_view kFirst[] = {format::kIrradiance, format::kDirection, format::kIrradiance2,
                                           format::kDirection2};
    const auto* const found = std::find(std::begin(kFirst), std::end(kFirst), name);
    return {static_cast<int>(found - std::begin(kFirst)), name};
}

/// Files that are read from in turn by several threads, some of them open at a time.
class OpenFiles {
public:
    void read(const VdbPart& part, std::int64_t at, std::size_t size, char* to) {
        const std::shared_ptr<const Descriptor> file = opened(part);
        for (std::size_t done = 0; done < size;) {
            const ssize_t n =
                ::pread(file->number, to + done, size - done, static_cast<off_t>(at + static_cast<std::int64_t>(done)));
            if (n < 0 && errno == EINTR) continue;
            if (n <= 0) refuse(part.name(), "it cannot be read, or changes meanwhile");
            done += static_cast<std::size_t>(n);
        }
    }

private:
    struct Descriptor {
        int number = -1;
        explicit Descriptor(int n) : number(n) {}
        Descriptor(const Descriptor&) = delete;
        Descriptor& operator=(const Descriptor&) = delete;
        ~Descriptor() { ::close(number); }
    };
    static constexpr std::size_t kMostOpen = 32;

    std::shared_ptr<const Descriptor> opened(const VdbPart& part) {
        const std::lock_guard lock(mutex_);
        for (const auto& [of, file] : files_)
            if (of == &part) return file;
        const int number = ::open(part.path().c_str(), O_RDONLY | O_CLOEXEC);
        if (number < 0) refuse(part.name(), std::strerror(errno));
        files_.emplace_front(&part, std::make_shared<const Descriptor>(number));
        if (files_.size() > kMostOpen) files_.pop_back();
        return files_.front().second;
    }

    std::mutex mutex_;
    std::list<std::pair<const VdbPart*, std::shared_ptr<const Descriptor>>> files_;
};

/// One grid of all parts, its leaves in tree order.
struct JoinedGrid {
    VdbGridLayout layout;
    std::vector<VdbTopology> leaves;
    struct Place {
        const VdbPart* part;
        VdbPart::Grid::Bytes bytes;
    };
    std::vector<Place> places;
};

JoinedGrid joined(const std::string& name, const std::vector<const VdbPart*>& parts) {
    struct Leaf {
        VdbTopology topology;
        JoinedGrid::Place place;
    };
    std::vector<Leaf> leaves;
    JoinedGrid grid;
    bool first = true;
    for (const VdbPart* part : parts) {
        const VdbPart::Grid* of_part = part->grid(name);
        if (!of_part) continue;
        if (std::exchange(first, false)) grid.layout = of_part->layout;
        for (std::size_t i = 0; i < of_part->leaves.size(); ++i)
            leaves.push_back({of_part->leaves[i], {part, of_part->bytes[i]}});
    }
    std::sort(leaves.begin(), leaves.end(),
              [](const Leaf& a, const Leaf& b) { return beforeInTree(a.topology.origin, b.topology.origin); });
    grid.leaves.reserve(leaves.size()), grid.places.reserve(leaves.size());
    for (const Leaf& leaf : leaves) {
        if (!grid.leaves.empty() && grid.leaves.back().origin == leaf.topology.origin)
            throw Error(ErrorCode::Input,
                        fmt::format("{} and {} both hold the voxels at ({}, {}, {}); tiles of one bake have none in "
                                    "common",
                                    grid.places.back().part->name(), leaf.place.part->name(), leaf.topology.origin.x,
                                    leaf.topology.origin.y, leaf.topology.origin.z),
                        leaf.place.part->name());
        grid.leaves.push_back(leaf.topology), grid.places.push_back(leaf.place);
    }
    return grid;
}

}  // namespace

VdbPart::VdbPart(const std::string& path, std::string name) : path_(path), name_(std::move(name)) {
    try {
        const FileBytes bytes(path);
        const VdbFile file = parseVdb(bytes.data(), bytes.size());
        const std::string prefix = format::kPrefix;
        for (const auto& [key, text] : file.metadata)
            if (key.compare(0, prefix.size(), prefix) == 0) metadata_[key.substr(prefix.size())] = text;
        if (file.grids.empty()) refuse(name_, "it holds no grid");
        dark_ = std::all_of(file.grids.begin(), file.grids.end(), isDark);
        for (const VdbGrid& grid : file.grids) grids_.push_back(gridOf(name_, grid));
    } catch (const VolumeFault& fault) {
        refuse(name_, fault.what());
    } catch (const std::bad_alloc&) {
        refuse(name_, "it is larger than memory");
    }
}

const VdbPart::Grid* VdbPart::grid(const std::string& name) const {
    const auto found =
        std::find_if(grids_.begin(), grids_.end(), [&](const Grid& grid) { return grid.layout.name == name; });
    return found == grids_.end() ? nullptr : &*found;
}

std::int64_t joinVdb(CheckedFile& file, const std::vector<std::unique_ptr<VdbPart>>& parts,
                     const std::map<std::string, std::string>& metadata, double reference_irradiance,
                     std::int64_t clamped) {
    std::vector<const VdbPart*> lit;
    for (const auto& part : parts)
        if (!part->dark()) lit.push_back(part.get());
    if (lit.empty()) lit.push_back(parts.front().get());
    std::set<std::pair<int, std::string>> names;
    for (const VdbPart* part : lit)
        for (const VdbPart::Grid& grid : part->grids()) names.insert(place(grid.layout.name));

    std::vector<JoinedGrid> grids;
    for (const auto& [number, name] : names) grids.push_back(joined(name, lit));
    OpenFiles files;
    std::vector<GridSource> sources;
    for (const JoinedGrid& grid : grids) {
        const auto copy = [&files, &grid](std::int64_t i, char* to) {
            const auto& [part, bytes] = grid.places[static_cast<std::size_t>(i)];
            files.read(*part, bytes.at, bytes.size, to);
            if (std::memcmp(to, grid.leaves[static_cast<std::size_t>(i)].mask.data(), kMaskBytes) != 0)
                refuse(part->name(), "it changes meanwhile");
            return static_cast<std::size_t>(bytes.size);
        };
        sources.push_back({grid.layout, &grid.leaves, copy});
    }
    writeGrids(file, sources, [&] { return fileMetadata(metadata, reference_irradiance, clamped); });
    std::int64_t active = 0;
    for (const VdbTopology& leaf : grids.front().leaves) active += bitsIn(leaf.mask);
    return active;
}

}  // namespace photic
