// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/lookup_error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <variant>

#include "bake/methods/plane_light.h"
#include "bake/picture/closed_bodies.h"
#include "bake/picture/receiver_picture.h"
#include "bake/picture/volume_lookup.h"
#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kTexelsASide = 512, kMostTexelsASide = 2048;
constexpr double kShareOfBake = 0.25;
// Of a part's light, with its look-ups; and what it takes to ask planeLightSeconds for that [s].
constexpr double kDearer = 1.8, kSecondsAQuestion = 0.02;
// Upright strips of a receiver, in an order in which the first few lie far apart. Light differs with the depth of a
// wall, and is much the same from strip to strip.
constexpr std::array<int, 8> kStrips{2, 5, 0, 7, 4, 1, 6, 3};
constexpr std::size_t kFewestStrips = 2;
constexpr std::size_t kMostReceivers = 4;  // the largest ones
constexpr std::size_t kMostFaces = 4;      // of a mesh, those with most light
constexpr double kLeastShare = 0.01;       // of a mesh's area, for its faces to tell of it

/// A flat part of a receiver: a plane's rectangle, or that around a triangle of a mesh.
struct Face {
    PlaneTexels texels;
    std::optional<std::array<glm::dvec3, 3>> triangle;
    double area() const { return double(texels.columns) * texels.rows * texels.side() * texels.side(); }
    /// Whether a point of its plane is on it.
    bool holds(const glm::dvec3& point) const {
        if (!triangle) return true;
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::dvec3 &from = (*triangle)[k], &to = (*triangle)[(k + 1) % 3], &other = (*triangle)[(k + 2) % 3];
            const glm::dvec3 inwards = glm::cross(glm::cross(to - from, other - from), to - from);
            if (glm::dot(inwards, point - from) < 0) return false;
        }
        return true;
    }
};

struct Receiver {
    std::string name;
    std::vector<Face> faces;
    double area = 0;  ///< [m2] of all of it
};

PlaneTexels texelsOf(const PictureFrame& frame) {
    PlaneTexels texels;
    texels.origin = frame.origin, texels.normal = frame.normal;
    texels.right = frame.across / double(frame.width), texels.up = frame.up / double(frame.height);
    texels.columns = frame.width, texels.rows = frame.height;
    return texels;
}

int resolutionFor(const Scene& scene, const std::string& name, double detail) {
    if (!(detail > 0)) return kTexelsASide;
    const PictureFrame frame = receiverFrame(scene, name, kTexelsASide);
    const double side = std::max(glm::length(frame.across), glm::length(frame.up));
    return std::clamp(static_cast<int>(std::lround(std::min(side / detail, 1e6))), 1, kMostTexelsASide);
}

using Polygon = std::vector<glm::dvec3>;

/// What of a triangle lies in the domain (Sutherland and Hodgman 1974).
Polygon withinDomain(const Domain& domain, const std::array<glm::dvec3, 3>& corners) {
    Polygon polygon(corners.begin(), corners.end());
    for (int side = 0; side < 6 && !polygon.empty(); ++side) {
        const int axis = side / 2;
        const auto inwards = [&](const glm::dvec3& p) {
            return side % 2 == 0 ? p[axis] - domain.min[axis] : domain.max[axis] - p[axis];
        };
        Polygon kept;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec3 &from = polygon[i], &to = polygon[(i + 1) % polygon.size()];
            const double a = inwards(from), b = inwards(to);
            if (a >= 0) kept.push_back(from);
            if ((a >= 0) != (b >= 0)) kept.push_back(from + a / (a - b) * (to - from));
        }
        polygon = std::move(kept);
    }
    return polygon;
}

double areaOf(const Polygon& polygon) {
    glm::dvec3 twice(0);
    for (std::size_t i = 2; i < polygon.size(); ++i)
        twice += glm::cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
    return 0.5 * glm::length(twice);
}

