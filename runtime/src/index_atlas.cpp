// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/index_atlas.h"

#include <algorithm>
#include <string>

#include "runtime/src/guarded.h"

namespace photic::runtime {
namespace {

std::size_t flatIn(const Int3& size, int x, int y, int z) {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
}

int blocksAlong(int nodes) { return (nodes + IndexAtlas::kBlock - 1) / IndexAtlas::kBlock; }

/// Whether index, attenuation and glow are one value in a block, as far as look-ups in it reach.
bool isEven(const IndexVolumeData& data, const Int3& block) {
    Int3 low, high;
    for (std::size_t a = 0; a < 3; ++a) {
        low[a] = std::max(block[a] * IndexAtlas::kBlock - 1, 0);
        high[a] = std::min(block[a] * IndexAtlas::kBlock + IndexAtlas::kBlock + 1, data.count[a] - 1);
    }
    const std::size_t first = data.flat(low[0], low[1], low[2]);
    for (int z = low[2]; z <= high[2]; ++z) {
        for (int y = low[1]; y <= high[1]; ++y) {
            for (int x = low[0]; x <= high[0]; ++x) {
                const std::size_t i = data.flat(x, y, z);
                for (const auto& channel : data.spline)
                    if (!channel.empty() && channel[i] != channel[first]) return false;
                if (!data.attenuation.empty() && data.attenuation[i] != data.attenuation[first]) return false;
                if (!data.glow.empty() && data.glow[i] != data.glow[first]) return false;
            }
        }
    }
    return true;
}

/// Distances of one object's even blocks to what is unlike them, in two sweeps of a chessboard distance.
/// @param kinds  per block: 0 is uneven, equal numbers are alike
std::vector<std::uint8_t> reachesOf(const std::vector<std::uint32_t>& kinds, const Int3& count) {
    std::vector<std::uint8_t> reach(kinds.size());
    for (std::size_t i = 0; i < kinds.size(); ++i) reach[i] = kinds[i] == 0 ? 0 : 255;
    const auto sweep = [&](int x, int y, int z, int sense) {
        const std::size_t here = flatIn(count, x, y, z);
        if (reach[here] == 0) return;
        int least = reach[here];
        for (int i = 0; i < 13; ++i) {
            // The half of the 26 neighbours that comes before in the sweep's order.
            const int nx = x + sense * (i % 3 - 1), ny = y + sense * (i / 3 % 3 - 1), nz = z + sense * (i / 9 - 1);
            const bool inside = nx >= 0 && ny >= 0 && nz >= 0 && nx < count[0] && ny < count[1] && nz < count[2];
            if (!inside) continue;  // the box ends a jump there
            const std::size_t there = flatIn(count, nx, ny, nz);
            least = std::min(least, kinds[there] == kinds[here] ? reach[there] + 1 : 1);
        }
        reach[here] = static_cast<std::uint8_t>(least);
    };
    for (int z = 0; z < count[2]; ++z)
        for (int y = 0; y < count[1]; ++y)
            for (int x = 0; x < count[0]; ++x) sweep(x, y, z, 1);
    for (int z = count[2]; z-- > 0;)
        for (int y = count[1]; y-- > 0;)
            for (int x = count[0]; x-- > 0;) sweep(x, y, z, -1);
    return reach;
}

/// Numbers even blocks by what they hold.
std::vector<std::uint32_t> kindsOf(const IndexVolumeData& data, const Int3& blocks) {
    struct Content {
        std::array<float, 3> spline{};
        Half4 attenuation{}, glow{};
        bool operator==(const Content&) const = default;
    };
    std::vector<Content> known;
    std::vector<std::uint32_t> kinds(static_cast<std::size_t>(blocks[0]) * static_cast<std::size_t>(blocks[1]) *
                                     static_cast<std::size_t>(blocks[2]));
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        const auto n = static_cast<int>(i);
        const Int3 block{n % blocks[0], n / blocks[0] % blocks[1], n / blocks[0] / blocks[1]};
        if (!isEven(data, block)) continue;
        const std::size_t node =
            data.flat(block[0] * IndexAtlas::kBlock, block[1] * IndexAtlas::kBlock, block[2] * IndexAtlas::kBlock);
        Content content;
        for (std::size_t c = 0; c < 3; ++c)
            if (!data.spline[c].empty()) content.spline[c] = data.spline[c][node];
        if (!data.attenuation.empty()) content.attenuation = data.attenuation[node];
        if (!data.glow.empty()) content.glow = data.glow[node];
        auto at = std::find(known.begin(), known.end(), content);
        constexpr std::size_t kMost = 64;  // kinds; what is beyond them is stepped through
        if (at == known.end()) {
            if (known.size() == kMost) continue;
            at = known.insert(at, content);
        }
        kinds[i] = static_cast<std::uint32_t>(at - known.begin()) + 1;
    }
    return kinds;
}

Half4 halves(const std::array<double, 4>& v) {
    Half4 out;
    for (std::size_t c = 0; c < 4; ++c) out[c] = halfOfFloat(static_cast<float>(v[c]));
    return out;
}

}  // namespace

