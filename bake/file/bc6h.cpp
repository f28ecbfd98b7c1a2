// SPDX-License-Identifier: Apache-2.0
#include "bake/file/bc6h.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace photic {
namespace {

using Vec = std::array<double, 3>;
using Ends = std::array<std::array<int, 3>, 2>;  ///< both ends of a line: quantised, or on the format's scale
constexpr int kTexels = 16, kPlaces = 16;
constexpr int kLargestHalf = 0x7bff;
constexpr std::array<int, kPlaces> kWeights{0, 4, 9, 13, 17, 21, 26, 30, 34, 38, 43, 47, 51, 55, 60, 64};

/// A mode with one line: the first end in `bits`, the second as a difference of `delta_bits`, or as it is.
struct Mode {
    unsigned code;
    int bits, delta_bits;
};
constexpr std::array<Mode, 4> kModes{{{0x0f, 16, 4}, {0x0b, 12, 8}, {0x07, 11, 9}, {0x03, 10, 10}}};  // finest first

/// A value in steps of half floats: their bits, as a number that grows with the value. Negative for negative ones.
double stepsOf(float value) {
    const double size = std::min(std::fabs(double(value)), 65504.0);
    constexpr double kLeastNormal = 1.0 / 16384;
    if (size < kLeastNormal) return std::copysign(size * 1024 / kLeastNormal, double(value));
    int exponent = 0;
    const double mantissa = 2 * std::frexp(size, &exponent);  // 1 to 2
    return std::copysign((exponent + 14) * 1024 + (mantissa - 1) * 1024, double(value));
}

/// Values of the half floats of each number of steps from 0 on.
const std::vector<float>& halfValues() {
    static const std::vector<float> kValues = [] {
        std::vector<float> values;
        for (int h = 0; h <= kLargestHalf; ++h) {
            const int exponent = h >> 10, mantissa = h & 1023;
            values.push_back(exponent == 0 ? std::ldexp(static_cast<float>(mantissa), -24)
                                           : std::ldexp(static_cast<float>(1024 + mantissa), exponent - 25));
        }
        return values;
    }();
    return kValues;
}

/// Arithmetic of one of both formats. Ends and places are numbers of 16 bits (with sign: 15 and the sign).
class Format {
public:
    explicit Format(Bc6hSign sign) : signed_(sign == Bc6hSign::Signed) {}

    /// The value of a place on a line.
    float value(int place) const {
        const std::vector<float>& values = values_;
        if (!signed_) return values[static_cast<std::size_t>((place * 31) >> 6)];
        const float size = values[static_cast<std::size_t>((std::abs(place) * 31) >> 5)];
        return place < 0 ? -size : size;
    }
    /// Where a value lies on that scale: in the middle of the places that decode to it, since decoding rounds down.
    double placeOf(float v) const {
        const double steps = stepsOf(v);
        if (!signed_) return (std::max(0.0, steps) + 0.5) * 64 / 31;
        return std::copysign((std::fabs(steps) + 0.5) * 32 / 31, steps);
    }
    double largestPlace() const { return signed_ ? 32767 : 65535; }
    double leastPlace() const { return signed_ ? -32767 : 0; }