/// What nobody looks at: places behind planes that stop light, and within closed bodies.
class HiddenPlaces {
public:
    explicit HiddenPlaces(const Scene& scene) : scene_(scene), bodies_(scene) {}
    /// Of a place on the receiver `name`, with its normal and the half of a texel [m].
    bool hold(const std::string& name, const glm::dvec3& point, const glm::dvec3& normal, double margin) const {
        for (const Object& object : scene_.objects) {
            const Plane* plane = std::get_if<Plane>(&object.shape);
            if (!plane || !object.blocks() || object.name == name) continue;
            if (glm::dot(plane->normal, point - plane->point) < margin) return true;
        }
        return bodies_.hold(point + margin * normal);
    }

private:
    const Scene& scene_;
    ClosedBodies bodies_;
};

/// The volume and what of the receivers in it is seen.
struct Seen {
    const VolumeLookup& lookup;
    const HiddenPlaces& hidden;
};

/// Light [W] that falls on a polygon's side and is seen, going by look-ups at some places.
double lightOn(const Seen& seen, const std::string& name, const Polygon& polygon, const glm::dvec3& normal,
               double margin) {
    constexpr int kParts = 4;  // of a side
    double light = 0;
    for (std::size_t i = 2; i < polygon.size(); ++i) {
        const glm::dvec3 u = polygon[i - 1] - polygon[0], v = polygon[i] - polygon[0];
        const double area = 0.5 * glm::length(glm::cross(u, v)) / (kParts * kParts);
        for (int a = 0; a < kParts; ++a)
            for (int b = 0; a + b < kParts; ++b)
                for (const double third : {1.0 / 3, 2.0 / 3}) {
                    if (third > 0.5 && a + b + 1 == kParts) continue;
                    const glm::dvec3 at = polygon[0] + (a + third) / kParts * u + (b + third) / kParts * v;
                    if (seen.hidden.hold(name, at, normal, margin)) continue;
                    const glm::dvec3 e = seen.lookup.receiverIrradiance(at, normal);
                    light += area * (e.x + e.y + e.z) / 3;
                }
    }
    return light;
}

/// The square of texels around what of a triangle lies in the domain, on the side of `normal`.
Face faceOf(const std::array<glm::dvec3, 3>& corners, const Polygon& polygon, const glm::dvec3& normal, double detail) {
    glm::dvec3 middle(0);
    for (const glm::dvec3& p : polygon) middle += p / static_cast<double>(polygon.size());
    const glm::dvec3 across = glm::cross(glm::dvec3(0, 0, 1), normal);
    const glm::dvec3 right = glm::length(across) > 1e-9 ? glm::normalize(across) : glm::dvec3(1, 0, 0),
                     up = glm::cross(normal, right);
    const auto range = [&](const glm::dvec3& axis) {
        double low = std::numeric_limits<double>::infinity(), high = -low;
        for (const glm::dvec3& p : polygon)
            low = std::min(low, glm::dot(p, axis)), high = std::max(high, glm::dot(p, axis));
        return std::pair{low, high};
    };
    const auto [u0, u1] = range(right);
    const auto [v0, v1] = range(up);
    Face face;
    face.triangle = corners;
    PlaneTexels& texels = face.texels;
    detail = std::max({detail, (u1 - u0) / kMostTexelsASide, (v1 - v0) / kMostTexelsASide});
    texels.right = detail * right, texels.up = detail * up, texels.normal = normal;
    texels.columns = static_cast<int>(std::floor((u1 - u0) / detail));
    texels.rows = static_cast<int>(std::floor((v1 - v0) / detail));
    texels.origin = middle + (u0 - glm::dot(middle, right)) * right + (v0 - glm::dot(middle, up)) * up;
    return face;
}

