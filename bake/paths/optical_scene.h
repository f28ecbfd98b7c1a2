// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "bake/paths/light_end.h"
#include "bake/paths/own_shadow.h"
#include "bake/paths/path.h"
#include "bake/paths/ray_casting.h"
#include "bake/paths/scene_shapes.h"
#include "bake/paths/specular_event.h"
#include "bake/report/bake_report.h"
#include "bake/scene/scene.h"

namespace photic {

/// What fills a part of space, as light sees it.
struct OpticalMedium {
    std::vector<double> iors;                 ///< at each of the scene's wavelengths
    glm::dvec3 absorption{0}, scattering{0};  ///< per channel [1/m]
    double anisotropy = 0;                    ///< Henyey-Greenstein g
    int priority = 0;
    bool disperses = false;
    glm::dvec3 extinction() const { return absorption + scattering; }
    bool clear() const { return extinction() == glm::dvec3(0); }
};

/// The media on either side of a surface, in OpticalScene::media.
struct MediumSides {
    int outside = 0;  ///< on the side of the normal: above
    int inside = 0;
    bool nested = false;  ///< a closed surface with a named inside: overlaps are decided by priority
};

/// Where a leg comes to a specular surface.
struct Meeting {
    glm::dvec3 position{0};
    glm::dvec3 normal{0}, face{0};  ///< unit: smooth, and geometric; on the side of ior_above
};

/// Shares the power of a leg out between the medium that it runs through and what is at its end (Beer-Lambert).
/// @param power   at the leg's start, per channel [W]
/// @param length  [m]
/// @param end     the term of the ledger that what is left belongs to
/// @return what is left, per channel [W]
glm::dvec3 countLeg(const OpticalMedium& medium, const glm::dvec3& power, double length, double PowerLedger::*end,
                    PowerLedger& ledger);

/// Mean of the channels: what the ledgers count.
inline double channelMean(const glm::dvec3& power) { return (power.x + power.y + power.z) / 3; }

/// Whether legs can meet water that stands alone: they leave it, and need not be held against it, but where light comes
/// from beyond it.
enum class LoneWater { IsLeft, IsMet };

/// A scene as every tracer sees it: what stands in it, where deposits end in the grid, and what lies on either side of
/// each surface. Shared by all lights of a bake. Thread-safe.
class OpticalScene {
public:
    /// @param wavelengths_nm  at which light is traced where media disperse; index 0 is always white light
    /// @param behind_walls    of LightEnd
    OpticalScene(const Scene& scene, const GridFrame& frame, const std::vector<double>& wavelengths_nm = {},
                 double behind_walls = 0, LoneWater lone_water = LoneWater::IsLeft);

    const Scene& scene() const { return scene_; }
    const GridFrame& frame() const { return frame_; }
    const RayCaster& caster() const { return shapes_->caster; }
    const LightEnd& lightEnd() const { return light_end_; }
    const TriangleTree& tree() const { return shapes_->tree; }
    const OpticalMedium& medium(int index) const { return media_[static_cast<std::size_t>(index)]; }
    int mediumCount() const { return static_cast<int>(media_.size()); }
    /// What the scene says of a medium.
    const Medium& given(int index) const { return given_media_[static_cast<std::size_t>(index)]; }
    const MediumSides& sides(int surface) const { return sides_[static_cast<std::size_t>(surface)]; }
    /// Sides of the box around a surface's mesh [m]; 0 of height fields.
    const glm::dvec3& boxOf(int surface) const { return boxes_[static_cast<std::size_t>(surface)]; }
    /// Whether light of different wavelengths parts at a surface.
    bool disperses(int surface) const {
        return medium(sides(surface).inside).disperses || medium(sides(surface).outside).disperses;
    }

    /// The shadow of a surface's waves on itself; null where none of the scene's light comes so low.
    const OwnShadow* ownShadow(int surface) const {
        const auto& shadow = own_shadows_[static_cast<std::size_t>(surface)];
        return shadow ? &*shadow : nullptr;
    }

    /// What light meets first on its way to a point of a surface: `Lit` when that is the surface.
    ///
    /// An endless plane hides a sun's disc whole or not at all, as it hides the disc's middle. By the letter a pool's
    /// wall below a sun at its zenith would hide half of the disc however high it ends above the water, and four of
    /// them all of it.
    /// @param direction  unit, of travel
    /// @param source     [m] where the light stands; none for a sun
    PathOutcome arrival(const glm::dvec3& point, const glm::dvec3& direction,
                        const std::optional<glm::dvec3>& source = std::nullopt) const;
    /// The same for a point of a surface that may stand in its own light.
    PathOutcome arrivalOn(int surface, const glm::dvec3& point, const glm::dvec3& direction,
                          const std::optional<glm::dvec3>& source = std::nullopt) const;

