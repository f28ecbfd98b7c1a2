// SPDX-License-Identifier: Apache-2.0
#include "tests/runtime/nvdb_files.h"

#include <cmath>

#include "bake/libraries/nanovdb.h"

namespace photic::test {
namespace {

nanovdb::Map mapOf(const NvdbSpec& spec) {
    const auto& m = spec.world_from_index;
    // NanoVDB takes matrices of row vectors here, as OpenVDB's are.
    const double rows[4][4] = {{m[0], m[3], m[6], 0}, {m[1], m[4], m[7], 0}, {m[2], m[5], m[8], 0}, {0, 0, 0, 1}};
    const double inverse[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};  // not read
    nanovdb::Map map;
    map.set(rows, inverse, 1.0);
    for (int a = 0; a < 3; ++a) {
        map.mVecD[a] = spec.origin_world[static_cast<std::size_t>(a)];
        map.mVecF[a] = static_cast<float>(map.mVecD[a]);
    }
    return map;
}

class Writer {
public:
    explicit Writer(const NvdbSpec& spec) : spec_(spec) {}

    template <class Value, class Build, class Get>
    void add(const char* name, const Get& get) {
        // The text ends with a zero, as C has it.
        const std::string blind = spec_.json.empty() || !handles_.empty() ? "" : spec_.json + '\0';
        handles_.push_back(nano::build<Value, Build, nanovdb::HostBuffer>(
            {name, mapOf(spec_), nanovdb::Vec3d(1, 1, 1), blind}, [&](auto& accessor) {
                for (int i = spec_.min[0]; i <= spec_.max[0]; ++i) {
                    for (int j = spec_.min[1]; j <= spec_.max[1]; ++j) {
                        for (int k = spec_.min[2]; k <= spec_.max[2]; ++k) {
                            if (spec_.active && !spec_.active(i, j, k)) continue;
                            accessor.setValue(nanovdb::Coord(i, j, k), get(spec_.values(i, j, k)));
                        }
                    }
                }
            }));
    }

    template <class Build>
    void addScalars() {
        const auto scalar = [&](const char* name, std::size_t component) {
            add<float, Build>(name, [component](const LightValues& v) { return v[component]; });
        };
        scalar("irradiance", 3);
        scalar("flux_x", 0), scalar("flux_y", 1), scalar("flux_z", 2);
        if (spec_.coloured) scalar("irradiance_r", 4), scalar("irradiance_g", 5), scalar("irradiance_b", 6);
    }