/// The triangles of a mesh that get most light, where they are wider than some texels.
Receiver meshReceiver(const Scene& scene, const Object& object, const TriangleMesh& mesh, double detail,
                      const Seen& seen) {
    constexpr int kNarrowest = 8;             // texels
    constexpr std::size_t kCandidates = 256;  // the largest
    Receiver receiver{object.name, {}, 0};
    const auto cornersOf = [&](std::size_t t) {
        const auto& index = mesh.triangles[t];
        return std::array{mesh.positions[index[0]], mesh.positions[index[1]], mesh.positions[index[2]]};
    };
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high(-low);
    std::vector<std::pair<double, std::size_t>> by_area;  // largest first: their areas count down
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Polygon polygon = withinDomain(scene.domain, cornersOf(t));
        const double area = areaOf(polygon);
        if (!(area > 0)) continue;
        for (const glm::dvec3& p : polygon) low = glm::min(low, p), high = glm::max(high, p);
        receiver.area += area;
        by_area.emplace_back(-area, t);
    }
    if (by_area.empty()) return receiver;
    const glm::dvec3 size = high - low;
    if (!(detail > 0)) detail = std::max({size.x, size.y, size.z}) / kTexelsASide;
    const std::size_t count = std::min(by_area.size(), kCandidates);
    std::partial_sort(by_area.begin(), by_area.begin() + static_cast<std::ptrdiff_t>(count), by_area.end());
    std::vector<std::pair<double, Face>> by_light;
    for (std::size_t i = 0; i < count; ++i) {
        const auto corners = cornersOf(by_area[i].second);
        const Polygon polygon = withinDomain(scene.domain, corners);
        glm::dvec3 normal = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
        double light = lightOn(seen, object.name, polygon, normal, 0.5 * detail);
        const double behind = lightOn(seen, object.name, polygon, -normal, 0.5 * detail);
        if (behind > light) light = behind, normal = -normal;
        Face face = faceOf(corners, polygon, normal, detail);
        if (light > 0 && face.texels.columns >= kNarrowest && face.texels.rows >= kNarrowest)
            by_light.emplace_back(light, std::move(face));
    }
    std::stable_sort(by_light.begin(), by_light.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    double measured = 0;
    for (auto& [light, face] : by_light) {
        if (receiver.faces.size() == kMostFaces) break;
        measured += areaOf(withinDomain(scene.domain, *face.triangle));
        receiver.faces.push_back(std::move(face));
    }
    // A few of a ball's facets, all at its brightest place, tell nothing of the ball.
    if (measured < kLeastShare * receiver.area) receiver.faces.clear();
    return receiver;
}

/// The receivers that lie in the domain and have flat parts; those that stay where they are, if there are any.
std::vector<Receiver> receiversOf(const Scene& scene, double detail, const Seen& seen) {
    std::vector<Receiver> fixed, movable;
    for (const Object& object : scene.objects) {
        if (!object.receives()) continue;
        Receiver receiver{object.name, {}, 0};
        if (const auto* mesh = std::get_if<std::shared_ptr<const TriangleMesh>>(&object.shape)) {
            receiver = meshReceiver(scene, object, **mesh, detail, seen);
        } else if (std::holds_alternative<Plane>(object.shape)) {
            try {
                const int resolution = resolutionFor(scene, object.name, detail);
                receiver.faces.push_back({texelsOf(receiverFrame(scene, object.name, resolution)), {}});
                receiver.area = receiver.faces.front().area();
            } catch (const Error& error) {
                if (error.code() != ErrorCode::Input) throw;  // it lies outside
            }
        }
        if (!receiver.faces.empty()) (object.blocks() ? fixed : movable).push_back(std::move(receiver));
    }
    std::vector<Receiver> all = std::move(fixed.empty() ? movable : fixed);
    std::stable_sort(all.begin(), all.end(), [](const Receiver& a, const Receiver& b) { return a.area > b.area; });
    if (all.size() > kMostReceivers) all.erase(all.begin() + kMostReceivers, all.end());
    return all;
}

