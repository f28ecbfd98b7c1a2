// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/object_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "bake/graded/voxel_mean.h"
#include "bake/report/error.h"
#include "bake/scene/solids.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kMargin = 4;  // nodes around the object: what a spline reaches, and faces
/// (n^2 - 1) / 2 that no index has: n^2 = 1e-5. Readers refuse coefficients of -0.5.
constexpr double kLeastExcess = -0.499995;

std::size_t flat(const glm::ivec3& count, const glm::ivec3& p) {
    return (static_cast<std::size_t>(p.z) * static_cast<std::size_t>(count.y) + static_cast<std::size_t>(p.y)) *
               static_cast<std::size_t>(count.x) +
           static_cast<std::size_t>(p.x);
}

/// Calls visit(node, its place in arrays) for all nodes, layer by layer on all threads.
template <class Visit>
void forEachNode(const glm::ivec3& count, Monitor& monitor, const Visit& visit) {
    parallelFor(count.z, [&](std::int64_t layer) {
        monitor.checkCancelled();
        const int z = static_cast<int>(layer);
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x) visit(glm::ivec3(x, y, z), flat(count, {x, y, z}));
    });
}

/// Whether an object fills its whole box, so that its index may jump at the box's sides.
bool fillsBox(const GradedIndex& index, const WorldBox& box) {
    const glm::dvec3 middle = 0.5 * (box.min + box.max);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                            corner & 4 ? box.max.z : box.min.z);
        if (!index.contains(middle + 0.999 * (at - middle))) return false;
    }
    return true;
}

class Sampler {
public:
    Sampler(const std::vector<GradedObject>& objects, std::size_t number, const ObjectSampling& sampling,
            Monitor& monitor)
        : objects_(objects),
          number_(number),
          object_(objects[number]),
          sampling_(sampling),
          monitor_(monitor),
          first_(*object_.index.front()) {}

    ObjectSamples sample() {
        layNodes();
        for (const auto& index : object_.index) addSpline(*index);
        layMedium();
        layFaces();
        layCoat();
        return std::move(out_);
    }

private:
    glm::dvec3 place(const glm::dvec3& node) const { return out_.origin_world + out_.world_from_node * node; }

    /// The grid, and the box that the object is in.
    void layNodes() {
        const auto samples = first_.samples();
        if (samples) {
            out_.world_from_node = samples->world_from_sample;
            out_.origin_world = samples->origin_world + out_.world_from_node * glm::dvec3(-kMargin);
            out_.count = samples->size + 2 * kMargin;
            whole_ = fillsBox(first_, *first_.bounds());
            low_ = glm::dvec3(kMargin - 0.5), high_ = glm::dvec3(samples->size + kMargin) - 0.5;
        } else {
            box_ = first_.bounds().value_or(sampling_.domain);
            whole_ = fillsBox(first_, *box_);
            const glm::dvec3 size = (box_->max - box_->min) / sampling_.voxel_size;
            const glm::dvec3 nodes = glm::ceil(size) + 1.0 + 2.0 * kMargin;
            requireFew(nodes);
            out_.world_from_node = glm::dmat3(sampling_.voxel_size);
            out_.count = glm::ivec3(nodes);
            low_ = 0.5 * (glm::dvec3(out_.count - 1) - size), high_ = low_ + size;
            out_.origin_world = box_->min - sampling_.voxel_size * low_;
        }
        requireFew(glm::dvec3(out_.count));
    }

    void requireFew(const glm::dvec3& nodes) const {
        constexpr double kMostASide = 2048;  // of textures
        const double most = static_cast<double>(sampling_.most_nodes);
        if (std::max({nodes.x, nodes.y, nodes.z}) <= kMostASide && nodes.x * nodes.y * nodes.z <= most) return;
        throw Error(
            ErrorCode::Input,
            fmt::format("the medium '{}' would take {:.0f} x {:.0f} x {:.0f} samples of its index; up to 2048 a "
                        "side and {:.0f} in all are written: use larger voxels",
                        object_.name, nodes.x, nodes.y, nodes.z, most),
            object_.where);
    }

