// SPDX-License-Identifier: Apache-2.0
#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStdIO.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "bake/image/atomic_file.h"
#include "bake/image/image.h"
#include "bake/report/error.h"

namespace photic {
namespace {

constexpr int kLargestSide = 32768;
constexpr float kLargestHalf = 65504.0f;

struct Window {
    Imath::Box2i box;
    int width = 0, height = 0;
};

/// Runs `body` on the opened file; anything that OpenEXR throws becomes an Error with the path.
template <typename Body>
auto withExr(const std::string& path, const Body& body) {
    const std::string bytes = readFileBytes(path);
    const bool is_exr = bytes.size() >= 4 && bytes.compare(0, 4, "\x76\x2f\x31\x01", 4) == 0;
    if (!is_exr) throw Error(ErrorCode::Input, fmt::format("'{}' is not an OpenEXR file", path));
    try {
        Imf::StdISStream stream;
        stream.str(bytes);
        Imf::InputFile file(stream);
        return body(file);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        std::string why = error.what();  // it calls what is read from memory "(string)"
        if (const auto at = why.find("\"(string)\""); at != std::string::npos) why.replace(at, 10, "'" + path + "'");
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}', which is damaged or truncated ({} bytes): {}",
                                                  path, bytes.size(), why));
    }
}

Window windowOf(const Imf::InputFile& file, const std::string& path) {
    const Imath::Box2i box = file.header().dataWindow();
    const std::int64_t width = std::int64_t(box.max.x) - box.min.x + 1,
                       height = std::int64_t(box.max.y) - box.min.y + 1;
    if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide)
        throw Error(ErrorCode::Input,
                    fmt::format("'{}' is {} x {} pixels; the limit is {} a side", path, width, height, kLargestSide));
    return {box, static_cast<int>(width), static_cast<int>(height)};
}

std::vector<std::string> channelNames(const Imf::InputFile& file) {
    std::vector<std::string> names;
    for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c)
        names.emplace_back(c.name());
    std::sort(names.begin(), names.end());
    return names;
}

/// A slice whose first pixel, that of the data window's corner, is values[0].
Imf::Slice sliceOver(float* values, const Window& window, int pixel_stride) {
    return Imf::Slice::Make(
        Imf::FLOAT, values, window.box, sizeof(float) * static_cast<std::size_t>(pixel_stride),
        sizeof(float) * static_cast<std::size_t>(pixel_stride) * static_cast<std::size_t>(window.width));
}

void checkChannel(const Imf::InputFile& file, const std::string& name, const std::string& path) {
    const Imf::Channel* channel = file.header().channels().findChannel(name);
    if (channel == nullptr)
        throw Error(ErrorCode::Input, fmt::format("'{}' has no channel '{}'; it has {}", path, name,
                                                  fmt::join(channelNames(file), ", ")));
    if (channel->xSampling != 1 || channel->ySampling != 1)
        throw Error(ErrorCode::Input,
                    fmt::format("channel '{}' of '{}' is subsampled; save it at full resolution", name, path));
}

std::vector<std::string> writtenNames(int channels) {
    switch (channels) {
        case 1:
            return {"Y"};
        case 3:
            return {"R", "G", "B"};
        case 4:
            return {"R", "G", "B", "A"};
        default:
            throw Error(ErrorCode::Failed,
                        fmt::format("an image of {} channels cannot be written; 1, 3 or 4 can", channels));
    }
}

Imf::PixelType pixelType(ChannelDepth depth) {
    if (depth == ChannelDepth::Half) return Imf::HALF;
    return depth == ChannelDepth::Float ? Imf::FLOAT : Imf::UINT;
}

