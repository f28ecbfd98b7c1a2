// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/sharp_bodies.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "bake/graded/enclosed_bodies.h"

namespace photic {
namespace {

WorldBox boundsOf(const Surface& surface) {
    if (surface.sphere)
        return {surface.sphere->center - surface.sphere->radius, surface.sphere->center + surface.sphere->radius};
    WorldBox box{glm::dvec3(1e300), glm::dvec3(-1e300)};
    for (const glm::dvec3& p : surface.mesh->positions) box.min = glm::min(box.min, p), box.max = glm::max(box.max, p);
    return box;
}

bool hasInside(const Surface& surface) {
    return surface.mesh && surface.closed && !surface.thin && surface.event != SurfaceEvent::Mirror;
}

/// An index that goes on beyond the faces of the body that it fills.
class FillingIndex final : public GradedIndex {
public:
    FillingIndex(std::shared_ptr<const GradedIndex> index, WorldBox box) : index_(std::move(index)), box_(box) {}
    IndexSample at(const glm::dvec3& world) const override {
        IndexSample sample = index_->at(world);
        sample.half_square = halfSquareAt(world);
        return sample;
    }
    double halfSquareAt(const glm::dvec3& world) const override { return halfSquareEnclosed(*index_, world); }
    bool contains(const glm::dvec3& world) const override { return box_.contains(world); }
    std::optional<WorldBox> bounds() const override { return box_; }

private:
    std::shared_ptr<const GradedIndex> index_;
    WorldBox box_;
};

/// One index everywhere.
std::shared_ptr<const GradedIndex> evenIndex(double n) { return makeLinearSquare(glm::dvec3(0), n, glm::dvec3(0), {}); }

std::vector<std::shared_ptr<const GradedIndex>> evenIndices(const RefractiveIndex& ior) {
    if (!ior.disperses()) return {evenIndex(ior.mean())};
    const glm::dvec3 n = ior.atChannels();
    return {evenIndex(n.x), evenIndex(n.y), evenIndex(n.z)};
}

GradedObject evenObject(const Medium& medium, const std::string& name) {
    GradedObject object;
    object.name = name;
    object.where = medium.where;
    object.index = evenIndices(medium.ior);
    object.absorption = medium.absorption, object.scattering = medium.scattering;
    object.anisotropy = medium.anisotropy;
    return object;
}

class BodyMaker {
public:
    BodyMaker(const Scene& scene, const ObjectSampling& sampling, Monitor& monitor)
        : scene_(scene), sampling_(sampling), monitor_(monitor) {}

    SharpScene make() {
        if (scene_.index) out_.others = bodiesOf(scene_);
        sortByRank();
        for (const Surface* surface : ranked_) add(*surface);
        std::erase_if(out_.others, [&](const GradedObject& object) { return fillsBodies(object); });
        return std::move(out_);
    }

private:
    /// Those of higher priority later, and of equal ones the smaller, as the one that light enters last.
    void sortByRank() {
        for (const Surface& surface : scene_.surfaces) {
            if (!surface.mesh) {
                note(surface, "a height field has no inside, and is not written");
            } else if (hasInside(surface) || surface.thin || surface.event == SurfaceEvent::Mirror) {
                ranked_.push_back(&surface);
            } else {
                note(surface, "its mesh is open, has no inside, and is not written");
            }
        }
        const auto volume = [](const Surface* s) {
            const WorldBox box = boundsOf(*s);
            const glm::dvec3 size = box.max - box.min;
            return size.x * size.y * size.z;
        };
        const auto priority = [&](const Surface* s) {
            return hasInside(*s) ? sideOf(scene_, *s, Side::Below).priority : 0;
        };
        std::stable_sort(ranked_.begin(), ranked_.end(), [&](const Surface* a, const Surface* b) {
            return priority(a) != priority(b) ? priority(a) < priority(b) : volume(a) > volume(b);
        });
    }
    void note(const Surface& surface, const std::string& what) {
        out_.notes.push_back(fmt::format("surface '{}': {}", surface.name, what));
    }

    /// The medium whose index varies on a surface's inside; null where it is of one index.
    const GradedObject* gradedIn(const Surface& surface) const {
        if (!scene_.index || surface.medium_below < 0) return nullptr;
        const std::string& name = scene_.media[static_cast<std::size_t>(surface.medium_below)].name;
        for (const GradedObject& object : scene_.index->objects())
            if (object.enclosed && object.name == name) return &object;
        return nullptr;
    }
    /// Whether a medium is inside of bodies with faces of their own, and nowhere else.
    bool fillsBodies(const GradedObject& object) const {
        bool some = false;
        for (const Surface& surface : scene_.surfaces) {
            const auto named = [&](int medium) {
                return medium >= 0 && scene_.media[static_cast<std::size_t>(medium)].name == object.name;
            };
            if (named(surface.medium_above)) return false;
            if (!named(surface.medium_below)) continue;
            if (!hasInside(surface)) return false;
            some = true;
        }
        return object.enclosed && some;
    }