    int unquantised(int q, int bits) const {
        if (!signed_) {
            if (bits >= 15) return q;
            if (q == 0) return 0;
            return q == (1 << bits) - 1 ? 0xffff : ((q << 16) + 0x8000) >> bits;
        }
        if (bits >= 16) return q;
        const int size = std::abs(q);
        const int place = size == 0                       ? 0
                          : size >= (1 << (bits - 1)) - 1 ? 0x7fff
                                                          : ((size << 15) + 0x4000) >> (bits - 1);
        return q < 0 ? -place : place;
    }
    int quantised(double place, int bits) const {
        const int largest = signed_ ? (1 << (bits - 1)) - 1 : (1 << bits) - 1;
        const double scale = std::ldexp(1.0, bits - 16);
        const int guess = static_cast<int>(std::lround(std::fabs(place) * scale - (bits >= 16 ? 0.0 : 0.5)));
        int best = 0;
        double nearest = std::numeric_limits<double>::infinity();
        for (int q = guess - 1; q <= guess + 1; ++q) {
            const int inside = std::clamp(q, 0, largest);
            const double off = std::fabs(unquantised(inside, bits) - std::fabs(place));
            if (off < nearest) nearest = off, best = inside;
        }
        return signed_ && place < 0 ? -best : best;
    }
    bool isSigned() const { return signed_; }

private:
    bool signed_;
    const std::vector<float>& values_ = halfValues();
};

int between(int a, int b, int place) {
    const int w = kWeights[static_cast<std::size_t>(place)];
    return (a * (64 - w) + b * w + 32) >> 6;
}

/// What was asked of a block: values, where they lie on the format's scale, and how much a step there matters.
struct Wanted {
    std::array<std::array<float, 3>, kTexels> value{};
    std::array<Vec, kTexels> place{}, weight{};
    std::array<bool, kTexels> used{};
};

Wanted wantedOf(const Bc6hTexels& texels, const Format& format) {
    Wanted w;
    for (std::size_t i = 0; i < kTexels; ++i) {
        w.used[i] = (texels.used >> i & 1) != 0;
        for (std::size_t c = 0; c < 3; ++c) {
            const float v = texels.rgb[i][c];
            const float finite = std::isfinite(v) ? v : 0.0F;
            w.value[i][c] = std::clamp(finite, format.isSigned() ? -65504.0F : 0.0F, 65504.0F);
            w.place[i][c] = format.placeOf(w.value[i][c]);
            // A step is worth about the value itself: differences are then those of values, to first order.
            const double worth = std::max(std::fabs(double(w.value[i][c])), 1.0 / 16384);
            w.weight[i][c] = w.used[i] ? worth * worth : 0.0;
        }
    }
    return w;
}

/// A line, and which of its places each texel takes.
struct Line {
    std::array<Vec, 2> ends{};
    std::array<int, kTexels> index{};
    double error = std::numeric_limits<double>::infinity();
};

/// Chooses places on the line of two ends, by the values that they stand for. @return the sum of squares
double chooseIndices(const Wanted& w, const Format& format, const Ends& ends, std::array<int, kTexels>& index) {
    // Channel by channel, so that the sixteen places of a line go through one register or two.
    std::array<std::array<float, kPlaces>, 3> palette;
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t p = 0; p < kPlaces; ++p)
            palette[c][p] = format.value(between(ends[0][c], ends[1][c], static_cast<int>(p)));
    double sum = 0;
    for (std::size_t i = 0; i < kTexels; ++i) {
        index[i] = 0;
        if (!w.used[i]) continue;
        std::array<float, kPlaces> off{};
        for (std::size_t c = 0; c < 3; ++c) {
            const float value = w.value[i][c];
            for (std::size_t p = 0; p < kPlaces; ++p) {
                const float d = palette[c][p] - value;
                off[p] += d * d;
            }
        }
        const auto least = std::min_element(off.begin(), off.end());
        index[i] = static_cast<int>(least - off.begin());
        sum += double(*least);
    }
    return sum;
}

Ends rounded(const std::array<Vec, 2>& ends, const Format& format) {
    Ends out{};
    for (std::size_t e = 0; e < 2; ++e)
        for (std::size_t c = 0; c < 3; ++c)
            out[e][c] =
                static_cast<int>(std::lround(std::clamp(ends[e][c], format.leastPlace(), format.largestPlace())));
    return out;
}

/// The ends that are best for the places that texels have: least squares, channel by channel.
std::array<Vec, 2> fittedEnds(const Wanted& w, const Line& line) {
    std::array<Vec, 2> ends = line.ends;
    for (std::size_t c = 0; c < 3; ++c) {
        double aa = 0, ab = 0, bb = 0, ax = 0, bx = 0;
        for (std::size_t i = 0; i < kTexels; ++i) {
            const double t = kWeights[static_cast<std::size_t>(line.index[i])] / 64.0, s = 1 - t;
            const double weight = w.weight[i][c];
            aa += weight * s * s, ab += weight * s * t, bb += weight * t * t;
            ax += weight * s * w.place[i][c], bx += weight * t * w.place[i][c];
        }
        const double determinant = aa * bb - ab * ab;
        if (determinant <= 1e-9 * aa * bb || determinant <= 0) continue;  // all at one place: any other end will do
        ends[0][c] = (ax * bb - bx * ab) / determinant;
        ends[1][c] = (bx * aa - ax * ab) / determinant;
    }
    return ends;
}