bool IndexAtlas::lay(const std::vector<IndexVolume>& objects, std::size_t axis, int largest_texture) {
    places.assign(objects.size(), {});
    texels = blocks = {0, 0, 0};
    const bool disperses = std::any_of(objects.begin(), objects.end(),
                                       [](const IndexVolume& o) { return o.data().hasSamples() && o.disperses(); });
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const Int3& count = objects[i].data().count;
        places[i].corner[axis] = texels[axis];
        places[i].block[axis] = blocks[axis];
        for (std::size_t a = 0; a < 3; ++a) {
            texels[a] = a == axis ? texels[a] + count[a] : std::max(texels[a], count[a]);
            blocks[a] = a == axis ? blocks[a] + blocksAlong(count[a]) : std::max(blocks[a], blocksAlong(count[a]));
        }
    }
    // Shapes of one index have no samples; a texture has a texel.
    for (std::size_t a = 0; a < 3; ++a) texels[a] = std::max(texels[a], 1), blocks[a] = std::max(blocks[a], 1);
    spline_layers = texels[2] * (disperses ? 3 : 1);
    for (std::size_t i = 0; i < objects.size(); ++i)
        places[i].channel_layers = objects[i].disperses() && objects[i].data().hasSamples() ? texels[2] : 0;
    return std::max({texels[0], texels[1], spline_layers}) <= largest_texture;
}

IndexAtlas::IndexAtlas(const std::vector<IndexVolume>& objects, int largest_texture) {
    if (objects.empty()) fail(ErrorCode::Usage, "there are no index volumes to upload");
    std::size_t best = 3;
    double least = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!lay(objects, axis, largest_texture)) continue;
        const double size = double(texels[0]) * texels[1] * texels[2];
        if (best == 3 || size < least) best = axis, least = size;
    }
    if (best == 3)
        fail(ErrorCode::Limit, "the index volumes beside one another exceed the GPU's " +
                                   std::to_string(largest_texture) +
                                   " texels a side along every axis; upload fewer together, or export larger voxels");
    lay(objects, best, largest_texture);
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const IndexVolumeData& data = objects[i].data();
        if (objects[i].attenuates() && data.hasSamples()) places[i].flags |= 1, attenuates = true;
        if (objects[i].shines()) places[i].flags |= 2, glows = true;
        if (!data.faces.empty()) places[i].flags |= 4, has_faces = true;
        if (!data.coat.empty()) places[i].flags |= 8, has_coat = true;
    }
    findEven(objects);
}

void IndexAtlas::findEven(const std::vector<IndexVolume>& objects) {
    reach.assign(flatIn(blocks, 0, 0, blocks[2]), 0);
    std::size_t all = 0, with = 0;
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const IndexVolumeData& data = objects[i].data();
        const Int3 count{blocksAlong(data.count[0]), blocksAlong(data.count[1]), blocksAlong(data.count[2])};
        const std::vector<std::uint8_t> own = reachesOf(kindsOf(data, count), count);
        const Int3& at = places[i].block;
        for (int z = 0; z < count[2]; ++z) {
            for (int y = 0; y < count[1]; ++y) {
                for (int x = 0; x < count[0]; ++x) {
                    const std::uint8_t r = own[flatIn(count, x, y, z)];
                    reach[flatIn(blocks, at[0] + x, at[1] + y, at[2] + z)] = r;
                    ++all, with += r > 0;
                }
            }
        }
    }
    even = all > 0 ? static_cast<double>(with) / static_cast<double>(all) : 0;
}