    void add(const Surface& surface) {
        SharpBody body;
        body.name = surface.name;
        body.rank = static_cast<unsigned>(std::min<std::size_t>(out_.bodies.size(), 255));
        body.colour = surface.colour;
        body.faces = surface.event == SurfaceEvent::Mirror ? SharpFaces::Mirror
                     : surface.thin                        ? SharpFaces::Thin
                                                           : SharpFaces::Glass;
        const WorldBox box = boundsOf(surface);
        const glm::dvec3 size = box.max - box.min;
        constexpr double kNodes = 64;  // along the longest side: what a node is matters little
        body.world_from_node = glm::dmat3(std::max({size.x, size.y, size.z, 1e-6}) / kNodes);
        body.origin_world = 0.5 * (box.min + box.max);
        if (body.faces != SharpFaces::Mirror) {
            const Medium inside = sideOf(scene_, surface, Side::Below);
            body.index = inside.ior.disperses() ? inside.ior.atChannels() : glm::dvec3(inside.ior.mean());
            body.absorption = inside.absorption;
            if (body.faces == SharpFaces::Glass) {
                const GradedObject* graded = gradedIn(surface);
                if (graded && !fillsBodies(*graded)) return;  // its samples end at all that it ends at
                if (graded)
                    fill(*graded, box, body);
                else if (inside.scattering != glm::dvec3(0))
                    fill(evenObject(inside, surface.name), box, body);
                requireAirAround(surface);
            }
        }
        layShape(surface, body);
        out_.bodies.push_back(std::move(body));
    }

    /// What lies outside of a body must be air, or the inside of another one.
    void requireAirAround(const Surface& surface) {
        const Medium outside = sideOf(scene_, surface, Side::Above);
        if (outside.ior.mean() == 1 && !outside.ior.disperses()) return;
        for (const Surface& other : scene_.surfaces)
            if (hasInside(other) && other.medium_below >= 0 && other.medium_below == surface.medium_above) return;
        note(surface, fmt::format("'{}' around it is nobody's inside: eye rays see it in air",
                                  outside.name.empty() ? "what is" : outside.name));
    }

    void fill(const GradedObject& object, const WorldBox& box, SharpBody& body) {
        body.filling = object;
        ObjectSampling sampling = sampling_;
        for (auto& index : body.filling->index) {
            if (const auto samples = index->samples())
                for (int a = 0; a < 3; ++a)
                    sampling.voxel_size = std::min(sampling.voxel_size, glm::length(samples->world_from_sample[a]));
        }
        // A hair more, so that no vertex lies beyond the box for rounding.
        const double hair = 1e-3 * sampling.voxel_size;
        for (auto& index : body.filling->index)
            index = std::make_shared<FillingIndex>(index, WorldBox{box.min - hair, box.max + hair});
        body.samples = sampleObject({*body.filling}, 0, sampling, monitor_);
        body.samples->sharp_sides = false;
        body.samples->faces.clear();
        body.world_from_node = body.samples->world_from_node, body.origin_world = body.samples->origin_world;
    }

    static void layShape(const Surface& surface, SharpBody& body) {
        const glm::dmat3 node_from_world = glm::inverse(body.world_from_node);
        const auto nodeOf = [&](const glm::dvec3& p) { return glm::vec3(node_from_world * (p - body.origin_world)); };
        if (surface.sphere) {
            // Grids are cubic: a ball is one in nodes too.
            body.ball = glm::vec4(nodeOf(surface.sphere->center),
                                  surface.sphere->radius / glm::length(body.world_from_node[0]));
            return;
        }
        for (const glm::dvec3& p : surface.mesh->positions) body.positions.push_back(nodeOf(p));
        body.triangles = surface.mesh->triangles;
        if (!surface.smooth) return;
        for (const glm::dvec3& n : surface.mesh->normals)
            body.normals.emplace_back(glm::normalize(glm::transpose(body.world_from_node) * n));
    }

    const Scene& scene_;
    const ObjectSampling& sampling_;
    Monitor& monitor_;
    std::vector<const Surface*> ranked_;
    SharpScene out_;
};

}  // namespace

SharpScene sharpBodiesOf(const Scene& scene, const ObjectSampling& sampling, Monitor& monitor) {
    return BodyMaker(scene, sampling, monitor).make();
}

Scene withSampledBodies(const Scene& scene) {
    Scene out = scene;
    std::vector<GradedObject> objects;
    if (scene.index) objects = scene.index->objects();
    for (const Surface& surface : scene.surfaces) {
        if (!hasInside(surface) || surface.medium_below < 0) continue;
        const Medium& medium = scene.media[static_cast<std::size_t>(surface.medium_below)];
        const bool known = std::any_of(objects.begin(), objects.end(),
                                       [&](const GradedObject& object) { return object.name == medium.name; });
        if (known || (medium.ior.mean() == 1 && !medium.present())) continue;
        objects.push_back(evenObject(medium, medium.name));
        objects.back().enclosed = true;
    }
    if (!objects.empty()) out.index = std::make_shared<const IndexVolume>(std::move(objects));
    return out;
}

}  // namespace photic