    /// What fills the world ends with the domain.
    bool contains(const GradedIndex& index, const glm::dvec3& world) const {
        return index.contains(world) && (whole_ || !box_ || box_->contains(world));
    }

    /// (n^2 - 1) / 2 of the object at a place where no earlier one is.
    double excessAt(const GradedIndex& index, const glm::dvec3& world) const {
        for (std::size_t i = 0; i < number_; ++i)
            if (objects_[i].index.front()->contains(world)) return 0;
        if (!whole_ && box_ && !box_->contains(world)) return 0;
        return index.halfSquareAt(world) - 0.5;
    }

    /// n^2 / 2 some way beyond a side, where it is `rim`, as a straight line would have it; where that would come near
    /// 0, an exponential takes over from it without a kink, and comes to a tenth: no n^2 is negative.
    static double goneOn(double rim, double straight) {
        constexpr double kFrom = 0.5, kLeast = 0.1, kFall = kFrom - kLeast;
        const double share = straight / rim;
        return share >= kFrom ? straight : rim * (kLeast + kFall * std::exp((share - kFrom) / kFall));
    }

    /// The same of a node. Beyond sides where the index may jump it goes on in a straight line, as the spline inside
    /// would have it.
    double excessOfNode(const GradedIndex& index, const glm::ivec3& node) const {
        const glm::dvec3 at(node);
        if (whole_) {
            constexpr double kInside = 1e-9;
            const glm::dvec3 rim = glm::clamp(at, low_ + kInside, high_ - kInside);
            if (rim != at) {
                const glm::dvec3 mirrored = glm::clamp(2.0 * rim - at, low_ + kInside, high_ - kInside);
                const double there = 0.5 + excessAt(index, place(rim));
                return goneOn(there, 2 * there - (0.5 + excessAt(index, place(mirrored)))) - 0.5;
            }
            return excessAt(index, place(at));
        }
        if (first_.samples()) return excessAt(index, place(at));
        return meanOfVoxel<8>(index, at, 1);
    }

    /// Mean over a voxel around a place in nodes, `width` nodes a side.
    template <int Points>
    double meanOfVoxel(const GradedIndex& index, const glm::dvec3& at, double width) const {
        // Eye rays see which way a face looks: steps of 1 in 4^3 are terraces on it.
        return meanAcrossRims<Points>(
            place(at), out_.world_from_node * width, [&](const glm::dvec3& world) { return contains(index, world); },
            [&](const glm::dvec3& world) { return excessAt(index, world); });
    }