/// @param value  (data, channel, node) of an object
template <class T, class Value>
std::vector<T> IndexAtlas::filled(const std::vector<IndexVolume>& objects, int layers, const Value& value) const {
    const Int3 size{texels[0], texels[1], layers};
    std::vector<T> out(flatIn(size, 0, 0, layers));
    for (std::size_t i = 0; i < objects.size(); ++i) {
        const IndexVolumeData& data = objects[i].data();
        const Place& place = places[i];
        const int channels = layers > texels[2] && place.channel_layers > 0 ? 3 : 1;
        for (int c = 0; c < channels; ++c)
            for (int z = 0; z < data.count[2]; ++z)
                for (int y = 0; y < data.count[1]; ++y)
                    for (int x = 0; x < data.count[0]; ++x)
                        out[flatIn(size, place.corner[0] + x, place.corner[1] + y,
                                   place.corner[2] + c * place.channel_layers + z)] =
                            value(data, static_cast<std::size_t>(c), Int3{x, y, z});
    }
    return out;
}

std::vector<float> IndexAtlas::spline(const std::vector<IndexVolume>& objects) const {
    return filled<float>(objects, spline_layers, [](const IndexVolumeData& data, std::size_t c, const Int3& p) {
        return data.spline[c][data.flat(p[0], p[1], p[2])];
    });
}

std::vector<Half4> IndexAtlas::gradients(const std::vector<IndexVolume>& objects) const {
    return filled<Half4>(objects, texels[2], [](const IndexVolumeData& data, std::size_t, const Int3& p) {
        // The spline at a node: weights 1/6, 2/3, 1/6, and slopes -1/2, 0, 1/2.
        constexpr double kValue[3] = {1.0 / 6, 2.0 / 3, 1.0 / 6}, kSlope[3] = {-0.5, 0, 0.5};
        const auto at = [&](int x, int y, int z) {
            const auto inside = [&](int v, std::size_t a) { return std::clamp(v, 0, data.count[a] - 1); };
            return double(data.spline[0][data.flat(inside(x, 0), inside(y, 1), inside(z, 2))]);
        };
        const double middle = at(p[0], p[1], p[2]);
        std::array<double, 4> sum{0, 0, 0, 0};
        for (int i = 0; i < 27; ++i) {
            const int x = i % 3, y = i / 3 % 3, z = i / 9;
            const double d = at(p[0] + x - 1, p[1] + y - 1, p[2] + z - 1) - middle;
            sum[0] += kSlope[x] * kValue[y] * kValue[z] * d, sum[1] += kValue[x] * kSlope[y] * kValue[z] * d;
            sum[2] += kValue[x] * kValue[y] * kSlope[z] * d, sum[3] += kValue[x] * kValue[y] * kValue[z] * d;
        }
        sum[3] += middle;
        return halves(sum);
    });
}

std::vector<Half4> IndexAtlas::attenuation(const std::vector<IndexVolume>& objects) const {
    return filled<Half4>(objects, texels[2], [](const IndexVolumeData& data, std::size_t, const Int3& p) {
        // Without an array all of the object is there, and scatters.
        if (data.attenuation.empty()) return halves({0, 0, 0, 1});
        return data.attenuation[data.flat(p[0], p[1], p[2])];
    });
}

std::vector<Half4> IndexAtlas::glow(const std::vector<IndexVolume>& objects) const {
    return filled<Half4>(objects, texels[2], [](const IndexVolumeData& data, std::size_t, const Int3& p) {
        return data.glow.empty() ? Half4{} : data.glow[data.flat(p[0], p[1], p[2])];
    });
}

std::vector<std::uint8_t> IndexAtlas::faces(const std::vector<IndexVolume>& objects) const {
    return filled<std::uint8_t>(objects, texels[2], [](const IndexVolumeData& data, std::size_t, const Int3& p) {
        return data.faces.empty() ? std::uint8_t{0} : data.faces[data.flat(p[0], p[1], p[2])];
    });
}

std::vector<std::array<std::uint8_t, 4>> IndexAtlas::coat(const std::vector<IndexVolume>& objects) const {
    using Bytes4 = std::array<std::uint8_t, 4>;
    return filled<Bytes4>(objects, texels[2], [](const IndexVolumeData& data, std::size_t, const Int3& p) {
        const std::size_t i = data.flat(p[0], p[1], p[2]);
        Bytes4 out{data.faces.empty() ? std::uint8_t{0} : data.faces[i], 0, 0, 0};
        for (std::size_t c = 0; c < 3 && !data.coat.empty(); ++c) out[c + 1] = data.coat[i][c];
        return out;
    });
}

}  // namespace photic::runtime
