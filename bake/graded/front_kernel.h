// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

namespace photic {

/// The index in the middle planes of the steps of some consecutive layers, collapsed from a spline across the layers:
/// all rays of a front meet the same plane, so that each has only the plane's own 16 coefficients left to look at.
struct IndexSlices {
    int columns = 0, rows = 0;       ///< nodes along u and v, one voxel apart
    float first_u = 0, first_v = 0;  ///< of node (0, 0) [voxels]
    int steps = 1;                   ///< a layer
    std::vector<float> value;        ///< n^2 / 2: coefficients, per step (in the light's order), row, column
    std::vector<float> slope;        ///< d(n^2 / 2)/dw [1/voxel], likewise
    std::size_t plane() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
};

/// The rays of a front, one array a member, with room for whole registers.
struct FrontRays {
    std::vector<float> u, v, w;        ///< [voxels]
    std::vector<float> pu, pv, pw;     ///< momentum, as long as n; pw > 0 along the light
    std::vector<float> lit;            ///< 1 once the ray has been where the index is not the air's
    std::vector<float> depth[3];       ///< optical depth so far, per channel; empty without attenuation
    std::vector<float> time;           ///< optical path so far [m], from any place; empty where nobody asks for it
    std::vector<std::int8_t> stopped;  ///< lane in which the ray was found to turn away; -1: not yet

    std::size_t size() const { return count; }
    void resize(std::size_t rays, bool attenuated, bool timed = false);
    std::size_t count = 0;
};

/// What attenuates where: a table of media, by voxel.
struct FrontMedia {
    const std::uint8_t* of_node = nullptr;  ///< per node of the spline: 0 is air; null: nothing attenuates
    std::size_t stride_u = 0, stride_v = 0, stride_w = 0;
    float extinction[256][3] = {};  ///< [1/m]
};

/// One slab's march.
struct FrontMarch {
    const IndexSlices* slices = nullptr;
    const FrontMedia* media = nullptr;
    float voxel[3] = {1, 1, 1};           ///< along u, v, w [m]
    int first_w = 0, layers = 0;          ///< at most 16
    int sense = 1;                        ///< of the light along w
    int node_w = 0;                       ///< layer of the spline's first node
    float air = 0.5f, least_lit = 1e-3f;  ///< n^2 / 2 around; a difference that counts as being in a medium
    int channels = 1;                     ///< of attenuation
    /// n^2 / 2 where it is the same everywhere, and there are no slices but for `steps`; 0: it is not.
    float even = 0;
    /// Rays whose angle to w passes 60 degrees are to go on along another axis: they stop.
    float least_cosine = 0.5f;
};

/// Moves rays `first` to `first + count` through the slab: from layer to layer by drift, kick in the middle, drift
/// (bake/graded/ray_integrator.h, stepBetweenPlanes). Rays that start within the slab wait for their layer.
/// @param rows  per ray, BentRows::rayStride() floats, `stride` of them
using FrontKernel = void (*)(const FrontMarch&, FrontRays&, std::size_t first, std::size_t count, float* rows,
                             std::size_t stride);

/// The fastest that this processor can run.
FrontKernel frontKernel();

}  // namespace photic
