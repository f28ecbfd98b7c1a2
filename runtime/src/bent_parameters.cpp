// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/bent_parameters.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "runtime/format/index_volume_format.h"
#include "runtime/src/affine.h"
#include "runtime/src/guarded.h"
#include "runtime/src/harmonics.h"

namespace photic::runtime {

static_assert(BentRayPass::kMostObjects == format::kIndexMostDrawn, "what photic export warns of");
namespace {

void require(const BentRayOptions& o, const Surroundings& s, std::size_t placed) {
    const auto wrong = [](const std::string& what) { fail(ErrorCode::Usage, what); };
    if (placed < 1 || placed > BentRayPass::kMostObjects)
        wrong(std::to_string(placed) + " objects are placed; 1 to 16 are drawn at a time");
    if (!(o.step > 0 && o.step <= 16)) wrong("a step of " + std::to_string(o.step) + " nodes; it must be up to 16");
    if (!(o.turn > 0 && o.turn <= 1)) wrong("a turn of " + std::to_string(o.turn) + "; it must be up to 1 radian");
    if (o.steps < 1 || o.steps > 65536) wrong(std::to_string(o.steps) + " steps are not between 1 and 65536");
    if (o.branches < 0 || o.branches > 4) wrong(std::to_string(o.branches) + " branches are not between 0 and 4");
    if (!(o.faintest >= 0 && o.faintest <= 1)) wrong("the faintest branch must be 0 to 1");
    for (const float c : s.colour)
        if (!(c >= 0 && std::isfinite(c))) wrong("the surroundings' colour must be 0 or more, and finite");
    if (!std::isfinite(s.turn)) wrong("the surroundings' turn is not finite");
    if (s.harmonics)
        for (const auto& harmonic : *s.harmonics)
            for (const float c : harmonic)
                if (!std::isfinite(c)) wrong("the surroundings' harmonics are not finite");
}

/// A box around an object in the world, for the question which of them overlap.
struct Bounds {
    Double3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    bool overlaps(const Bounds& other) const {
        for (std::size_t a = 0; a < 3; ++a)
            if (low[a] > other.high[a] || other.low[a] > high[a]) return false;
        return true;
    }
};

/// One placed object's numbers; places in the shader are relative to `origin`.
Bounds layObject(const IndexObjects::Object& object, const PlacedObject& placed, const Double3& origin,
                 BentObjectBlock& out) {
    const Affine world_from_node =
        Affine::of(placed.world_from_object) * Affine{object.transform.world_from_index, object.transform.origin_world};
    const std::optional<Affine> node_from_world = world_from_node.inverse();
    if (!node_from_world) fail(ErrorCode::Usage, "a PlacedObject's matrix has no inverse");
    const Double3 shift = node_from_world->apply(origin);
    double least = 1e300;
    for (std::size_t a = 0; a < 3; ++a) {
        double length = 0;
        for (std::size_t b = 0; b < 3; ++b) {
            out.rows[a][b] = static_cast<float>(node_from_world->matrix[3 * a + b]);
            length += world_from_node.matrix[3 * b + a] * world_from_node.matrix[3 * b + a];
        }
        out.rows[a][3] = static_cast<float>(shift[a]);
        least = std::min(least, std::sqrt(length));
        out.box_low[a] = static_cast<float>(object.box_low[a]),
        out.box_high[a] = static_cast<float>(object.box_high[a]);
        out.scattering[a] = object.scattering[a], out.coat[a] = object.albedo[a];
        out.count[a] = object.count[a], out.corner[a] = object.place.corner[a], out.block[a] = object.place.block[a];
    }
    out.box_low[3] = object.sharp ? 1.0F : 0.0F;
    out.box_high[3] = object.anisotropy;
    out.scattering[3] = static_cast<float>(least);
    // Narrower highlights than this would miss all pixels but some.
    out.coat[3] = object.roughness > 0 ? std::max(object.roughness * object.roughness, 1e-3F) : 0.0F;
    out.count[3] = object.place.flags, out.corner[3] = object.place.channel_layers;
    Bounds bounds;
    for (int corner = 0; corner < 8; ++corner) {
        Double3 node;
        for (std::size_t a = 0; a < 3; ++a) node[a] = (corner >> a & 1) != 0 ? object.box_high[a] : object.box_low[a];
        const Double3 p = world_from_node.apply(node);
        for (std::size_t a = 0; a < 3; ++a)
            bounds.low[a] = std::min(bounds.low[a], p[a]), bounds.high[a] = std::max(bounds.high[a], p[a]);
    }
    return bounds;
}

}  // namespace

IndexObjects::IndexObjects(const std::vector<IndexVolume>& volumes, const IndexAtlas& atlas,
                           const std::vector<int>& shapes)
    : texels(atlas.texels) {
    for (std::size_t i = 0; i < volumes.size(); ++i) {
        const IndexVolumeData& data = volumes[i].data();
        const auto &s = data.scattering, &albedo = data.albedo;
        const bool matte = !data.coat.empty() || albedo[0] > 0 || albedo[1] > 0 || albedo[2] > 0;
        objects.push_back(
            {data.transform, data.box_low, data.box_high, data.count, atlas.places[i], s, data.anisotropy, albedo,
             data.roughness, volumes[i].reflects(), matte, data.sharp_sides, s[0] > 0 || s[1] > 0 || s[2] > 0,
             volumes[i].disperses(), shapes[i], data.shape ? static_cast<int>(data.shape->rank) : 0,
             (data.hasSamples() ? 1 : 0) +
                 (data.shape ? 16 * static_cast<int>(data.shape->faces) + 256 * static_cast<int>(data.shape->kind)
                             : 0)});
    }
}

bool IndexObjects::haveShapes(const std::vector<PlacedObject>& placed) const {
    return std::any_of(placed.begin(), placed.end(), [&](const PlacedObject& p) {
        return p.object < objects.size() && objects[p.object].shape >= 0;
    });
}

BentBlock bentBlock(const IndexObjects& objects, const std::vector<PlacedObject>& placed, const Double3& origin,
                    const BentRayOptions& options, const Surroundings& surroundings) {
    require(options, surroundings, placed.size());
    if (options.integrator == BentIntegrator::Euler && objects.haveShapes(placed))
        fail(ErrorCode::Usage,
             "an object with a mesh is placed, and the paper's loop (BentIntegrator::Euler) knows no faces");
    BentBlock block{};
    std::vector<Bounds> bounds;
    for (std::size_t i = 0; i < placed.size(); ++i) {
        if (placed[i].object >= objects.objects.size())
            fail(ErrorCode::Usage, "there is no index volume " + std::to_string(placed[i].object) + "; " +
                                       std::to_string(objects.objects.size()) + " were uploaded");
        const IndexObjects::Object& object = objects.objects[placed[i].object];
        bounds.push_back(layObject(object, placed[i], origin, block.objects[i]));
        block.shapes[i][0] = object.shape, block.shapes[i][1] = object.rank;
        block.shapes[i][2] = object.shape_flags;
    }
    for (std::size_t i = 0; i < placed.size(); ++i)
        for (std::size_t k = 0; k < placed.size(); ++k) {
            if (!bounds[i].overlaps(bounds[k])) continue;
            // Samples add up; what lies in a shape is not beside it.
            if (block.shapes[k][0] >= 0)
                block.shapes[i][3] |= 1 << k;
            else if (i != k)
                block.objects[i].block[3] |= 1 << k;
        }
    for (std::size_t a = 0; a < 3; ++a) {
        block.origin[a] = static_cast<float>(origin[a]);
        block.texel[a] = 1.0F / static_cast<float>(objects.texels[a]);
    }
    block.counts[0] = static_cast<std::int32_t>(placed.size());
    block.counts[1] = options.steps, block.counts[2] = options.branches;
    block.counts[3] = options.skipping == BentSkipping::Even ? 1 : 0;
    block.march[0] = options.step, block.march[1] = options.turn, block.march[2] = options.faintest;
    block.march[3] = options.radiance == BentRadiance::Paper ? 1.0F : 0.0F;
    layAmbient(surroundings, block);
    return block;
}

void layAmbient(const Surroundings& around, BentBlock& block) {
    const std::array<double, 9> factors = ambientFactors();
    for (std::size_t i = 0; i < 9; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            const double even = i == 0 ? 1 : 0;  // the same from everywhere
            const double ambient = around.harmonics ? factors[i] * double((*around.harmonics)[i][c]) : even;
            block.ambient[i][c] = static_cast<float>(ambient * double(around.colour[c]));
        }
    block.ambient[0][3] = std::cos(around.turn), block.ambient[1][3] = std::sin(around.turn);
}

}  // namespace photic::runtime