PlaneTexels stripOf(const PlaneTexels& all, int number) {
    const int strips = static_cast<int>(kStrips.size());
    const int first = number * all.columns / strips;
    PlaneTexels strip = all;
    strip.columns = (number + 1) * all.columns / strips - first;
    strip.origin = all.origin + double(first) * all.right;
    return strip;
}

/// What may be spent on a receiver.
struct Allowance {
    double seconds = 0;        ///< of one thread; what is spent is taken off
    std::size_t at_least = 0;  ///< strips that are looked at whatever they cost
};

/// The parts of a face that are looked at; none where even few cost too much.
std::vector<PlaneTexels> partsOf(const Scene& scene, const PlaneTexels& texels, double tolerance,
                                 Allowance& allowance) {
    // Meshes are launched whole for any part of a receiver, which takes longer than the bake; even to tell how much.
    const bool launched_whole = std::any_of(scene.surfaces.begin(), scene.surfaces.end(),
                                            [](const Surface& s) { return s.height_field == nullptr; });
    if (launched_whole) return {};
    double& budget = allowance.seconds;
    if (allowance.at_least == 0 && budget < 2 * kSecondsAQuestion) return {};
    budget = std::max(0.0, budget - kSecondsAQuestion);
    // A strip takes what its part of the whole does, and more where the face is so small that its surroundings count.
    const bool narrow = texels.columns < static_cast<int>(kStrips.size());
    const double a_part = kDearer * planeLightSeconds(scene, narrow ? texels : stripOf(texels, kStrips[0]), tolerance);
    const double whole = narrow ? a_part : a_part * double(kStrips.size());
    if (whole <= budget) {
        budget -= whole;
        return {texels};
    }
    auto strips = narrow ? 0 : static_cast<std::size_t>(budget / a_part);
    if (strips < kFewestStrips) strips = allowance.at_least;
    budget = std::max(0.0, budget - a_part * static_cast<double>(strips));
    std::vector<PlaneTexels> parts;
    for (std::size_t i = 0; i < strips; ++i) {
        const PlaneTexels strip = stripOf(texels, kStrips[i]);
        if (strip.columns > 0) parts.push_back(strip);
    }
    return parts;
}

/// Look-ups, mean over each texel.
void lookUp(const Scene& scene, const std::string& name, const Face& face, const PlaneTexels& texels, const Seen& seen,
            ReceiverPatch& patch) {
    const double voxel = scene.domain.voxel_size;
    constexpr double kRounding = 1e-9;
    // Two a voxel: fewer would tell the folds in a wide texel by chance.
    constexpr int kMostPoints = 32;
    const int points = std::clamp(static_cast<int>(std::ceil(2 * texels.side() / voxel)), 1, kMostPoints);
    patch.found.assign(patch.light.size(), 0);
    parallelFor(texels.rows, [&](std::int64_t row) {
        const int j = static_cast<int>(row);
        for (int i = 0; i < texels.columns; ++i) {
            const auto n = static_cast<std::size_t>(j * texels.columns + i);
            const glm::dvec3 centre = texels.centre(i, j);
            if (!face.holds(centre) || seen.lookup.covered(centre) < 1 - kRounding ||
                seen.hidden.hold(name, centre, texels.normal, 0.5 * texels.side())) {
                patch.light[n] = -1;
                continue;
            }
            glm::dvec3 sum(0);
            for (int b = 0; b < points; ++b)
                for (int a = 0; a < points; ++a)
                    sum += seen.lookup.receiverIrradiance(
                        texels.origin + (i + (a + 0.5) / points) * texels.right + (j + (b + 0.5) / points) * texels.up,
                        texels.normal);
            patch.found[n] = static_cast<float>((sum.x + sum.y + sum.z) / (3 * points * points));
        }
    });
}

/// Sums over texels that somebody looks at.
struct Sums {
    double apart = 0, light = 0;
    std::int64_t texels = 0;
    void add(double found, double truth) { apart += std::fabs(found - truth), light += truth, ++texels; }
};

