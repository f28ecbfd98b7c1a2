// SPDX-License-Identifier: Apache-2.0
#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStdIO.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <set>
#include <string_view>

#include "bake/image/atomic_file.h"
#include "bake/image/height_flaws.h"
#include "bake/image/image.h"
#include "bake/libraries/openexr.h"
#include "bake/report/error.h"

namespace photic {
namespace {

constexpr float kLargestHalf = 65504.0f;

/// Where the pixels of a part lie.
struct Windows {
    Imath::Box2i data, display;
    int dataWidth() const { return data.max.x - data.min.x + 1; }
    int dataHeight() const { return data.max.y - data.min.y + 1; }
    int width() const { return display.max.x - display.min.x + 1; }
    int height() const { return display.max.y - display.min.y + 1; }
};

std::uint32_t littleEndian(const std::string& bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i > 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[at + i - 1]);
    return value;
}

/// Bytes of an attribute whose type settles them; 0 of the others. OpenEXR reads as many, whatever the header says.
std::size_t bytesOfType(const std::string& type) {
    struct Fixed {
        std::string_view type;
        std::size_t bytes;
    };
    constexpr std::array<Fixed, 24> kFixed{{{"box2f", 16},
                                            {"box2i", 16},
                                            {"chromaticities", 32},
                                            {"compression", 1},
                                            {"deepImageState", 1},
                                            {"double", 8},
                                            {"envmap", 1},
                                            {"float", 4},
                                            {"int", 4},
                                            {"keycode", 28},
                                            {"lineOrder", 1},
                                            {"m33d", 72},
                                            {"m33f", 36},
                                            {"m44d", 128},
                                            {"m44f", 64},
                                            {"rational", 8},
                                            {"tiledesc", 9},
                                            {"timecode", 8},
                                            {"v2d", 16},
                                            {"v2f", 8},
                                            {"v2i", 8},
                                            {"v3d", 24},
                                            {"v3f", 12},
                                            {"v3i", 12}}};
    for (const Fixed& f : kFixed)
        if (f.type == type) return f.bytes;
    return 0;
}

/// Where a list of channels that begins at `at` ends, going by its own names; npos where the file ends before.
std::size_t endOfChannels(const std::string& bytes, std::size_t at) {
    constexpr std::size_t kAfterName = 16;  // type, linearity, two samplings
    while (at < bytes.size() && bytes[at] != 0) {
        const std::size_t name_end = bytes.find('\0', at);
        if (name_end == std::string::npos) return std::string::npos;
        at = name_end + 1 + kAfterName;
    }
    return at < bytes.size() ? at + 1 : std::string::npos;
}

/// Refuses a header that says of an attribute that it is longer than what is left of the file: OpenEXR would take as
/// much memory before it finds out, two gigabytes for a file of 38 bytes. So does one whose attribute has another
/// length than its contents, by which OpenEXR goes: the next would be looked for in two places. What else is wrong
/// it tells itself.
void checkAttributes(const std::string& bytes, const std::string& path) {
    const auto refuse = [&](const std::string& why) {
        throw Error(ErrorCode::Input, fmt::format("cannot read '{}', which is damaged or truncated ({} bytes): an "
                                                  "attribute of its header {}",
                                                  path, bytes.size(), why));
    };
    const bool has_parts = bytes.size() > 5 && (static_cast<unsigned char>(bytes[5]) & 0x10) != 0;
    bool begins = true;  // a header; of several parts, one that is empty ends them
    for (std::size_t at = 8; at < bytes.size();) {
        if (bytes[at] == 0) {
            if (!has_parts || begins) return;
            begins = true, ++at;
            continue;
        }
        begins = false;
        const std::size_t name_end = bytes.find('\0', at),
                          type_end = bytes.find('\0', std::min(name_end, bytes.size() - 1) + 1);
        if (type_end == std::string::npos || bytes.size() - type_end < 5) return;
        const std::uint32_t length = littleEndian(bytes, type_end + 1);
        at = type_end + 5;
        if (length > bytes.size() - at) refuse(fmt::format("is said to be {} bytes long", length));
        const std::string type = bytes.substr(name_end + 1, type_end - name_end - 1);
        const std::size_t holds = type == "chlist" ? endOfChannels(bytes, at) - at : bytesOfType(type);
        if (holds != 0 && holds != length)
            refuse(fmt::format("of the type {} is said to be {} bytes long, which is not what it holds", type, length));
        at += length;
    }
}

/// Runs `body` on the opened file; anything that OpenEXR throws becomes an Error with the path.
template <typename Body>
auto withExr(const std::string& path, const Body& body) {
    const std::string bytes = readFileBytes(path);
    const bool is_exr = bytes.size() >= 4 && bytes.compare(0, 4, "\x76\x2f\x31\x01", 4) == 0;
    if (!is_exr) throw Error(ErrorCode::Input, fmt::format("'{}' is not an OpenEXR file", path));
    checkAttributes(bytes, path);
    try {
        Imf::StdISStream stream;
        stream.str(bytes);
        Imf::MultiPartInputFile file = openExr(stream);
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

void checkSize(const Imath::Box2i& box, const std::string& path) {
    const std::int64_t width = std::int64_t(box.max.x) - box.min.x + 1,
                       height = std::int64_t(box.max.y) - box.min.y + 1;
    if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide || width * height > kMostPixels)
        throw Error(ErrorCode::Input, fmt::format("'{}' is {} x {} pixels; the limit is {} a side and {} in all", path,
                                                  width, height, kLargestSide, kMostPixels));
}

Windows windowsOf(const Imf::Header& header, const std::string& path) {
    const Windows windows{header.dataWindow(), header.displayWindow()};
    checkSize(windows.data, path);
    checkSize(windows.display, path);
    const auto &data = windows.data, &display = windows.display;
    if (!data.intersects(display))
        throw Error(
            ErrorCode::Input,
            fmt::format("the data of '{}', pixels ({}, {}) to ({}, {}), lie outside its display window, ({}, {}) "
                        "to ({}, {}): nothing of it would be seen; save it again without cropping",
                        path, data.min.x, data.min.y, data.max.x, data.max.y, display.min.x, display.min.y,
                        display.max.x, display.max.y));
    return windows;
}

std::vector<std::string> channelNames(const Imf::Header& header) {
    std::vector<std::string> names;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) names.emplace_back(c.name());
    std::sort(names.begin(), names.end());
    return names;
}

bool hasChannels(const Imf::Header& header, const std::vector<std::string>& names) {
    return std::all_of(names.begin(), names.end(),
                       [&](const std::string& name) { return header.channels().findChannel(name) != nullptr; });
}

/// The parts with their channels, for messages.
std::string partsInWords(const Imf::MultiPartInputFile& file) {
    std::vector<std::string> parts;
    for (int p = 0; p < file.parts(); ++p) {
        const Imf::Header& header = file.header(p);
        parts.push_back(fmt::format("'{}' ({})", header.hasName() ? header.name() : std::to_string(p),
                                    fmt::join(channelNames(header), ", ")));
    }
    return fmt::format("{}", fmt::join(parts, ", "));
}

/// The one part that holds all `names`.
int partWith(const Imf::MultiPartInputFile& file, const std::vector<std::string>& names, const std::string& path) {
    std::vector<int> fitting;
    for (int p = 0; p < file.parts(); ++p)
        if (hasChannels(file.header(p), names)) fitting.push_back(p);
    if (fitting.size() > 1)
        throw Error(ErrorCode::Input,
                    fmt::format("{} parts of '{}' have the channel '{}'; save the part that is meant as a file of its "
                                "own. It has {}",
                                fitting.size(), path, fmt::join(names, "', '"), partsInWords(file)));
    if (fitting.empty()) {
        for (const std::string& name : names)
            if (file.parts() == 1 && !hasChannels(file.header(0), {name}))
                throw Error(ErrorCode::Input, fmt::format("'{}' has no channel '{}'; it has {}", path, name,
                                                          fmt::join(channelNames(file.header(0)), ", ")));
        throw Error(ErrorCode::Input, fmt::format("'{}' has no part with the channel '{}'; it has {}", path,
                                                  fmt::join(names, "', '"), partsInWords(file)));
    }
    const Imf::Header& header = file.header(fitting.front());
    if (header.hasType() && Imf::isDeepData(header.type()))
        throw Error(ErrorCode::Input, fmt::format("'{}' holds deep data, many values a pixel; flatten it", path));
    for (const std::string& name : names) {
        const Imf::Channel& channel = *header.channels().findChannel(name);
        if (channel.xSampling != 1 || channel.ySampling != 1)
            throw Error(ErrorCode::Input,
                        fmt::format("channel '{}' of '{}' is subsampled; save it at full resolution", name, path));
    }
    return fitting.front();
}

/// Reads channels of a part as they lie in the display window, interleaved.
std::vector<float> readPixels(Imf::InputPart& part, const Windows& windows, const std::vector<std::string>& names) {
    const std::size_t count = names.size(), row = static_cast<std::size_t>(windows.dataWidth()) * count;
    std::vector<float> data(row * static_cast<std::size_t>(windows.dataHeight()));
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < count; ++c)
        buffer.insert(names[c], Imf::Slice::Make(Imf::FLOAT, data.data() + c, windows.data, sizeof(float) * count,
                                                 sizeof(float) * row));
    part.setFrameBuffer(buffer);
    part.readPixels(windows.data.min.y, windows.data.max.y);
    if (windows.data == windows.display) return data;

