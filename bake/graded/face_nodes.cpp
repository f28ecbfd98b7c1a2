// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/face_nodes.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/graded/node_grid.h"

namespace photic {
namespace {

class FaceFinder {
public:
    FaceFinder(const glm::ivec3& count, const std::vector<double>& samples, Monitor& monitor)
        : count_(count), samples_(samples), monitor_(monitor) {}

    std::vector<std::uint8_t> find(bool widened) const {
        std::vector<std::uint8_t> face(samples_.size(), 0);
        forEachNode(count_, monitor_, [&](const glm::ivec3& node, std::size_t i) { face[i] = isFace(node) ? 255 : 0; });
        // Where a step was made wider, its width is known.
        if (!widened) reachOut(face);
        // A node more on all sides, and one more along the axes where a step was made wider.
        for (int grown = 0; grown < (widened ? 2 : 1); ++grown) {
            const std::vector<std::uint8_t> before = face;
            forEachNode(count_, monitor_, [&](const glm::ivec3& node, std::size_t i) {
                forEachAround(node, [&](const glm::ivec3& near, std::size_t n) {
                    const glm::ivec3 apart = glm::abs(near - node);
                    if (grown == 0 || apart.x + apart.y + apart.z <= 1) face[i] = std::max(face[i], before[n]);
                });
            });
        }
        if (std::find(face.begin(), face.end(), 255) == face.end()) face.clear();
        return face;
    }

private:
    /// n at a place between nodes, as the samples have it.
    double indexBetween(const glm::dvec3& node) const {
        const glm::dvec3 inside = glm::clamp(node, glm::dvec3(0), glm::dvec3(count_ - 1) - 1e-6);
        const glm::ivec3 low(inside);
        const glm::dvec3 t = inside - glm::dvec3(low);
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
            double weight = 1;
            for (int a = 0; a < 3; ++a) weight *= step[a] ? t[a] : 1 - t[a];
            sum += weight * samples_[flat(count_, low + step)];
        }
        return std::sqrt(std::max(0.0, 1 + 2 * sum));
    }

    /// Of the samples, per two nodes.
    glm::dvec3 slopeAt(const glm::ivec3& node) const {
        return differenceAt(count_, node, [&](std::size_t n) { return samples_[n]; });
    }

    bool isFace(const glm::ivec3& node) const {
        constexpr double kLeastJump = 0.003, kShare = 0.7, kNear = 2, kFar = 6;  // nodes
        const glm::dvec3 slope = slopeAt(node);
        const double length = glm::length(slope);
        if (!(length > 1e-4)) return false;
        const glm::dvec3 normal = slope / length, at(node);
        const double near = indexBetween(at + kNear * normal) - indexBetween(at - kNear * normal),
                     far = indexBetween(at + kFar * normal) - indexBetween(at - kFar * normal);
        return near > kLeastJump && near > kShare * far;
    }

    /// Whether a face, of which this is the middle, is wider than the nodes that isFace() finds.
    bool isMiddleOfWideFace(const glm::ivec3& node) const {
        constexpr double kMiddle = 0.35, kShare = 0.9, kNear = 2, kFar = 6;  // nodes
        const glm::dvec3 slope = slopeAt(node);
        const double length = glm::length(slope);
        if (!(length > 1e-4)) return false;
        const auto along = [&](double nodes) { return indexBetween(glm::dvec3(node) + (nodes / length) * slope); };
        const double ahead = along(1), behind = along(-1);
        return std::fabs(ahead + behind - 2 * along(0)) < kMiddle * (ahead - behind) &&
               along(kNear) - along(-kNear) < kShare * (along(kFar) - along(-kFar));
    }

    /// Calls visit(node, number) for each node around another one, itself among them.
    template <class Visit>
    void forEachAround(const glm::ivec3& node, const Visit& visit) const {
        const glm::ivec3 low = glm::max(node - 1, glm::ivec3(0)), high = glm::min(node + 1, count_ - 1);
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x) visit(glm::ivec3(x, y, z), flat(count_, {x, y, z}));
    }

    /// Faces that are smoothed over many nodes reach as far as the index still changes by a tenth of what it does in
    /// their middle: what lay outside would bend rays a second time.
    void reachOut(std::vector<std::uint8_t>& face) const {
        constexpr int kFarthest = 4;  // nodes
        constexpr float kTail = 0.1F;
        if (std::find(face.begin(), face.end(), 255) == face.end()) return;
        std::vector<float> slope(face.size());
        forEachNode(count_, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            slope[i] = static_cast<float>(glm::length(slopeAt(node)));
        });
        // The steepest of what each node of a wide face belongs to.
        std::vector<float> steepest(face.size(), 0.0F);
        forEachNode(count_, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            if (face[i] != 0 && isMiddleOfWideFace(node)) steepest[i] = slope[i];
        });
        for (int step = 0; step < kFarthest; ++step) {
            const std::vector<float> before = steepest;
            forEachNode(count_, monitor_, [&](const glm::ivec3& node, std::size_t i) {
                float around = 0;
                forEachAround(node, [&](const glm::ivec3&, std::size_t n) { around = std::max(around, before[n]); });
                if (around > 0 && slope[i] > kTail * around) steepest[i] = std::max(steepest[i], around);
            });
        }
        for (std::size_t i = 0; i < face.size(); ++i)
            if (steepest[i] > 0) face[i] = 255;
    }

    glm::ivec3 count_;
    const std::vector<double>& samples_;  // (n^2 - 1) / 2
    Monitor& monitor_;
};

}  // namespace

std::vector<std::uint8_t> faceNodes(const glm::ivec3& count, const std::vector<double>& excess, bool widened,
                                    Monitor& monitor) {
    return FaceFinder(count, excess, monitor).find(widened);
}

}  // namespace photic
