// SPDX-License-Identifier: Apache-2.0
#include "bake/file/grid_writer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "bake/threads/parallel_for.h"
#include "bake/volume/checksum.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

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
    void putLeaves(std::int64_t count, std::size_t most, const EncodeLeaf& encode) {
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

}  // namespace

VdbValues fileMetadata(const std::map<std::string, std::string>& metadata, double reference_irradiance,
                       std::int64_t clamped) {
    VdbValues values;
    for (const auto& [name, text] : metadata) {
        const std::string key = format::kPrefix + name;
        values[key] = typed(key, text);
    }
    values[format::kMetaVersion] = std::int32_t{format::kVersion};
    values[format::kMetaReferenceIrradiance] = reference_irradiance;
    values[format::kMetaUpAxis] = std::string("Z");
    values[format::kMetaClamped] = clamped;
    return values;
}

/// Writes the grids behind one another. What stands before a grid's values says how much was clamped in all of them:
/// it comes last.
void writeGrids(CheckedFile& file, std::vector<GridSource>& grids, const std::function<VdbValues()>& metadata) {
    const std::string no_number(36, '0');
    const VdbValues none = metadata();  // as many bytes as the last will have
    PartedFile parts(file);
    std::string head = vdbFileHead(no_number, none, static_cast<int>(grids.size()));
    parts.reserve(head.size());
    struct Placed {
        std::int64_t at, blocks, end;
    };
    std::vector<Placed> places;
    for (GridSource& grid : grids) {
        VdbGridLayout as_large = grid.layout;
        as_large.metadata.insert(none.begin(), none.end());
        const std::int64_t at = parts.reserve(vdbGridHead(as_large, *grid.leaves).bytes.size());
        const std::int64_t blocks = parts.size();
        const std::size_t most = mostBytesOfLeaf(grid.layout);
        parts.putLeaves(static_cast<std::int64_t>(grid.leaves->size()), most, grid.encode);
        places.push_back({at, blocks, parts.size()});
    }

    const VdbValues last = metadata();
    for (std::size_t i = 0; i < grids.size(); ++i) {
        grids[i].layout.metadata.insert(last.begin(), last.end());
        VdbGridHead grid = vdbGridHead(grids[i].layout, *grids[i].leaves);
        const std::int64_t offsets[3] = {
            places[i].at + static_cast<std::int64_t>(grid.offsets + 3 * sizeof(std::int64_t)), places[i].blocks,
            places[i].end};
        std::memcpy(grid.bytes.data() + grid.offsets, offsets, sizeof(offsets));
        parts.put(places[i].at, grid.bytes);
    }
    head = vdbFileHead(no_number, last, static_cast<int>(grids.size()));
    const std::uint64_t sum = checksum(head.data(), head.size(), parts.checksumOfAll());
    head.replace(kVdbNumberAt, no_number.size(), numberFrom(sum));
    parts.put(0, head);
    file.finish();
    if (!parts.readsBack()) file.fail(0);
}

}  // namespace photic