    std::vector<float> shown(static_cast<std::size_t>(windows.width()) * static_cast<std::size_t>(windows.height()) *
                             count);
    const int left = std::max(windows.data.min.x, windows.display.min.x),
              right = std::min(windows.data.max.x, windows.display.max.x);
    for (int y = std::max(windows.data.min.y, windows.display.min.y);
         y <= std::min(windows.data.max.y, windows.display.max.y); ++y) {
        const auto place = [&](const Imath::Box2i& box, int width) {
            return (static_cast<std::size_t>(y - box.min.y) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(left - box.min.x)) *
                   count;
        };
        std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(place(windows.data, windows.dataWidth())),
                    static_cast<std::size_t>(right - left + 1) * count,
                    shown.begin() + static_cast<std::ptrdiff_t>(place(windows.display, windows.width())));
    }
    return shown;
}

/// The compression that has changed a channel's numbers, or null. B44 is of half floats alone, and DWA squeezes the
/// channels that it takes for colours and brightness: anything else is stored as it is.
const char* lossOf(const Imf::Header& header, const std::string& channel) {
    const bool half = header.channels().findChannel(channel)->type == Imf::HALF;
    const bool whole = header.channels().findChannel(channel)->type == Imf::UINT;
    const std::string last = channel.substr(channel.rfind('.') + 1);
    constexpr std::array<std::string_view, 6> kSeen{"R", "G", "B", "Y", "BY", "RY"};
    const bool squeezed = !whole && std::find(kSeen.begin(), kSeen.end(), last) != kSeen.end();
    switch (header.compression()) {
        case Imf::PXR24_COMPRESSION:
            return half || whole ? nullptr : "PXR24";  // floats lose their last 8 bits
        case Imf::B44_COMPRESSION:
            return half ? "B44" : nullptr;
        case Imf::B44A_COMPRESSION:
            return half ? "B44A" : nullptr;
        case Imf::DWAA_COMPRESSION:
            return squeezed ? "DWAA" : nullptr;
        case Imf::DWAB_COMPRESSION:
            return squeezed ? "DWAB" : nullptr;
        default:
            return nullptr;
    }
}

