// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/shadowed_patch.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "bake/optics/tangent_frame.h"

namespace photic {
namespace {

// Of the way from a lamp: what stands nearer to it is as good as in it.
constexpr double kNearest = 1e-6;
// Of the patch: what is smaller is rounding.
constexpr double kSliver = 1e-9;
// A patch in so many pieces lies behind lace: it is left open.
constexpr std::size_t kMostPieces = 256;
// Of their distance from the patch's middle: corners nearer to one another are one.
constexpr double kSameCorner = 1e-12;

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

}  // namespace

void ShadowedPatch::Piece::add(const glm::dvec2& point) {
    if (count > 0) {
        const glm::dvec2 off = glm::abs(point - points[count - 1]), size = glm::abs(point);
        if (std::max(off.x, off.y) <= kSameCorner * std::max(size.x, size.y)) return;
    }
    if (count < kMost)
        points[count++] = point;
    else
        overfull = true;
}

double ShadowedPatch::Piece::area() const {
    double area = 0;
    for (std::size_t i = 1; i + 1 < count; ++i) area += 0.5 * cross(points[i] - points[0], points[i + 1] - points[0]);
    return area;
}

ShadowedPatch::Piece ShadowedPatch::Piece::left(const glm::dvec2& a, const glm::dvec2& b) const {
    Piece out;
    const glm::dvec2 line = b - a;
    double d = count > 0 ? cross(line, points[0] - a) : 0;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec2 &p = points[i], &q = points[i + 1 == count ? 0 : i + 1];
        const double next = cross(line, q - a);
        if (d >= 0) out.add(p);
        if ((d > 0 && next < 0) || (d < 0 && next > 0)) out.add(p + (d / (d - next)) * (q - p));
        d = next;
    }
    return out;
}

void ShadowedPatch::Piece::findBounds() {
    low = high = points[0];
    for (std::size_t i = 1; i < count; ++i) low = glm::min(low, points[i]), high = glm::max(high, points[i]);
}

ShadowedPatch::ShadowedPatch(const Corners& patch, const Corners& from, const glm::dvec3& direction,
                             const std::optional<glm::dvec3>& source)
    : middle_(0.25 * (patch[0] + patch[1] + patch[2] + patch[3])), direction_(direction), source_(source) {
    const TangentFrame frame(direction);
    across_ = frame.across, up_ = frame.up;
    begin_ = end_ = glm::dot(from[0], direction);
    for (const glm::dvec3& p : from) begin_ = std::min(begin_, glm::dot(p, direction));
    for (const glm::dvec3& p : patch) end_ = std::max(end_, glm::dot(p, direction));
    if (source) {
        const double at = glm::dot(*source, direction);
        begin_ = std::max(begin_, at + kNearest * (glm::dot(middle_, direction) - at));
    }
    Piece whole;
    for (const glm::dvec3& corner : patch)
        if (const auto point = seen(corner)) whole.add(*point);
    if (whole.count < 4) return;
    if (whole.area() < 0) std::reverse(whole.points.begin(), whole.points.begin() + 4);
    area_ = open_area_ = whole.area();
    whole.findBounds();
    open_.push_back(whole);
}

// Where the light sees a point, in the plane of the patch's middle; nothing beside a lamp or behind it.
std::optional<glm::dvec2> ShadowedPatch::seen(const glm::dvec3& point) const {
    glm::dvec3 at = point;
    if (source_) {
        const double whole_way = glm::dot(middle_ - *source_, direction_), way = glm::dot(point - *source_, direction_);
        if (!(way > 0.5 * kNearest * whole_way)) return std::nullopt;
        at = *source_ + (whole_way / way) * (point - *source_);
    }
    return glm::dvec2(glm::dot(at - middle_, across_), glm::dot(at - middle_, up_));
}

// Of the part of a triangle that stands between the light and the patch.
std::optional<ShadowedPatch::Piece> ShadowedPatch::shadowOf(const std::array<glm::dvec3, 3>& triangle) const {
    // Cut at the beginning and at the end.
    std::array<glm::dvec3, 5> corners = {triangle[0], triangle[1], triangle[2]};
    std::size_t count = 3;
    const double at[3] = {glm::dot(triangle[0], direction_), glm::dot(triangle[1], direction_),
                          glm::dot(triangle[2], direction_)};
    const double first = std::min({at[0], at[1], at[2]}), last = std::max({at[0], at[1], at[2]});
    for (const double sense : {1.0, -1.0}) {
        if (sense > 0 ? first >= begin_ : last <= end_) continue;
        const auto inside = [&](const glm::dvec3& p) {
            return sense * (glm::dot(p, direction_) - (sense > 0 ? begin_ : end_));
        };
        std::array<glm::dvec3, 5> out;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::dvec3 &a = corners[i], &b = corners[i + 1 == count ? 0 : i + 1];
            const double da = inside(a), db = inside(b);
            if (da >= 0) out[kept++] = a;
            if ((da > 0 && db < 0) || (da < 0 && db > 0)) out[kept++] = a + (da / (da - db)) * (b - a);
        }
        corners = out, count = kept;
    }
    Piece shadow;
    for (std::size_t i = 0; i < count; ++i) {
        const auto point = seen(corners[i]);
        if (!point) return std::nullopt;
        shadow.add(*point);
    }
    const double area = shadow.area();
    if (!(std::fabs(area) > kSliver * area_)) return std::nullopt;
    if (area < 0)
        std::reverse(shadow.points.begin(), shadow.points.begin() + static_cast<std::ptrdiff_t>(shadow.count));
    shadow.findBounds();
    return shadow;
}

void ShadowedPatch::keep(const Piece& piece) {
    const double open = piece.area();
    if (!(open > kSliver * area_)) return;
    open_area_ += open;
    open_.push_back(piece);
    open_.back().findBounds();
}

void ShadowedPatch::shade(const std::array<glm::dvec3, 3>& triangle) {
    if (open_.empty() || open_.size() > kMostPieces) return;
    const std::optional<Piece> shadow = shadowOf(triangle);
    if (!shadow) return;
    // From the last piece on: what takes a piece's place has been looked at.
    for (std::size_t i = open_.size(); i-- > 0;) {
        if (open_[i].count + shadow->count > Piece::kMost || open_[i].isBeside(*shadow)) continue;
        // Beyond each side of the shadow in turn lies a convex part that stays open; what is left after all is shaded.
        Piece within = open_[i], beyond[5];
        bool overfull = false;
        for (std::size_t k = 0; k < shadow->count; ++k) {
            const glm::dvec2 &a = shadow->points[k], &b = shadow->points[k + 1 == shadow->count ? 0 : k + 1];
            beyond[k] = within.left(b, a), within = within.left(a, b);
            overfull = overfull || beyond[k].overfull || within.overfull;
        }
        if (overfull || !(within.area() > kSliver * area_)) continue;
        shaded_ = true;
        open_area_ -= open_[i].area();
        open_[i] = open_.back(), open_.pop_back();
        for (std::size_t k = 0; k < shadow->count; ++k) keep(beyond[k]);
    }
}

}  // namespace photic