/// The rows of `image` in the file's own pixel type: the library converts on reading only.
std::vector<char> pack(const Image& image, ChannelDepth depth) {
    const auto convert = [&](auto zero, const auto& from_float) {
        using T = decltype(zero);
        std::vector<char> bytes(image.pixels.size() * sizeof(T));
        T* out = reinterpret_cast<T*>(bytes.data());
        for (std::size_t i = 0; i < image.pixels.size(); ++i) out[i] = from_float(image.pixels[i]);
        return bytes;
    };
    if (depth == ChannelDepth::Half)  // finite values stay finite
        return convert(Imath::half(0.0f), [](float v) {
            return Imath::half(std::isfinite(v) ? std::clamp(v, -kLargestHalf, kLargestHalf) : v);
        });
    if (depth == ChannelDepth::Float) return convert(0.0f, [](float v) { return v; });
    return convert(0u, [](float v) {
        const double clamped = v > 0 ? std::min(std::floor(double(v) + 0.5), 4294967295.0) : 0.0;
        return static_cast<unsigned>(clamped);
    });
}

}  // namespace

std::vector<std::string> exrChannelNames(const std::string& path) {
    return withExr(path, [](const Imf::InputFile& file) { return channelNames(file); });
}

std::vector<HeightMap> readExrChannels(const std::string& path, const std::vector<std::string>& channels) {
    return withExr(path, [&](Imf::InputFile& file) {
        const Window window = windowOf(file, path);
        for (const std::string& name : channels) checkChannel(file, name, path);

        // One frame buffer per channel, so that a name may be asked for twice.
        std::vector<HeightMap> maps(channels.size());
        for (std::size_t i = 0; i < channels.size(); ++i) {
            HeightMap& map = maps[i];
            map.width = window.width, map.height = window.height;
            map.values.resize(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height));
            map.half = file.header().channels().findChannel(channels[i])->type == Imf::HALF;
            Imf::FrameBuffer buffer;
            buffer.insert(channels[i], sliceOver(map.values.data(), window, 1));
            file.setFrameBuffer(buffer);
            file.readPixels(window.box.min.y, window.box.max.y);
        }
        return maps;
    });
}

Image readExr(const std::string& path) {
    return withExr(path, [&](Imf::InputFile& file) {
        const Window window = windowOf(file, path);
        const Imf::ChannelList& present = file.header().channels();
        std::vector<std::string> names;
        if (present.findChannel("R") && present.findChannel("G") && present.findChannel("B")) {
            names = {"R", "G", "B"};
            if (present.findChannel("A")) names.emplace_back("A");
        } else if (present.findChannel("Y")) {
            names = {"Y"};
        } else {
            throw Error(ErrorCode::Input, fmt::format("'{}' has neither R, G, B nor Y; it has {}", path,
                                                      fmt::join(channelNames(file), ", ")));
        }
        for (const std::string& name : names) checkChannel(file, name, path);

        Image image;
        image.width = window.width, image.height = window.height, image.channels = static_cast<int>(names.size());
        image.pixels.resize(static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height) *
                            names.size());
        Imf::FrameBuffer buffer;
        for (std::size_t c = 0; c < names.size(); ++c)
            buffer.insert(names[c], sliceOver(image.pixels.data() + c, window, image.channels));
        file.setFrameBuffer(buffer);
        file.readPixels(window.box.min.y, window.box.max.y);
        return image;
    });
}

void writeExr(const std::string& path, const Image& image, ChannelDepth depth) {
    writeFileAtomically(path, encodeExr(path, image, depth));
}

std::string encodeExr(const std::string& path, const Image& image, ChannelDepth depth) {
    const std::vector<std::string> names = writtenNames(image.channels);
    const Imf::PixelType type = pixelType(depth);
    const std::size_t sample = depth == ChannelDepth::Half ? 2 : 4;
    std::vector<char> packed = pack(image, depth);

    // The file is made in memory, so that only those who write it have to look after the disk.
    Imf::StdOSStream stream;
    try {
        Imf::Header header(image.width, image.height);
        header.compression() = Imf::ZIP_COMPRESSION;
        Imf::FrameBuffer buffer;
        for (std::size_t c = 0; c < names.size(); ++c) {
            header.channels().insert(names[c], Imf::Channel(type));
            buffer.insert(names[c], Imf::Slice(type, packed.data() + c * sample, sample * names.size(),
                                               sample * names.size() * static_cast<std::size_t>(image.width)));
        }
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(buffer);
        file.writePixels(image.height);
    } catch (const std::exception& error) {
        throw Error(ErrorCode::Failed, fmt::format("cannot encode '{}': {}", path, error.what()));
    }
    return stream.str();
}

}  // namespace photic