    std::vector<unsigned char> bytes() const {
        const auto codec = spec_.packing == NvdbPacking::Blosc ? nanovdb::io::Codec::BLOSC
                           : spec_.packing == NvdbPacking::Zip ? nanovdb::io::Codec::ZIP
                                                               : nanovdb::io::Codec::NONE;
        const std::string written = nano::fileBytes(handles_, codec);
        return {written.begin(), written.end()};
    }

private:
    const NvdbSpec& spec_;
    std::vector<nanovdb::GridHandle<>> handles_;
};

}  // namespace

std::vector<unsigned char> makeNvdb(const NvdbSpec& spec) {
    using nanovdb::Vec3f;
    using nanovdb::Vec4f;
    Writer writer(spec);
    const auto rgb = [](const LightValues& v) { return Vec3f(v[4], v[5], v[6]); };
    switch (spec.encoding) {
        case NvdbEncoding::Vec4:
            writer.add<Vec4f, Vec4f>("flux", [](const LightValues& v) { return Vec4f(v[0], v[1], v[2], v[3]); });
            if (spec.coloured) writer.add<Vec3f, Vec3f>("irradiance_rgb", rgb);
            break;
        case NvdbEncoding::Fp16:
            writer.addScalars<nanovdb::Fp16>();
            break;
        case NvdbEncoding::Floats:
            writer.addScalars<float>();
            break;
        case NvdbEncoding::Direction:
            if (spec.coloured) {
                writer.add<Vec3f, Vec3f>("irradiance", rgb);
            } else {
                writer.add<float, float>("irradiance", [](const LightValues& v) { return v[3]; });
            }
            writer.add<Vec3f, Vec3f>("direction", [](const LightValues& v) {
                return v[3] > 0 ? Vec3f(v[0] / v[3], v[1] / v[3], v[2] / v[3]) : Vec3f(0);
            });
            break;
    }
    return writer.bytes();
}

LightValues swirl(int i, int j, int k) {
    // A hash, so that every voxel differs from its neighbours as a caustic's do.
    const auto random = [&](unsigned salt) {
        unsigned h = static_cast<unsigned>(i) * 73856093U ^ static_cast<unsigned>(j) * 19349663U ^
                     static_cast<unsigned>(k) * 83492791U ^ salt * 2654435761U;
        h = (h ^ h >> 15) * 2246822519U;
        h = (h ^ h >> 13) * 3266489917U;
        return static_cast<float>((h ^ h >> 16) & 0xffffffU) / 16777216.0F;
    };
    const float r = 20 * random(1), g = 20 * random(2), b = 20 * random(3), mean = (r + g + b) / 3;
    const float azimuth = 6.2831853F * random(4), down = 0.6F + 0.4F * random(5), side = std::sqrt(1 - down * down);
    const float length = mean * (0.9F + 0.1F * random(6));
    return {length * side * std::cos(azimuth), length * side * std::sin(azimuth), -length * down, mean, r, g, b};
}

NvdbSpec twoLevels(NvdbSpec spec, const std::function<bool(int, int, int)>& wanted,
                   const std::array<bool, 3>& repeats) {
    const auto wrapped = [repeats, low = spec.min, high = spec.max](int v, std::size_t a) {
        const int period = high[a] - low[a] + 1;
        return repeats[a] ? low[a] + ((v - low[a]) % period + period) % period : v;
    };
    // Voxels beyond the box are dark, and no look-up of wider ones.
    const auto coarse = [wanted, wrapped, repeats, low = spec.min, high = spec.max](int x, int y, int z) {
        int b[3] = {x, y, z};
        for (std::size_t a = 0; a < 3; ++a) {
            b[a] = wrapped(16 * b[a], a) / 16;  // exact: a period is whole blocks
            if (16 * b[a] < low[a] || 16 * b[a] + 16 > high[a] + (repeats[a] ? 1 : 0)) return false;
        }
        return wanted(b[0], b[1], b[2]);
    };
    const auto block = [](int v) { return (v - (v % 16 + 16) % 16) / 16; };
    int low[3], count[3];
    for (std::size_t a = 0; a < 3; ++a) {
        low[a] = block(spec.min[a]);
        count[a] = block(spec.max[a]) - low[a] + 1;
    }
    std::string text;
    for (const int v : {low[0], low[1], low[2], count[0], count[1], count[2]}) text += std::to_string(v) + ",";
    text.back() = ':';
    int digit = 0, bits = 0;
    const auto flush = [&] { text.push_back("0123456789abcdef"[digit]), digit = bits = 0; };
    for (int z = 0; z < count[2]; ++z)
        for (int y = 0; y < count[1]; ++y)
            for (int x = 0; x < count[0]; ++x) {
                digit |= (coarse(low[0] + x, low[1] + y, low[2] + z) ? 1 : 0) << bits;
                if (++bits == 4) flush();
            }
    if (bits > 0) flush();
    spec.json = "{\"coarse_blocks\": \"" + text + "\"}";
    const auto own = spec.values;
    spec.values = [own, coarse, block, wrapped](int i, int j, int k) {
        const int v[3] = {i, j, k};
        bool wide = false;
        for (int n = 0; n < 8; ++n) {
            bool shares = true;
            int b[3];
            for (int a = 0; a < 3; ++a) {
                const int step = n >> a & 1;
                b[a] = block(v[a]) - step;
                shares = shares && (step == 0 || v[a] % 16 == 0);
            }
            wide = wide || (shares && coarse(b[0], b[1], b[2]));
        }
        if (!wide) return own(i, j, k);
        LightValues sum{};
        for (int n = 0; n < 8; ++n) {
            int at[3];
            for (int a = 0; a < 3; ++a) at[a] = v[a] + (v[a] % 2 == 0 ? 0 : n >> a & 1 ? 1 : -1);
            const LightValues corner = own(wrapped(at[0], 0), wrapped(at[1], 1), wrapped(at[2], 2));
            for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += corner[c] / 8;
        }
        return sum;
    };
    return spec;
}

}  // namespace photic::test