/// The direction in which places spread most, by power iteration.
Vec mainDirection(const Wanted& w, const Vec& mean) {
    std::array<double, 9> m{};
    Vec direction{};
    for (std::size_t i = 0; i < kTexels; ++i) {
        if (!w.used[i]) continue;
        Vec d;
        for (std::size_t c = 0; c < 3; ++c) d[c] = w.place[i][c] - mean[c];
        for (std::size_t a = 0; a < 3; ++a)
            for (std::size_t b = 0; b < 3; ++b) m[3 * a + b] += d[a] * d[b];
    }
    for (std::size_t c = 0; c < 3; ++c) direction[c] = std::sqrt(m[4 * c]);
    if (m[1] < 0) direction[1] = -direction[1];
    if (m[2] < 0) direction[2] = -direction[2];
    for (int n = 0; n < 8; ++n) {
        Vec next{};
        double length = 0;
        for (std::size_t a = 0; a < 3; ++a) {
            for (std::size_t b = 0; b < 3; ++b) next[a] += m[3 * a + b] * direction[b];
            length += next[a] * next[a];
        }
        if (length <= 0) break;
        for (std::size_t a = 0; a < 3; ++a) direction[a] = next[a] / std::sqrt(length);
    }
    return direction;
}

/// The line before it is quantised: through all places along their main direction, then ends and places in turn.
Line fittedLine(const Wanted& w, const Format& format) {
    Vec mean{};
    int count = 0;
    for (std::size_t i = 0; i < kTexels; ++i) {
        if (!w.used[i]) continue;
        ++count;
        for (std::size_t c = 0; c < 3; ++c) mean[c] += w.place[i][c];
    }
    for (double& v : mean) v /= std::max(1, count);
    const Vec direction = mainDirection(w, mean);
    double low = 0, high = 0;
    for (std::size_t i = 0; i < kTexels; ++i) {
        if (!w.used[i]) continue;
        double along = 0;
        for (std::size_t c = 0; c < 3; ++c) along += direction[c] * (w.place[i][c] - mean[c]);
        low = std::min(low, along), high = std::max(high, along);
    }
    Line line, best;
    for (std::size_t c = 0; c < 3; ++c)
        line.ends[0][c] = mean[c] + low * direction[c], line.ends[1][c] = mean[c] + high * direction[c];
    constexpr int kTurns = 6;
    for (int turn = 0; turn < kTurns; ++turn) {
        line.error = chooseIndices(w, format, rounded(line.ends, format), line.index);
        if (!(line.error < best.error)) break;
        best = line;
        line.ends = fittedEnds(w, line);
    }
    return best;
}

class BitWriter {
public:
    void put(unsigned value, int bits) {
        for (int i = 0; i < bits; ++i, ++at_)
            if (value >> i & 1) block[at_ / 8] = static_cast<std::uint8_t>(block[at_ / 8] | 1U << (at_ % 8));
    }
    Bc6hBlock block{};

private:
    std::size_t at_ = 0;
};

class BitReader {
public:
    explicit BitReader(const Bc6hBlock& block) : block_(block) {}
    unsigned get(int bits) {
        unsigned value = 0;
        for (int i = 0; i < bits; ++i, ++at_) value |= (block_[at_ / 8] >> (at_ % 8) & 1U) << i;
        return value;
    }

private:
    const Bc6hBlock& block_;
    std::size_t at_ = 0;
};

/// The bits beyond ten of a first end come last and the other way round.
unsigned reversed(unsigned value, int bits) {
    unsigned out = 0;
    for (int i = 0; i < bits; ++i) out |= (value >> i & 1) << (bits - 1 - i);
    return out;
}

Bc6hBlock packed(const Mode& mode, const Ends& ends, const std::array<int, kTexels>& index) {
    BitWriter out;
    out.put(mode.code, 5);
    const unsigned mask = (1U << mode.bits) - 1;
    for (std::size_t c = 0; c < 3; ++c) out.put(static_cast<unsigned>(ends[0][c]) & mask & 1023U, 10);
    for (std::size_t c = 0; c < 3; ++c) {
        const int second = mode.bits > 10 ? ends[1][c] - ends[0][c] : ends[1][c];
        out.put(static_cast<unsigned>(second) & ((1U << mode.delta_bits) - 1), mode.delta_bits);
        out.put(reversed((static_cast<unsigned>(ends[0][c]) & mask) >> 10, mode.bits - 10), mode.bits - 10);
    }
    for (std::size_t i = 0; i < kTexels; ++i) out.put(static_cast<unsigned>(index[i]), i == 0 ? 3 : 4);
    return out.block;
}