/// What a file's windows and compression have cost the heights of a channel.
std::vector<std::string> flawsOf(const Imf::Header& header, const Windows& windows, const std::string& channel) {
    std::vector<std::string> flaws;
    const auto &data = windows.data, &display = windows.display;
    if (data != display) {
        const auto pixels = [](double w, double h) { return w * h; };
        const double both = pixels(std::min(data.max.x, display.max.x) - std::max(data.min.x, display.min.x) + 1,
                                   std::min(data.max.y, display.max.y) - std::max(data.min.y, display.min.y) + 1),
                     shown = pixels(windows.width(), windows.height()),
                     stored = pixels(windows.dataWidth(), windows.dataHeight());
        if (both < shown)
            flaws.push_back(
                fmt::format("has data for {:.3g} % of its display window of {} x {} pixels; the rest is 0: if "
                            "it was cropped by mistake, save it whole",
                            100 * both / shown, windows.width(), windows.height()));
        if (both < stored)
            flaws.push_back(
                fmt::format("has {:.3g} % of its data outside its display window of {} x {} pixels, where it "
                            "is left out; crop it, or widen the display window",
                            100 * (1 - both / stored), windows.width(), windows.height()));
    }
    const char* lossy = lossOf(header, channel);
    if (lossy && header.compression() == Imf::PXR24_COMPRESSION)
        flaws.emplace_back(
            "is compressed with loss (PXR24): heights keep five digits, which is little where they have an offset; "
            "save it with ZIP or PIZ, which lose nothing");
    else if (lossy)
        flaws.push_back(
            fmt::format("is compressed with loss ({}): light was seen to be off by 4 to 12 %; save it with ZIP "
                        "or PIZ, which lose nothing",
                        lossy));
    return flaws;
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
    return withExr(path, [](const Imf::MultiPartInputFile& file) {
        std::set<std::string> names;
        for (int p = 0; p < file.parts(); ++p)
            for (std::string& name : channelNames(file.header(p))) names.insert(std::move(name));
        return std::vector<std::string>(names.begin(), names.end());
    });
}