    /// The middle of the sun whose disc a direction belongs to, where a plane parts that disc; null elsewhere.
    const glm::dvec3* partedSun(const glm::dvec3& direction) const;

    /// First hit with everything, height fields included. @param meeting  where a surface is hit
    RayHit firstHit(const glm::dvec3& origin, const glm::dvec3& direction, double max_distance, Meeting& meeting,
                    EndlessPlanes planes = EndlessPlanes::Met) const;

    /// Whether planes or height fields stand in the scene, which may be met far from all bodies.
    bool standsEndless() const { return caster().hasPlanes() || !height_fields_.empty(); }

    /// What light is in that comes from a lamp or a sun to its first surface.
    /// @param face    geometric normal of the surface, on the side of ior_above
    /// @param source  [m] where the light stands; none for a sun
    MediumStack startingInside(int surface, const glm::dvec3& direction, const glm::dvec3& face,
                               const std::optional<glm::dvec3>& source = std::nullopt) const;
    /// What a lamp's own medium leaves of its light before the first surface, per channel. A sun comes from outside.
    glm::dvec3 leftOnTheWay(const MediumStack& inside, double distance) const {
        return glm::exp(-medium(mediumOf(inside)).extinction() * distance);
    }
    /// The medium that is really there.
    int mediumOf(const MediumStack& inside) const;
    /// The stack on the other side of a surface. @param inwards  against the surface's normal
    MediumStack across(const MediumStack& inside, int surface, bool inwards) const;

    /// What becomes of light at a surface that it meets; nothing where the surface parts nothing (a lower priority).
    struct Event {
        SpecularEvent light;
        MediumStack beyond;
        bool void_surface = false;  ///< light goes on as it came, with the stack `beyond`
    };
    Event eventAt(int surface, int wavelength, const MediumStack& inside, const glm::dvec3& direction,
                  const Meeting& at) const {
        const auto index = static_cast<std::size_t>(wavelength);
        return eventBetween(surface, inside, direction, at, [&](int m) { return medium(m).iors[index]; });
    }
    /// The same between media of which each says what its index is at the place.
    /// @param ior_of  of a medium's place in `media`
    template <class IorOf>
    Event eventBetween(int surface, const MediumStack& inside, const glm::dvec3& direction, const Meeting& at,
                       const IorOf& ior_of) const;

    /// Casts a leg and finds where its deposit ends. Surfaces that part nothing are passed.
    struct LegEnd {
        RayHit hit;
        double deposit_end;  ///< [m]; infinity without a hit
        Meeting meeting;     ///< when a specular surface is hit
        MediumStack inside;  ///< at the end
    };
    LegEnd legEnd(const glm::dvec3& origin, const glm::dvec3& direction, const MediumStack& inside) const;

private:
    int mediumFor(const Medium& medium, const std::vector<double>& wavelengths_nm);
    Meeting meetingOnMesh(const Surface& surface, const RayHit& hit, const glm::dvec3& point) const;
    int waterAround(const glm::dvec3& source) const;

    const Scene& scene_;
    GridFrame frame_;
    std::shared_ptr<const SceneShapes> shapes_;
    LightEnd light_end_;
    std::vector<OpticalMedium> media_;
    std::vector<Medium> given_media_;
    std::vector<MediumSides> sides_;
    std::vector<glm::dvec3> boxes_;
    std::vector<int> height_fields_;  // that legs can meet
    std::vector<std::optional<OwnShadow>> own_shadows_;
    struct PartedSun {
        glm::dvec3 middle{0};
        double radius = 0;
    };
    std::vector<PartedSun> parted_suns_;
    std::vector<int> waters_;  // of each light of the scene: the medium of the height field above it, or -1
};

template <class IorOf>
OpticalScene::Event OpticalScene::eventBetween(int surface, const MediumStack& inside, const glm::dvec3& direction,
                                               const Meeting& at, const IorOf& ior_of) const {
    const Surface& s = scene_.surfaces[static_cast<std::size_t>(surface)];
    const bool inwards = glm::dot(direction, at.face) < 0;
    Event event;
    if (s.thin) {
        event.beyond = inside;
        const double pane = ior_of(sides(surface).inside);
        event.light = specularEvent(s, ior_of(mediumOf(inside)), pane, direction, at.normal, at.face);
        return event;
    }
    event.beyond = across(inside, surface, inwards);
    // Inside of a body of a higher priority the water's surface, say, parts nothing.
    const int from = mediumOf(inside), to = mediumOf(event.beyond);
    event.void_surface = s.event != SurfaceEvent::Mirror && from == to && (sides(surface).nested || inside.count > 0);
    if (event.void_surface) return event;
    event.light = specularEvent(s, ior_of(from), ior_of(to), direction, at.normal, at.face);
    return event;
}

}  // namespace photic
