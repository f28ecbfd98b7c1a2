// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/enclosed_bodies.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <iterator>
#include <memory>
#include <optional>
#include <string>

namespace photic {
namespace {

/// Whether places are inside of a closed mesh: how often a line straight up from them goes out of it, less how often it
/// goes in. Triangles are found by columns of a map from above.
class MeshInside {
public:
    explicit MeshInside(const TriangleMesh& mesh) : mesh_(mesh) {
        for (const glm::dvec3& p : mesh.positions) low_ = glm::min(low_, p), high_ = glm::max(high_, p);
        constexpr double kMost = 512, kATriangle = 2;  // columns a side; a side of them a triangle of a square map
        side_ = static_cast<int>(
            std::clamp(std::sqrt(kATriangle * static_cast<double>(mesh.triangles.size())), 1.0, kMost));
        columns_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            glm::dvec3 least(high_), most(low_);
            for (const std::uint32_t v : mesh.triangles[t])
                least = glm::min(least, mesh.positions[v]), most = glm::max(most, mesh.positions[v]);
            const glm::ivec2 from = columnOf(least), to = columnOf(most);
            for (int j = from.y; j <= to.y; ++j)
                for (int i = from.x; i <= to.x; ++i) columns_[flat({i, j})].push_back(t);
        }
    }

    WorldBox box() const { return {low_, high_}; }
    bool contains(const glm::dvec3& world) const {
        if (!box().contains(world)) return false;
        // A little beside what meshes are likely to have edges at.
        const glm::dvec3 size = high_ - low_, at = world + glm::dvec3(1.3e-7 * size.x, 2.1e-7 * size.y, 0);
        int depth = 0;
        for (const std::uint32_t t : columns_[flat(columnOf(at))]) depth += crossingAbove(t, at);
        return depth != 0;
    }

private:
    std::size_t flat(const glm::ivec2& column) const {
        return static_cast<std::size_t>(column.y) * static_cast<std::size_t>(side_) +
               static_cast<std::size_t>(column.x);
    }
    glm::ivec2 columnOf(const glm::dvec3& p) const {
        glm::ivec2 column;
        for (int a = 0; a < 2; ++a) {
            const double size = high_[a] - low_[a], share = size > 0 ? (p[a] - low_[a]) / size : 0;
            column[a] = std::clamp(static_cast<int>(share * side_), 0, side_ - 1);
        }
        return column;
    }
    /// 1 where the line goes out of the mesh, -1 where it goes in, 0 where it misses the triangle.
    int crossingAbove(std::uint32_t triangle, const glm::dvec3& from) const {
        const auto& corner = mesh_.triangles[triangle];
        const glm::dvec3 &a = mesh_.positions[corner[0]], &b = mesh_.positions[corner[1]],
                         &c = mesh_.positions[corner[2]];
        const auto side = [&](const glm::dvec3& p, const glm::dvec3& q) {
            return (q.x - p.x) * (from.y - p.y) - (q.y - p.y) * (from.x - p.x);
        };
        const double wa = side(b, c), wb = side(c, a), wc = side(a, b), area = wa + wb + wc;
        if (area == 0 || wa * area < 0 || wb * area < 0 || wc * area < 0) return 0;
        if ((wa * a.z + wb * b.z + wc * c.z) / area <= from.z) return 0;
        return area > 0 ? 1 : -1;
    }

    const TriangleMesh& mesh_;
    glm::dvec3 low_{1e300}, high_{-1e300};
    int side_ = 1;
    std::vector<std::vector<std::uint32_t>> columns_;
};

/// What the surfaces of a scene part: which of its media is at a place.
class PartedSpace {
public:
    explicit PartedSpace(const Scene& scene) : scene_(scene) {
        for (const Surface& surface : scene.surfaces) {
            if (surface.height_field) waters_.push_back(&surface);
            if (surface.thin || surface.event == SurfaceEvent::Mirror) continue;
            if (!surface.mesh || !surface.closed) continue;
            Body body{&surface, nullptr, {}, 0, 0};
            if (surface.sphere)
                body.box = {surface.sphere->center - surface.sphere->radius,
                            surface.sphere->center + surface.sphere->radius};
            else
                body.mesh = std::make_unique<MeshInside>(*surface.mesh), body.box = body.mesh->box();
            const glm::dvec3 size = body.box.max - body.box.min;
            body.volume = size.x * size.y * size.z;
            if (surface.medium_below >= 0)
                body.priority = scene.media[static_cast<std::size_t>(surface.medium_below)].priority;
            bodies_.push_back(std::move(body));
        }
        if (!scene.surfaces.empty())
            around_ = waters_.empty() ? scene.surfaces.front().medium_above : waters_.front()->medium_above;
        std::stable_sort(bodies_.begin(), bodies_.end(), [](const Body& a, const Body& b) {
            return a.priority != b.priority ? a.priority > b.priority : a.volume < b.volume;
        });
    }