Sums sumsOf(const std::vector<ReceiverPatch>& patches) {
    Sums sums;
    for (const ReceiverPatch& patch : patches)
        for (std::size_t n = 0; n < patch.light.size(); ++n)
            if (patch.light[n] >= 0) sums.add(double(patch.found[n]), double(patch.light[n]));
    return sums;
}

/// Means over whole voxels of `texels` texels a side, the first of which begins at a texel; NaN where any of them is
/// not looked at.
class VoxelMeans {
public:
    VoxelMeans(const ReceiverPatch& patch, int texels, int first_x, int first_y)
        : texels_(texels),
          first_x_(first_x),
          first_y_(first_y),
          columns_((patch.columns - first_x) / texels),
          rows_((patch.rows - first_y) / texels),
          means_(static_cast<std::size_t>(std::max(0, columns_) * std::max(0, rows_))) {
        for (int y = 0; y < rows_; ++y)
            for (int x = 0; x < columns_; ++x) {
                double sum = 0;
                for (int j = 0; j < texels; ++j)
                    for (int i = 0; i < texels; ++i) {
                        const double e = double(patch.light[static_cast<std::size_t>(
                            (first_y + y * texels + j) * patch.columns + first_x + x * texels + i)]);
                        sum += e >= 0 ? e : std::nan("");
                    }
                means_[static_cast<std::size_t>(y * columns_ + x)] = sum / (double(texels) * texels);
            }
    }
    /// Bilinear between voxels' middles, at a texel's centre; NaN where that is not known.
    double at(int i, int j) const {
        const double x = (i + 0.5 - first_x_) / texels_ - 0.5, y = (j + 0.5 - first_y_) / texels_ - 0.5;
        const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
        if (x0 < 0 || y0 < 0 || x0 + 1 >= columns_ || y0 + 1 >= rows_) return std::nan("");
        const auto mean = [&](int dx, int dy) {
            return means_[static_cast<std::size_t>((y0 + dy) * columns_ + x0 + dx)];
        };
        const double fx = x - x0, fy = y - y0;
        return (1 - fy) * ((1 - fx) * mean(0, 0) + fx * mean(1, 0)) + fy * ((1 - fx) * mean(0, 1) + fx * mean(1, 1));
    }

private:
    int texels_, first_x_, first_y_, columns_, rows_;
    std::vector<double> means_;
};

}  // namespace

double MeasuredReceivers::largest() const {
    double most = 0;
    for (const ReceiverError& error : errors) most = std::max(most, error.relative_l1);
    return most;
}

