// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

namespace photic {

/// A patch of four corners as its light sees it, and what of it nothing has shaded yet.
///
/// What stands between is seen along the light's rays, in the plane through the patch's middle across them. Each shade
/// cuts the patch's open pieces along its own sides, so shades that overlap count once: two fences, one behind the
/// other, leave the gaps that both leave.
class ShadowedPatch {
public:
    using Corners = std::array<glm::dvec3, 4>;

    /// @param patch      in order round a convex patch [m]
    /// @param from       where the light comes from to each corner: what stands before counts for nothing
    /// @param direction  unit, of travel at the patch
    /// @param source     [m] where the light stands; none for a sun
    ShadowedPatch(const Corners& patch, const Corners& from, const glm::dvec3& direction,
                  const std::optional<glm::dvec3>& source);

    /// Takes away what a triangle shades.
    void shade(const std::array<glm::dvec3, 3>& triangle);
    /// Whether anything shades any of it.
    bool isShaded() const { return shaded_; }
    /// Of the patch, as the light sees it.
    double openShare() const { return area_ > 0 ? open_area_ / area_ : 0; }
    /// Nothing is open, but for a thousandth in all: rounding along the seams of shades.
    bool dark() const { return !(openShare() > 1e-3); }

private:
    /// Convex, counter-clockwise. A piece of more corners is not cut any more.
    struct Piece {
        static constexpr std::size_t kMost = 14;
        std::array<glm::dvec2, kMost> points;
        std::size_t count = 0;
        /// Where many shades meet in a corner, rounding makes it many: a line through them then cuts more than twice.
        bool overfull = false;
        glm::dvec2 low{0}, high{0};

        /// Nothing for a point that is the last one but for rounding.
        void add(const glm::dvec2& point);
        double area() const;
        /// The part to the left of the line from a to b.
        Piece left(const glm::dvec2& a, const glm::dvec2& b) const;
        void findBounds();
        bool isBeside(const Piece& other) const {
            return high.x <= other.low.x || low.x >= other.high.x || high.y <= other.low.y || low.y >= other.high.y;
        }
    };
    std::optional<glm::dvec2> seen(const glm::dvec3& point) const;
    std::optional<Piece> shadowOf(const std::array<glm::dvec3, 3>& triangle) const;
    void keep(const Piece& piece);

    glm::dvec3 middle_, direction_, across_, up_;
    std::optional<glm::dvec3> source_;
    double begin_ = 0, end_ = 0;  // along the direction [m]
    std::vector<Piece> open_;
    double area_ = 0, open_area_ = 0;
    bool shaded_ = false;
};

}  // namespace photic
