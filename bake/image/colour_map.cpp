// SPDX-License-Identifier: Apache-2.0
#include "bake/image/colour_map.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace photic {
namespace {

using Colour = std::array<float, 3>;

// Every eighth entry of the maps by S. van der Walt and N. Smith (CC0), interpolated to 0.0065 or better.
constexpr Colour kMagma[] = {
    {0.001f, 0.000f, 0.014f}, {0.014f, 0.012f, 0.068f}, {0.039f, 0.031f, 0.133f}, {0.074f, 0.052f, 0.202f},
    {0.112f, 0.065f, 0.276f}, {0.158f, 0.068f, 0.351f}, {0.210f, 0.062f, 0.417f}, {0.264f, 0.060f, 0.461f},
    {0.315f, 0.071f, 0.485f}, {0.364f, 0.090f, 0.498f}, {0.413f, 0.110f, 0.504f}, {0.461f, 0.129f, 0.508f},
    {0.511f, 0.147f, 0.508f}, {0.560f, 0.165f, 0.505f}, {0.611f, 0.181f, 0.499f}, {0.662f, 0.197f, 0.490f},
    {0.713f, 0.214f, 0.476f}, {0.764f, 0.232f, 0.459f}, {0.814f, 0.254f, 0.438f}, {0.860f, 0.281f, 0.414f},
    {0.901f, 0.316f, 0.390f}, {0.935f, 0.361f, 0.370f}, {0.959f, 0.414f, 0.360f}, {0.976f, 0.471f, 0.363f},
    {0.986f, 0.530f, 0.380f}, {0.992f, 0.589f, 0.407f}, {0.996f, 0.648f, 0.442f}, {0.997f, 0.706f, 0.483f},
    {0.997f, 0.763f, 0.530f}, {0.995f, 0.821f, 0.580f}, {0.993f, 0.878f, 0.634f}, {0.990f, 0.935f, 0.690f},
    {0.987f, 0.991f, 0.750f}};
constexpr Colour kViridis[] = {
    {0.267f, 0.005f, 0.329f}, {0.277f, 0.050f, 0.376f}, {0.282f, 0.095f, 0.417f}, {0.283f, 0.135f, 0.453f},
    {0.279f, 0.175f, 0.483f}, {0.271f, 0.213f, 0.507f}, {0.259f, 0.251f, 0.524f}, {0.245f, 0.287f, 0.537f},
    {0.230f, 0.321f, 0.545f}, {0.215f, 0.354f, 0.551f}, {0.200f, 0.386f, 0.555f}, {0.186f, 0.417f, 0.557f},
    {0.173f, 0.447f, 0.558f}, {0.161f, 0.477f, 0.558f}, {0.150f, 0.506f, 0.557f}, {0.138f, 0.536f, 0.555f},
    {0.128f, 0.565f, 0.551f}, {0.121f, 0.594f, 0.544f}, {0.120f, 0.624f, 0.534f}, {0.131f, 0.653f, 0.521f},
    {0.155f, 0.682f, 0.503f}, {0.193f, 0.710f, 0.481f}, {0.241f, 0.737f, 0.455f}, {0.299f, 0.762f, 0.423f},
    {0.363f, 0.787f, 0.387f}, {0.433f, 0.809f, 0.345f}, {0.508f, 0.829f, 0.299f}, {0.587f, 0.847f, 0.249f},
    {0.669f, 0.862f, 0.195f}, {0.753f, 0.875f, 0.143f}, {0.836f, 0.886f, 0.102f}, {0.917f, 0.896f, 0.101f},
    {0.993f, 0.906f, 0.144f}};
// Moreland's diverging cool-warm map ("Diverging Color Maps for Scientific Visualization", 2009), nine of its points.
constexpr Colour kBlueRed[] = {{0.230f, 0.299f, 0.754f}, {0.384f, 0.510f, 0.918f}, {0.554f, 0.690f, 0.996f},
                               {0.722f, 0.817f, 0.977f}, {0.865f, 0.865f, 0.865f}, {0.958f, 0.770f, 0.678f},
                               {0.958f, 0.604f, 0.482f}, {0.870f, 0.378f, 0.302f}, {0.706f, 0.016f, 0.150f}};

std::span<const Colour> table(ColourMap map) {
    switch (map) {
        case ColourMap::Magma:
            return kMagma;
        case ColourMap::Viridis:
            return kViridis;
        case ColourMap::BlueRed:
            return kBlueRed;
    }
    return kMagma;
}

}  // namespace

std::array<float, 3> colourOf(ColourMap map, double value) {
    if (std::isnan(value)) return {0.0f, 1.0f, 0.0f};
    const std::span<const Colour> colours = table(map);
    const double x = std::clamp(value, 0.0, 1.0) * static_cast<double>(colours.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(x), colours.size() - 2);
    const auto t = static_cast<float>(x - static_cast<double>(i));
    Colour out;
    for (std::size_t c = 0; c < 3; ++c) out[c] = colours[i][c] * (1.0f - t) + colours[i + 1][c] * t;
    return out;
}

const std::vector<std::string>& colourMapNames() {
    static const std::vector<std::string> names{"magma", "viridis", "blue_red"};
    return names;
}

}  // namespace photic