MeasuredReceivers measureReceivers(const Scene& scene, const LightVolume& volume, double detail, double bake_seconds,
                                   Measure how, Monitor& monitor) {
    MeasuredReceivers measured;
    const VolumeLookup lookup(volume);
    const HiddenPlaces hidden(scene);
    const Seen seen{lookup, hidden};
    const std::vector<Receiver> receivers = receiversOf(scene, detail, seen);
    if (!volume.has_direction || !volume.has_irradiance) {
        measured.not_measured = "the volume has no direction";
    } else if (receivers.empty()) {
        measured.not_measured = "the scene has no receiver with flat faces wider than some texels";
    } else if (!planeLightRefusal(scene).empty()) {
        measured.not_measured = "only light that goes straight between faces is followed for it";
    }
    if (!measured.not_measured.empty()) return measured;

    const double tolerance = 0.25 * scene.bake.tolerance * scene.domain.voxel_size;
    double budget = kShareOfBake * bake_seconds;
    std::vector<std::string> left_out;
    for (std::size_t r = 0; r < receivers.size(); ++r) {
        const Receiver& receiver = receivers[r];
        std::vector<ReceiverPatch> patches;
        double side = 0;
        // What one does not take is the others'.
        Allowance share{budget / static_cast<double>(receivers.size() - r), 0};
        budget -= share.seconds;
        for (const Face& face : receiver.faces) {
            side = face.texels.side();
            const double limit = std::max(tolerance, 0.25 * side);
            share.at_least = measured.errors.empty() && patches.empty() ? kFewestStrips : 0;
            const std::vector<PlaneTexels> parts = how == Measure::Wholly ? std::vector<PlaneTexels>{face.texels}
                                                                          : partsOf(scene, face.texels, limit, share);
            for (const PlaneTexels& part : parts) {
                monitor.checkCancelled();
                ReceiverPatch patch{part.columns, part.rows, planeIrradiance(scene, part, limit, monitor), {}};
                lookUp(scene, receiver.name, face, part, seen, patch);
                patches.push_back(std::move(patch));
            }
        }
        budget += share.seconds;
        if (patches.empty()) left_out.push_back(receiver.name);
        const Sums sums = sumsOf(patches);
        if (!(sums.light > 0)) continue;
        measured.errors.push_back({receiver.name, side, sums.apart / sums.light,
                                   std::min(1.0, static_cast<double>(sums.texels) * side * side / receiver.area)});
        measured.patches.push_back(std::move(patches));
    }
    measured.costs_too_much = !left_out.empty();
    if (measured.costs_too_much)
        measured.not_measured = fmt::format(
            "{} would take more than a quarter of the bake's time; --measure all does it", fmt::join(left_out, ", "));
    return measured;
}

double simulatedError(const std::vector<ReceiverPatch>& patches, int texels) {
    Sums sums;
    const int half = texels / 2;
    for (const ReceiverPatch& patch : patches)
        for (const int first : {0, half}) {
            const VoxelMeans means(patch, texels, first, first);
            const int step = texels >= 4 ? 2 : 1;  // rows beside each other are alike then
            for (int j = 0; j < patch.rows; j += step)
                for (int i = 0; i < patch.columns; ++i) {
                    const double truth = double(patch.light[static_cast<std::size_t>(j * patch.columns + i)]);
                    const double found = means.at(i, j);
                    if (truth >= 0 && std::isfinite(found)) sums.add(found, truth);
                }
        }
    return sums.light > 0 ? sums.apart / sums.light : 0;
}

double voxelSizeFor(double goal, const MeasuredReceivers& measured, double voxel_size) {
    double smallest = 0;
    for (std::size_t r = 0; r < measured.errors.size(); ++r) {
        const ReceiverError& error = measured.errors[r];
        if (error.relative_l1 <= goal) continue;
        const double now = std::max(1.0, voxel_size / error.detail);
        // How much the simulation is off where the error is known stays alike.
        const double simulated = simulatedError(measured.patches[r], std::max(1, static_cast<int>(std::lround(now))));
        const double factor = simulated > 0 ? error.relative_l1 / simulated : 1;
        double wider = now, wider_error = error.relative_l1, fits = 0;
        for (const int texels : {96, 64, 48, 32, 24, 16, 12, 8, 6, 4, 3, 2}) {
            if (texels >= now) continue;
            const double narrower_error = factor * simulatedError(measured.patches[r], texels);
            if (narrower_error <= goal) {
                // Between the two as a power of the voxel size.
                const double power = std::log(wider_error / std::max(narrower_error, 1e-9)) / std::log(wider / texels);
                fits = power > 0 ? texels * std::pow(goal / std::max(narrower_error, 1e-9), 1 / power) : texels;
                break;
            }
            wider = texels, wider_error = narrower_error;
        }
        // Light known by the texel tells nothing of voxels as narrow: the error falls with the voxel at least.
        if (fits == 0) fits = voxel_size / error.detail * goal / error.relative_l1;
        const double size = fits * error.detail;
        smallest = smallest == 0 ? size : std::min(smallest, size);
    }
    return smallest;
}

}  // namespace photic