    /// Its place in Scene::media; -1: one that has no name.
    int mediumAt(const glm::dvec3& world) const {
        for (const Body& body : bodies_)
            if (body.contains(world)) return body.surface->medium_below;
        for (const Surface* water : waters_) {
            if (water->outside == Outside::None) {
                const glm::dvec2 off = glm::abs(glm::dvec2(world) - glm::dvec2(water->center));
                if (off.x > 0.5 * water->size.x || off.y > 0.5 * water->size.y) continue;
            }
            if (world.z < water->height_field->at(glm::dvec2(world)).position.z) return water->medium_below;
        }
        return around_;
    }

    /// What holds a medium: the bodies that it fills; nothing where it may be anywhere.
    std::optional<WorldBox> boxOf(int medium) const {
        if (around_ == medium) return {};
        for (const Surface* water : waters_)
            if (water->medium_below == medium || water->medium_above == medium) return {};
        std::optional<WorldBox> box;
        for (const Body& body : bodies_) {
            if (body.surface->medium_above == medium) return {};
            if (body.surface->medium_below != medium) continue;
            if (!box) box = body.box;
            box->min = glm::min(box->min, body.box.min), box->max = glm::max(box->max, body.box.max);
        }
        return box;
    }

    /// Whether it ends everywhere at surfaces that have an inside.
    bool knows(int medium) const {
        return std::none_of(scene_.surfaces.begin(), scene_.surfaces.end(), [&](const Surface& surface) {
            return surface.mesh && !surface.closed && !surface.thin && surface.event != SurfaceEvent::Mirror &&
                   (surface.medium_above == medium || surface.medium_below == medium);
        });
    }

private:
    struct Body {
        const Surface* surface;
        std::unique_ptr<MeshInside> mesh;  // null: a sphere
        WorldBox box;
        double volume;
        int priority;
        bool contains(const glm::dvec3& world) const {
            if (mesh) return mesh->contains(world);
            return glm::distance(world, surface->sphere->center) < surface->sphere->radius;
        }
    };
    const Scene& scene_;
    std::vector<Body> bodies_;
    std::vector<const Surface*> waters_;
    int around_ = -1;  // all of them
};

/// A medium that ends where surfaces end it.
class EnclosedIndex final : public GradedIndex {
public:
    EnclosedIndex(std::shared_ptr<const GradedIndex> index, std::shared_ptr<const PartedSpace> space, int medium)
        : index_(std::move(index)), space_(std::move(space)), medium_(medium) {}
    IndexSample at(const glm::dvec3& world) const override {
        IndexSample sample = index_->at(world);
        sample.half_square = halfSquareAt(world);
        return sample;
    }
    double halfSquareAt(const glm::dvec3& world) const override {
        return contains(world) ? halfSquareEnclosed(*index_, world) : 0.5;
    }
    bool contains(const glm::dvec3& world) const override { return space_->mediumAt(world) == medium_; }
    std::optional<WorldBox> bounds() const override { return space_->boxOf(medium_); }

private:
    std::shared_ptr<const GradedIndex> index_;
    std::shared_ptr<const PartedSpace> space_;
    int medium_;
};

}  // namespace

double halfSquareEnclosed(const GradedIndex& index, const glm::dvec3& world) {
    glm::dvec3 place = world;
    if (const auto bounds = index.bounds()) {
        // A hair within it: on the rim itself there may be air.
        const glm::dvec3 rim = 1e-6 * (bounds->max - bounds->min);
        place = glm::clamp(place, bounds->min + rim, bounds->max - rim);
    }
    return index.halfSquareAt(place);
}

std::vector<GradedObject> bodiesOf(const Scene& scene) {
    if (!scene.index) return {};
    std::vector<GradedObject> bodies = scene.index->objects();
    const auto enclosed = [](const GradedObject& object) { return object.enclosed; };
    if (std::none_of(bodies.begin(), bodies.end(), enclosed)) return bodies;
    const auto space = std::make_shared<const PartedSpace>(scene);
    for (GradedObject& body : bodies) {
        if (!body.enclosed) continue;
        const auto named = std::find_if(scene.media.begin(), scene.media.end(),
                                        [&](const Medium& medium) { return medium.name == body.name; });
        const int medium = static_cast<int>(std::distance(scene.media.begin(), named));
        if (!space->knows(medium)) continue;
        for (auto& index : body.index) index = std::make_shared<EnclosedIndex>(index, space, medium);
    }
    std::stable_partition(bodies.begin(), bodies.end(), enclosed);
    return bodies;
}

}  // namespace photic
