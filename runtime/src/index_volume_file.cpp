// SPDX-License-Identifier: Apache-2.0
// From a path or from bytes in memory to IndexVolumes.
#include <cmath>

#include "runtime/format/index_volume_format.h"
#include "runtime/src/bytes.h"
#include "runtime/src/file_bytes.h"
#include "runtime/src/guarded.h"
#include "runtime/src/index_volume_data.h"

namespace photic::runtime {
namespace {

/// One object of a file.
class ObjectReader {
public:
    ObjectReader(const Bytes& file, unsigned version, std::uint64_t header, std::uint64_t& memory_left)
        : file_(file), version_(version), header_(header), memory_left_(memory_left) {}

    IndexVolume read() {
        auto data = std::make_shared<IndexVolumeData>();
        data->name = file_.text(header_ + format::kIndexNameAt, format::kIndexNameSize, "an object's name");
        what_ = "the object '" + data->name + "'";
        const std::uint64_t shape = version_ >= format::kIndexVersion ? at<std::uint64_t>(format::kIndexShapeAt) : 0;
        if (shape != 0) data->shape = readShape(file_, aligned(shape, "its shape"), what_, memory_left_);
        readPlace(*data);
        readArrays(*data);
        if (version_ > format::kIndexFirstVersion) readReflection(*data);
        return IndexVolume(std::move(data));
    }

private:
    template <class T>
    T at(unsigned place) const {
        return file_.get<T>(header_ + place);  // the headers are there: the caller has asked
    }
    [[noreturn]] void refuse(const std::string& why) const { fail(ErrorCode::Format, what_ + ": " + why); }

    float number(unsigned place, float least, float most, const char* of) const {
        const float value = at<float>(place);
        if (!(value >= least && value <= most))
            refuse(std::string(of) + " is " + std::to_string(value) + "; it must be " + std::to_string(least) + " to " +
                   std::to_string(most));
        return value;
    }

    void readPlace(IndexVolumeData& data) const {
        for (unsigned row = 0; row < 3; ++row) {
            for (unsigned column = 0; column < 4; ++column) {
                const double value = at<double>(format::kIndexWorldFromNodeAt + 8 * (4 * row + column));
                (column < 3 ? data.transform.world_from_index[3 * row + column] : data.transform.origin_world[row]) =
                    value;
            }
        }
        finishTransform(data.transform, what_);
        Double3 low{}, high{};
        if (data.shape) boundsOf(*data.shape, low, high);
        const bool samples = at<std::uint32_t>(format::kIndexNodesAt) != 0 || !data.shape;
        for (unsigned a = 0; a < 3; ++a) {
            data.scattering[a] = number(format::kIndexScatteringAt + 4 * a, 0, 1e9F, "its scattering");
            const auto count = at<std::uint32_t>(format::kIndexNodesAt + 4 * a);
            if (!samples) {
                if (count != 0) refuse("it has nodes along some axes, and none along others");
                data.box_low[a] = low[a], data.box_high[a] = high[a];
                continue;
            }
            if (count < format::kIndexLeastNodes || count > format::kIndexMostNodes)
                refuse("it has " + std::to_string(count) + " nodes along an axis; 4 to 2048 are read");
            data.count[a] = static_cast<int>(count);
            const float last = static_cast<float>(count - 1);
            data.box_low[a] = double(number(format::kIndexBoxAt + 4 * a, 0, last, "a side of its box"));
            data.box_high[a] = double(number(format::kIndexBoxAt + 12 + 4 * a, 0, last, "a side of its box"));
            if (!(data.box_low[a] < data.box_high[a])) refuse("its box is empty");
            if (data.shape && (low[a] < data.box_low[a] || high[a] > data.box_high[a]))
                refuse("its shape reaches out of the box of its samples");
        }
        constexpr float kMostG = 0.9999F;
        data.anisotropy = number(format::kIndexAnisotropyAt, -kMostG, kMostG, "its anisotropy");
        const auto flags = at<std::uint32_t>(format::kIndexFlagsAt);
        if ((flags & ~format::kIndexSharpSides) != 0) refuse("it has flags of a later version; export it again");
        data.sharp_sides = (flags & format::kIndexSharpSides) != 0;
        if (data.sharp_sides && data.shape) refuse("it has a shape and sharp sides of a box");
    }

