// SPDX-License-Identifier: Apache-2.0
#include "bake/graded/object_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "bake/graded/face_nodes.h"
#include "bake/graded/node_grid.h"
#include "bake/graded/rim_mean.h"
#include "bake/graded/voxel_mean.h"
#include "bake/report/error.h"
#include "bake/scene/solids.h"

namespace photic {
namespace {

constexpr int kMargin = 4;  // nodes around the object: what a spline reaches, and faces
/// (n^2 - 1) / 2 that no index has: n^2 = 1e-5. Readers refuse coefficients of -0.5.
constexpr double kLeastExcess = -0.499995;

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
    /// that in which way a face looks, and do not see how wide it is. So faces are made wider, all alike: along the
    /// normal of the rim by a raised cosine, and where it has edges by a Gaussian of as much.
    void spread(const GradedIndex& index, std::vector<double>& excess) const {
        constexpr double kSigma = 1;                    // nodes
        constexpr double kHalfWidth = kSigma / 0.3615;  // of a raised cosine of that deviation
        // How much of the object is around each node: where the rim is near, and which way it looks.
        SolidVolume near;
        near.size = out_.count;
        near.index.resize(excess.size());
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            near.index[i] = isThere(place(glm::dvec3(node))) ? 2.0F : 1.0F;
        });
        smooth(near, kSigma);
        const RimMean mean{[&](const glm::dvec3& node) { return isThere(place(node)); },
                           [&](const glm::dvec3& node) { return excessAt(index, place(node)); }, kHalfWidth};
        std::vector<char> edge(excess.size(), jumpsWithin(near, excess) ? 1 : 0);
        const std::vector<double> means = excess;
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            if (edge[i] != 0) return;
            if (isAway(near.index[i])) {
                excess[i] = excessAt(index, place(glm::dvec3(node)));
                return;
            }
            const glm::dvec3 towards =
                differenceAt(out_.count, node, [&](std::size_t n) { return double(near.index[n]); });
            const auto smoothed = glm::length(towards) > 0 ? mean.at(glm::dvec3(node), towards) : std::nullopt;
            if (smoothed) excess[i] = *smoothed;
            edge[i] = smoothed ? 0 : 1;
        });
        if (std::find(edge.begin(), edge.end(), 1) != edge.end()) spreadEdges(index, kSigma, edge, means, excess);
    }

    /// Of a smoothed share of the object, 1 more: whether no rim is near.
    static bool isAway(float near) {
        constexpr float kAlone = 1e-4F;
        return near < 1 + kAlone || near > 2 - kAlone;
    }

    /// Whether the index has faces of its own, away from where the object ends: neighbours that are more than a quarter
    /// of its range apart.
    bool jumpsWithin(const SolidVolume& near, const std::vector<double>& excess) const {
        constexpr double kJump = 0.25;
        const auto [least, most] = std::minmax_element(excess.begin(), excess.end());
        const double range = *most - *least;
        std::atomic<bool> jumps{false};
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            for (int a = 0; a < 3; ++a) {
                glm::ivec3 next = node;
                if (++next[a] >= out_.count[a]) continue;
                const std::size_t n = flat(out_.count, next);
                if (isAway(near.index[i]) && isAway(near.index[n]) && std::fabs(excess[i] - excess[n]) > kJump * range)
                    jumps = true;
            }
        });
        return jumps;
    }

    /// Where the rim has edges, or the index jumps within, faces are spread over a Gaussian. Means over whole voxels
    /// have ripples that are longer than it, aliases of the grid: it is taken of means over half voxels, whose aliases
    /// are a quarter as strong.
    void spreadEdges(const GradedIndex& index, double sigma, const std::vector<char>& edge,
                     const std::vector<double>& means, std::vector<double>& excess) const {
        const std::vector<char> needed = around(edge, static_cast<int>(std::ceil(4 * sigma)) + 1);
        SolidVolume volume;
        const glm::dvec3 halves = 2.0 * glm::dvec3(out_.count) - 1.0;
        const int fine = halves.x * halves.y * halves.z <= static_cast<double>(sampling_.most_nodes) ? 2 : 1;
        volume.size = fine * (out_.count - 1) + 1;
        volume.index.resize(volume.flat(0, 0, volume.size.z));
        if (fine == 1) {
            for (std::size_t i = 0; i < means.size(); ++i) volume.index[i] = static_cast<float>(1 + means[i]);
        } else {
            std::vector<char> inside(means.size());
            forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
                inside[i] = contains(index, place(glm::dvec3(node))) ? 1 : 0;
            });
            forEachNode(volume.size, monitor_, [&](const glm::ivec3& half, std::size_t i) {
                if (needed[flat(out_.count, half / 2)] != 0)
                    volume.index[i] = static_cast<float>(1 + excessOfHalf(index, half, inside, means));
            });
        }
        smooth(volume, fine * sigma);
        forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
            if (edge[i] != 0)
                excess[i] = double(volume.index[volume.flat(fine * node.x, fine * node.y, fine * node.z)]) - 1;
        });
    }

    /// Nodes that are at most `reach` along each axis from one that is marked.
    std::vector<char> around(std::vector<char> marked, int reach) const {
        for (int axis = 0; axis < 3; ++axis) {
            const std::vector<char> before = marked;
            forEachNode(out_.count, monitor_, [&](const glm::ivec3& node, std::size_t i) {
                glm::ivec3 near = node;
                const int last = std::min(node[axis] + reach, out_.count[axis] - 1);
                for (near[axis] = std::max(node[axis] - reach, 0); near[axis] <= last && marked[i] == 0; ++near[axis])
                    marked[i] = before[flat(out_.count, near)];
            });
        }
        return marked;
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

    void layFaces() {
        if (!out_.sharp_sides) out_.faces = faceNodes(out_.count, samples_, spreads_, monitor_);
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