std::vector<HeightMap> readExrChannels(const std::string& path, const std::vector<std::string>& channels) {
    return withExr(path, [&](Imf::MultiPartInputFile& file) {
        const int index = partWith(file, channels, path);
        const Imf::Header& header = file.header(index);
        const Windows windows = windowsOf(header, path);
        Imf::InputPart part(file, index);
        // One channel at a time, so that a name may be asked for twice.
        std::vector<HeightMap> maps(channels.size());
        for (std::size_t i = 0; i < channels.size(); ++i) {
            HeightMap& map = maps[i];
            map.width = windows.width(), map.height = windows.height();
            map.values = readPixels(part, windows, {channels[i]});
            const Imf::PixelType type = header.channels().findChannel(channels[i])->type;
            map.half = type == Imf::HALF;
            map.flaws = flawsOf(header, windows, channels[i]);
            if (!map.half) noteEightBits(map);
        }
        return maps;
    });
}

Image readExr(const std::string& path) {
    return withExr(path, [&](Imf::MultiPartInputFile& file) {
        std::vector<std::string> names;
        for (int p = 0; p < file.parts() && names.empty(); ++p) {
            if (hasChannels(file.header(p), {"R", "G", "B"})) {
                names = {"R", "G", "B"};
                if (hasChannels(file.header(p), {"A"})) names.emplace_back("A");
            } else if (hasChannels(file.header(p), {"Y"})) {
                names = {"Y"};
            }
        }
        if (names.empty())
            throw Error(ErrorCode::Input,
                        fmt::format("'{}' has neither R, G, B nor Y; it has {}", path, partsInWords(file)));
        const int index = partWith(file, names, path);
        const Windows windows = windowsOf(file.header(index), path);
        Imf::InputPart part(file, index);
        return Image{windows.width(), windows.height(), static_cast<int>(names.size()),
                     readPixels(part, windows, names)};
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