    /// Where an array of `count` elements lies; counts them against the memory.
    std::uint64_t placeOf(unsigned array, std::uint64_t count, std::uint64_t size, const char* of) const {
        return placeAt(format::kIndexOffsetsAt + 8 * array, count, size, of);
    }
    std::uint64_t placeAt(unsigned where, std::uint64_t count, std::uint64_t size, const char* of) const {
        const auto place = at<std::uint64_t>(where);
        if (place == 0) return 0;
        aligned(place, of);
        file_.require(place, count, size, of);
        if (count * size > memory_left_)
            fail(ErrorCode::Limit, what_ + " takes more memory than LoadOptions::largest_memory");
        memory_left_ -= count * size;
        return place;
    }

    std::uint64_t aligned(std::uint64_t place, const char* of) const {
        if (place % format::kIndexAlignment != 0)
            refuse(std::string(of) + " lies at byte " + std::to_string(place) + ", which is no multiple of 16");
        return place;
    }

    void readArrays(IndexVolumeData& data) const {
        const std::uint64_t nodes = data.nodeCount();
        const auto channels = at<std::uint32_t>(format::kIndexChannelsAt);
        if (nodes == 0) {
            // A shape of one index; readPlace() has seen to it.
            bool arrays = channels != 0;
            for (unsigned k = 0; k < 4; ++k) arrays = arrays || at<std::uint64_t>(format::kIndexOffsetsAt + 8 * k) != 0;
            if (arrays) refuse("it has arrays, and no nodes");
            return;
        }
        if (channels != 1 && channels != 3) refuse("it has " + std::to_string(channels) + " channels; 1 or 3 are read");
        std::uint64_t place = placeOf(format::kIndexSpline, nodes * channels, sizeof(float), "its spline");
        if (place == 0) refuse("it has no spline");
        for (std::uint32_t c = 0; c < channels; ++c, place += nodes * sizeof(float)) copy(place, nodes, data.spline[c]);
        for (const auto& channel : data.spline)
            for (const float e : channel)
                // n^2 is above 0, and far below this.
                if (!(e > -0.5F && e < 5001)) refuse("its spline holds " + std::to_string(e) + ", which is no index");
        place = placeOf(format::kIndexAttenuation, nodes, sizeof(Half4), "its attenuation");
        if (place != 0) copy(place, nodes, data.attenuation), requireHalves(data.attenuation, 1, "its attenuation");
        place = placeOf(format::kIndexGlow, nodes, sizeof(Half4), "its glow");
        if (place != 0) copy(place, nodes, data.glow), requireGlow(data.glow);
        place = placeOf(format::kIndexFaces, nodes, 1, "its faces");
        if (place != 0) copy(place, nodes, data.faces);
    }

    void readReflection(IndexVolumeData& data) const {
        for (unsigned c = 0; c < 3; ++c)
            data.albedo[c] = number(format::kIndexAlbedoAt + 4 * c, 0, 1, "its faces' albedo");
        data.roughness = number(format::kIndexRoughnessAt, 0, 1, "its faces' roughness");
        if (data.nodeCount() == 0 && at<std::uint64_t>(format::kIndexCoatAt) != 0)
            refuse("it has a coat, and no nodes");
        const std::uint64_t place = placeAt(format::kIndexCoatAt, data.nodeCount(), 3, "its coat");
        if (place != 0) copy(place, data.nodeCount(), data.coat);
    }

    template <class T>
    void copy(std::uint64_t place, std::uint64_t count, std::vector<T>& out) const {
        out.resize(static_cast<std::size_t>(count));
        std::memcpy(out.data(), file_.view(place, count * sizeof(T)).data(), out.size() * sizeof(T));
    }