    /// Steps from a node to the next ripple with the grid; eye rays, which are refracted in the middle of them, see
    /// that in which way a face looks, and do not see how wide it is. So faces are spread over a Gaussian. Means over
    /// whole voxels have ripples that are longer than it, aliases of the grid: it is taken of means over half voxels,
    /// whose aliases are a quarter as strong.
    void spread(const GradedIndex& index, std::vector<double>& excess) const {
        constexpr double kSigma = 1.1;  // nodes
        SolidVolume volume;
        const glm::dvec3 halves = 2.0 * glm::dvec3(out_.count) - 1.0;
        const int fine = halves.x * halves.y * halves.z <= static_cast<double>(sampling_.most_nodes) ? 2 : 1;
        volume.size = fine * (out_.count - 1) + 1;
        volume.index.resize(volume.flat(0, 0, volume.size.z));
        if (fine == 1) {
            for (std::size_t i = 0; i < excess.size(); ++i) volume.index[i] = static_cast<float>(1 + excess[i]);
        } else {
            std::vector<char> inside(excess.size());
            forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
                inside[i] = contains(index, place(glm::dvec3(node))) ? 1 : 0;
            });
            forEachNode(volume.size, monitor_, [&](const glm::ivec3& half, std::size_t i) {
                volume.index[i] = static_cast<float>(1 + excessOfHalf(index, half, inside, excess));
            });
        }
        smooth(volume, fine * kSigma);
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            excess[i] = double(volume.index[volume.flat(fine * node.x, fine * node.y, fine * node.z)]) - 1;
        });
    }

    /// Mean over half a voxel, `half` being twice its place in nodes. Far from rims nodes around it tell.
    double excessOfHalf(const GradedIndex& index, const glm::ivec3& half, const std::vector<char>& inside,
                        const std::vector<double>& excess) const {
        const glm::ivec3 last = out_.count - 1;
        const glm::ivec3 low = glm::max(half / 2 - 1, glm::ivec3(0)), high = glm::min((half + 1) / 2 + 1, last);
        const char here = inside[flat(out_.count, low)];
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x)
                    if (inside[flat(out_.count, {x, y, z})] != here)
                        return meanOfVoxel<4>(index, 0.5 * glm::dvec3(half), 0.5);
        double sum = 0;
        for (int n = 0; n < 8; ++n) sum += excess[flat(out_.count, (half + glm::ivec3(n & 1, n >> 1 & 1, n >> 2)) / 2)];
        return sum / 8;
    }

    /// @throws Error{Input} where n^2 is 0 or less
    void requirePositive(const std::vector<double>& excess) const {
        const auto least = std::min_element(excess.begin(), excess.end());
        if (*least > kLeastExcess) return;
        const auto node = static_cast<std::size_t>(least - excess.begin());
        const auto x = static_cast<std::size_t>(out_.count.x), y = static_cast<std::size_t>(out_.count.y);
        const glm::dvec3 found(static_cast<double>(node % x), static_cast<double>(node / x % y),
                               static_cast<double>(node / (x * y)));
        const glm::dvec3 at = place(glm::clamp(found, low_, high_));
        throw Error(
            ErrorCode::Input,
            fmt::format("the square of the index of '{}' falls to {:.4g} at ({:.4g}, {:.4g}, {:.4g}) m; it must "
                        "be above 0: end the medium before that, by 'min' and 'max', 'radius' or a surface",
                        object_.name, 1 + 2 * excessAt(first_, at), at.x, at.y, at.z),
            object_.where);
    }

    void addSpline(const GradedIndex& index) {
        std::vector<double> excess(flat(out_.count, {0, 0, out_.count.z}));
        forEachNode(out_.count, monitor_,
                    [&](const glm::ivec3& node, std::size_t i) { excess[i] = excessOfNode(index, node); });
        double most = 0;
        for (const double e : excess) most = std::max(most, std::fabs(e));
        // The spline is fitted in single precision around 1/2: a faint index, as of hot air, is made strong for it.
        double scale = 1;
        while (most > 0 && most * scale < 0.125) scale *= 2;
        SplineIndex::Nodes nodes;
        nodes.count = out_.count;
        const auto fitted = [&](SplineFit fit) {
            return SplineIndex(
                nodes,
                [&](const glm::dvec3& p) { return 0.5 + scale * excess[flat(out_.count, glm::ivec3(glm::round(p)))]; },
                fit);
        };
        requirePositive(excess);
        const bool first = out_.spline.empty();
        if (first && whole_) out_.fit = SplineFit::Through;
        if (first && !whole_) out_.fit = fitted(SplineFit::Auto).fit();
        spreads_ = out_.fit == SplineFit::Plain && !first_.samples();
        if (spreads_) spread(index, excess);
        SplineIndex spline = fitted(out_.fit);
        // Where samples fall steeply towards 0 the spline through them may go below it; one near them never does.
        const float least = *std::min_element(spline.coefficients(), spline.coefficients() + excess.size());
        if ((double(least) - 0.5) / scale <= kLeastExcess) spline = fitted(SplineFit::Plain);
        if (first) samples_ = std::move(excess);
        // What is less than single precision around 1/2 is nothing.
        constexpr float kNothing = 1.2e-7f;
        std::vector<float> coefficients(samples_.size());
        for (std::size_t i = 0; i < coefficients.size(); ++i) {
            const float e = spline.coefficients()[i] - 0.5f;
            coefficients[i] = std::fabs(e) <= kNothing ? 0.0f : e / static_cast<float>(scale);
        }
        out_.spline.push_back(std::move(coefficients));
    }

    void layMedium() {
        constexpr double kJump = 1e-6;
        double rim = 0;
        for (std::size_t i = 0; whole_ && i < samples_.size(); ++i) rim = std::max(rim, std::fabs(samples_[i]));
        out_.sharp_sides = whole_ && rim > kJump;
        out_.box_low = out_.sharp_sides ? glm::vec3(low_) : glm::vec3(1);
        out_.box_high = out_.sharp_sides ? glm::vec3(high_) : glm::vec3(out_.count - 2);
        if (object_.attenuates()) out_.attenuation.assign(samples_.size(), glm::vec4(0));
        if (object_.shines() || object_.anisotropy_volume) out_.glow.assign(samples_.size(), glm::vec4(0));
        if (out_.attenuation.empty() && out_.glow.empty()) return;
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            glm::dvec3 at(node);
            if (whole_) at = glm::clamp(at, low_ + 1e-9, high_ - 1e-9);
            const double presence = meanAcrossRims(
                place(at), whole_ ? glm::dmat3(0) : out_.world_from_node,
                [&](const glm::dvec3& world) { return isThere(world); },
                [&](const glm::dvec3& world) { return isThere(world) ? 1.0 : 0.0; });
            const glm::dvec3 absorption =
                object_.absorption_volume ? object_.absorption_volume->at(place(at)) : object_.absorption * presence;
            if (!out_.attenuation.empty())
                out_.attenuation[i] = glm::vec4(glm::vec3(absorption), static_cast<float>(presence));
            if (out_.glow.empty()) return;
            const glm::dvec3 emission =
                object_.emission_volume ? object_.emission_volume->at(place(at)) : object_.emission * presence;
            const double g =
                object_.anisotropy_volume ? object_.anisotropy_volume->at(place(at)).x : object_.anisotropy;
            out_.glow[i] = glm::vec4(glm::vec3(emission), static_cast<float>(g));
        });
    }
    bool isThere(const glm::dvec3& world) const {
        for (std::size_t i = 0; i < number_; ++i)
            if (objects_[i].index.front()->contains(world)) return false;
        return contains(first_, world);
    }

    /// n at a place between nodes, as the samples have it.
    double indexBetween(const glm::dvec3& node) const {
        const glm::dvec3 inside = glm::clamp(node, glm::dvec3(0), glm::dvec3(out_.count - 1) - 1e-6);
        const glm::ivec3 low(inside);
        const glm::dvec3 t = inside - glm::dvec3(low);
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
            double weight = 1;
            for (int a = 0; a < 3; ++a) weight *= step[a] ? t[a] : 1 - t[a];
            sum += weight * samples_[flat(out_.count, low + step)];
        }
        return std::sqrt(std::max(0.0, 1 + 2 * sum));
    }

    /// Of the samples, per two nodes.
    glm::dvec3 slopeAt(const glm::ivec3& node) const {
        glm::dvec3 slope;
        for (int a = 0; a < 3; ++a) {
            glm::ivec3 ahead = node, behind = node;
            ahead[a] = std::min(node[a] + 1, out_.count[a] - 1), behind[a] = std::max(node[a] - 1, 0);
            slope[a] = samples_[flat(out_.count, ahead)] - samples_[flat(out_.count, behind)];
        }
        return slope;
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
        const glm::ivec3 low = glm::max(node - 1, glm::ivec3(0)), high = glm::min(node + 1, out_.count - 1);
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x) visit(glm::ivec3(x, y, z), flat(out_.count, {x, y, z}));
    }

    /// Faces that are smoothed over many nodes reach as far as the index still changes by a tenth of what it does in
    /// their middle: what lay outside would bend rays a second time.
    void reachOut(std::vector<std::uint8_t>& face) const {
        constexpr int kFarthest = 4;  // nodes
        constexpr float kTail = 0.1F;
        if (std::find(face.begin(), face.end(), 255) == face.end()) return;
        std::vector<float> slope(face.size());
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            slope[i] = static_cast<float>(glm::length(slopeAt(node)));
        });
        // The steepest of what each node of a wide face belongs to.
        std::vector<float> steepest(face.size(), 0.0F);
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            if (face[i] != 0 && isMiddleOfWideFace(node)) steepest[i] = slope[i];
        });
        for (int step = 0; step < kFarthest; ++step) {
            const std::vector<float> before = steepest;
            forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
                float around = 0;
                forEachAround(node, [&](const glm::ivec3&, std::size_t n) { around = std::max(around, before[n]); });
                if (around > 0 && slope[i] > kTail * around) steepest[i] = std::max(steepest[i], around);
            });
        }
        for (std::size_t i = 0; i < face.size(); ++i)
            if (steepest[i] > 0) face[i] = 255;
    }

    void layFaces() {
        std::vector<std::uint8_t> face(samples_.size(), 0);
        if (!out_.sharp_sides)
            forEachNode(out_.count, monitor_,
                        [&](const glm::ivec3& node, std::size_t i) { face[i] = isFace(node) ? 255 : 0; });
        // Where a step was made wider, its width is known.
        if (!spreads_) reachOut(face);
        // A node more on all sides, and one more along the axes where a step was made wider.
        out_.faces = face;
        for (int grown = 0; grown < (spreads_ ? 2 : 1); ++grown) {
            const std::vector<std::uint8_t> before = out_.faces;
            forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
                forEachAround(node, [&](const glm::ivec3& near, std::size_t n) {
                    const glm::ivec3 apart = glm::abs(near - node);
                    if (grown == 0 || apart.x + apart.y + apart.z <= 1)
                        out_.faces[i] = std::max(out_.faces[i], before[n]);
                });
            });
        }
        if (std::count(out_.faces.begin(), out_.faces.end(), 255) == 0) out_.faces.clear();
    }

    void layCoat() {
        if (!object_.face.albedo_volume || (out_.faces.empty() && !out_.sharp_sides)) return;
        out_.coat.resize(samples_.size());
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            out_.coat[i] = glm::vec3(object_.face.albedo_volume->at(place(glm::dvec3(node))));
        });
        constexpr int kReach = 2;
        for (int axis = 0; axis < 3; ++axis) {
            const std::vector<glm::vec3> before = out_.coat;
            forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
                for (int step = -kReach; step <= kReach; ++step) {
                    glm::ivec3 near = node;
                    near[axis] = std::clamp(near[axis] + step, 0, out_.count[axis] - 1);
                    out_.coat[i] = glm::max(out_.coat[i], before[flat(out_.count, near)]);
                }
            });
        }
    }

    const std::vector<GradedObject>& objects_;
    std::size_t number_;
    const GradedObject& object_;
    const ObjectSampling& sampling_;
    Monitor& monitor_;
    const GradedIndex& first_;
    ObjectSamples out_;
    std::vector<double> samples_;  // (n^2 - 1) / 2 of the first index
    glm::dvec3 low_{0}, high_{0};  // of the object, in nodes
    std::optional<WorldBox> box_;  // of the object, or the domain; nothing for samples
    bool whole_ = false;           // it fills its box
    bool spreads_ = false;         // its faces are made wider than a step
};

}  // namespace

ObjectSamples sampleObject(const std::vector<GradedObject>& objects, std::size_t number, const ObjectSampling& sampling,
                           Monitor& monitor) {
    return Sampler(objects, number, sampling, monitor).sample();
}

}  // namespace photic
