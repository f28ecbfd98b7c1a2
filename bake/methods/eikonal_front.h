// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "bake/field/light_field.h"
#include "bake/methods/eikonal.h"
#include "bake/numerics/foot_point.h"
#include "bake/scene/scene.h"

namespace photic {

/// A rectangle of the horizontal plane [m].
struct Rectangle {
    glm::dvec2 low{0}, high{0};
};

/// The one light and the one surface of a scene, as a front that enters the water.
class EikonalFront {
public:
    /// @throws Error{Input} when the surface folds over itself
    EikonalFront(const Scene& scene, const EikonalOptions& options, const GridFrame& frame);

    const Light& light() const { return *light_; }
    const Surface& surface() const { return *surface_; }
    const HeightTable& table() const { return *table_; }
    bool infiniteIndex() const { return infinite_; }
    FrontOnSurface front() const;
    /// n below the surface; 1 when the index is infinite; the mean over the surface where it varies.
    double slowness() const { return slowness_; }
    /// The index below, where it varies; otherwise null.
    const IndexVolume* index() const { return index_; }
    /// n below the surface at a place.
    double slownessAt(const glm::dvec3& place) const;
    /// Where first arrivals in the grid may have left the surface; where the index varies, widened for rays that bend.
    const Rectangle& reach() const { return reach_; }

    /// Irradiance across the ray just below the surface at `foot`, in units of the light's, from the slopes of the
    /// surface there and the unit direction of travel below: T cos(i) / cos(t), and a point's 1 / r^2.
    double entering(const glm::dvec3& foot, double slope_x, double slope_y, const glm::dvec3& direction) const;

private:
    const Light* light_;
    const Surface* surface_;
    const IndexVolume* index_;
    bool infinite_;
    Rectangle reach_;
    double slowness_;
    std::unique_ptr<HeightTable> table_;
};

/// Where rays have been through a focus, layer by layer: the voxels that more than one arrival reaches.
class CausticMap {
public:
    /// @param spacing  of the rays on the surface [m]
    CausticMap(const EikonalFront& front, double spacing);
    /// Marks the cells of a layer at height z: cell (i, j) is centred at corner + (i step_x, j step_y).
    void layer(double z, glm::dvec2 corner, glm::dvec2 step, int count_x, int count_y,
               std::vector<std::uint8_t>& marks) const;
    /// Height of the highest focus [m]; -infinity when there is none.
    double highestFocus() const { return highest_; }

private:
    struct Ray {
        glm::dvec3 focus;  ///< where it is first met
        glm::dvec2 slope;  ///< horizontal run per metre down
    };
    std::vector<Ray> rays_;
    double highest_;
};

/// What a solver fills: the field always has irradiance and flux, so that direction can be told.
struct EikonalFields {
    LightField light;                    ///< [W/m2], of the first arrival
    std::optional<LightField> caustic;   ///< curvature [1/m]
    std::optional<LightField> arrival;   ///< [m]
    std::int64_t single = 0, below = 0;  ///< needed voxels with one arrival, and below the surface
    double solver_bytes = 0;             ///< memory of the solver, beside the fields
};

/// What a solver bakes.
struct EikonalBake {
    const Scene& scene;
    const EikonalFront& front;
    const EikonalOptions& options;
    Monitor& monitor;
};

/// Fills the fields by foot points, layer by layer from above; stops below the last needed voxel.
/// @param caustics  null where nobody asks how many arrivals there are
void bakeByFootPoints(const EikonalBake& bake, const CausticMap* caustics, EikonalFields& fields);

/// The same by marching on a cubic grid without shear: seeds two and a half cells deep below the surface and beyond the
/// sides come from the foot points (or, in the paper's preset, from vertices and its costs at the sides).
void bakeByMarching(const EikonalBake& bake, EikonalFields& fields, BakeReport& report);

}  // namespace photic