/// Whether the second end can be written as a difference.
bool fits(const Mode& mode, const Ends& ends) {
    if (mode.bits == 10) return true;
    const int reach = 1 << (mode.delta_bits - 1);
    return std::all_of(ends[0].begin(), ends[0].end(), [&, c = std::size_t{0}](int first) mutable {
        const int delta = ends[1][c++] - first;
        return delta >= -reach && delta < reach;
    });
}

}  // namespace

Bc6hBlock encodeBc6h(const Bc6hTexels& texels, Bc6hSign sign) {
    const Format format(sign);
    const Wanted wanted = wantedOf(texels, format);
    const Line line = fittedLine(wanted, format);
    const auto places = [&](const Mode& mode, const Ends& ends) {
        Ends out{};
        for (std::size_t e = 0; e < 2; ++e)
            for (std::size_t c = 0; c < 3; ++c) out[e][c] = format.unquantised(ends[e][c], mode.bits);
        return out;
    };
    for (const Mode& mode : kModes) {
        Ends ends{};
        for (std::size_t e = 0; e < 2; ++e)
            for (std::size_t c = 0; c < 3; ++c) ends[e][c] = format.quantised(line.ends[e][c], mode.bits);
        if (!fits(mode, ends) && !fits(mode, {ends[1], ends[0]})) continue;  // what follows reaches further
        std::array<int, kTexels> index{};
        chooseIndices(wanted, format, places(mode, ends), index);
        // The first texel has a bit less: its place is in the first half, or the ends change sides.
        if (index[0] >= kPlaces / 2) {
            std::swap(ends[0], ends[1]);
            chooseIndices(wanted, format, places(mode, ends), index);
            index[0] = std::min(index[0], kPlaces / 2 - 1);  // a tie that rounding broke the other way
        }
        if (fits(mode, ends)) return packed(mode, ends, index);
    }
    return {};  // never: the last mode writes both ends as they are
}

std::array<std::array<float, 3>, 16> decodeBc6h(const Bc6hBlock& block, Bc6hSign sign) {
    const Format format(sign);
    BitReader in(block);
    const unsigned code = in.get(5);
    const auto mode = std::find_if(kModes.begin(), kModes.end(), [&](const Mode& m) { return m.code == code; });
    std::array<std::array<float, 3>, 16> out{};
    if (mode == kModes.end()) return out;
    const auto extended = [](unsigned value, int bits) {
        const auto v = static_cast<int>(value);
        return v >> (bits - 1) & 1 ? v - (1 << bits) : v;
    };
    Ends ends{};
    std::array<unsigned, 3> first{};
    for (unsigned& v : first) v = in.get(10);
    for (std::size_t c = 0; c < 3; ++c) {
        const unsigned second = in.get(mode->delta_bits);
        first[c] |= reversed(in.get(mode->bits - 10), mode->bits - 10) << 10;
        ends[0][c] = format.isSigned() ? extended(first[c], mode->bits) : static_cast<int>(first[c]);
        if (mode->bits == 10) {
            ends[1][c] = format.isSigned() ? extended(second, 10) : static_cast<int>(second);
        } else {
            const auto sum =
                static_cast<unsigned>(ends[0][c] + extended(second, mode->delta_bits)) & ((1U << mode->bits) - 1);
            ends[1][c] = format.isSigned() ? extended(sum, mode->bits) : static_cast<int>(sum);
        }
    }
    for (std::size_t i = 0; i < kTexels; ++i) {
        const auto index = static_cast<int>(in.get(i == 0 ? 3 : 4));
        for (std::size_t c = 0; c < 3; ++c)
            out[i][c] = format.value(
                between(format.unquantised(ends[0][c], mode->bits), format.unquantised(ends[1][c], mode->bits), index));
    }
    return out;
}

}  // namespace photic