    void requireHalves(const std::vector<Half4>& values, float most_of_fourth, const char* of) const {
        for (const Half4& v : values) {
            bool sound = floatOfHalf(v[3]) >= 0 && floatOfHalf(v[3]) <= most_of_fourth;
            for (std::size_t c = 0; c < 3; ++c)
                sound = sound && floatOfHalf(v[c]) >= 0 && floatOfHalf(v[c]) <= kLargestHalf;
            if (!sound) refuse(std::string(of) + " holds a value that is negative, too large or no number");
        }
    }
    void requireGlow(const std::vector<Half4>& values) const {
        for (const Half4& v : values) {
            bool sound = std::fabs(floatOfHalf(v[3])) < 1;
            for (std::size_t c = 0; c < 3; ++c)
                sound = sound && floatOfHalf(v[c]) >= 0 && floatOfHalf(v[c]) <= kLargestHalf;
            if (!sound) refuse("its glow holds a value that is negative, too large or no number");
        }
    }

    const Bytes& file_;
    unsigned version_;
    std::uint64_t header_;
    std::uint64_t& memory_left_;
    std::string what_ = "an object";
};

}  // namespace

Result<std::vector<IndexVolume>> readIndexVolumes(const void* bytes, std::size_t size, const LoadOptions& options) {
    return guarded([&]() -> Result<std::vector<IndexVolume>> {
        if (!bytes || size == 0) fail(ErrorCode::Format, "there are no bytes to read");
        if (size > options.largest_file)
            fail(ErrorCode::Limit, "the file has " + std::to_string(size) +
                                       " bytes, more than LoadOptions::largest_file, " +
                                       std::to_string(options.largest_file));
        const Bytes file(static_cast<const unsigned char*>(bytes), size, "the file");
        file.require(0, 1, format::kIndexFileHeader, "its header");
        if (std::memcmp(bytes, format::kIndexMagic, 8) != 0)
            fail(ErrorCode::Format, "it is no file of index volumes; photic export scene.toml -o name.ivol makes one");
        const auto version = file.get<std::uint32_t>(format::kIndexVersionAt);
        if (version < format::kIndexFirstVersion || version > format::kIndexVersion)
            fail(ErrorCode::Format,
                 "it has version " + std::to_string(version) + "; only 1 to 3 are read: export it again");
        const auto told = file.get<std::uint64_t>(format::kIndexFileSizeAt);
        if (told != size)
            fail(ErrorCode::Format, "it has " + std::to_string(size) + " bytes and says " + std::to_string(told) +
                                        "; the file is cut short or damaged");
        const auto objects = file.get<std::uint32_t>(format::kIndexObjectsAt);
        if (objects < 1 || objects > format::kIndexMostObjects)
            fail(ErrorCode::Format, "it has " + std::to_string(objects) + " objects; 1 to 256 are read");
        const unsigned header =
            version == format::kIndexFirstVersion ? format::kIndexFirstHeader : format::kIndexObjectHeader;
        file.require(format::kIndexFileHeader, objects, header, "its objects' headers");
        std::uint64_t memory_left = options.largest_memory;
        std::vector<IndexVolume> out;
        for (std::uint32_t i = 0; i < objects; ++i)
            out.push_back(
                ObjectReader(file, version, format::kIndexFileHeader + std::uint64_t{header} * i, memory_left).read());
        return out;
    });
}

Result<std::vector<IndexVolume>> loadIndexVolumes(const std::string& path, const LoadOptions& options) {
    return guarded([&]() -> Result<std::vector<IndexVolume>> {
        const FileBytes bytes = readFile(path, options.largest_file);
        Result<std::vector<IndexVolume>> volumes = readIndexVolumes(bytes.data.get(), bytes.size, options);
        if (!volumes) return Error{volumes.error().code, "'" + path + "': " + volumes.error().message};
        return volumes;
    });
}

}  // namespace photic::runtime
