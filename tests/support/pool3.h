// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace photic::truth {

/// A square map of pixel averages over |x|, |y| <= 1 m, row 0 at y = -1, x fastest.
struct FloorMap {
    int size = 0;
    std::vector<double> values;  ///< irradiance on the horizontal plane, sun of 1 W/m2 across its beam
    double at(int x, int y) const { return values[static_cast<std::size_t>(y) * size + x]; }
};

/// The focused pool of tests/data/README.md: three waves, sun 30 degrees from the zenith, floor at z = -1.5 m.
namespace pool3 {

inline constexpr double kFloor = -1.5;
inline constexpr double kIor = 1.333;

/// Surface height and slopes [m, 1, 1].
glm::dvec3 surface(double x, double y);
/// Direction of travel of the sun, unit.
glm::dvec3 sun();

/// The exact floor map, 512 x 512, from tests/data; exact to 3e-5 relative L1.
FloorMap exactFloor();
/// The floor under a sun of 0.53 degrees: the mean of 512 directions that share its disc equally. From tests/data.
FloorMap exactDiscFloor();

/// The floor from 2 mesh^2 surface triangles over [-2, 2]^2: vertices traced exactly, landing triangles clipped exactly
/// to the pixels. Shares no code with the baker.
FloorMap traceFloor(int mesh, int pixels, const glm::dvec3& direction);

/// Directions that share the disc of a sun equally (a Vogel spiral about `axis`), unit.
std::vector<glm::dvec3> discDirections(const glm::dvec3& axis, double angular_diameter_deg, int count);

/// A scene file of this pool.
struct SceneText {
    double voxel_size = 2.0 / 128;  ///< [m]
    double layer_height = 0;        ///< [m]; 0: voxel_size
    double z_min = kFloor, z_max = 0.08;
    double angular_diameter_deg = 0;
    std::string shear = "none";  ///< as in the file
    std::string bake;            ///< lines below [bake]
    std::string beams;           ///< lines below [bake.beams]
    std::string objects;         ///< further tables
    double irradiance = 1;       ///< [W/m2]
    glm::dvec2 half{1, 1};       ///< the domain is [-half.x, half.x] x [-half.y, half.y] [m]
};
std::string sceneToml(const SceneText& text);

}  // namespace pool3

/// mean |a - r| / mean r.
double relativeL1(const std::vector<double>& a, const std::vector<double>& reference);
/// sqrt(mean (a - r)^2) / mean r.
double relativeRmse(const std::vector<double>& a, const std::vector<double>& reference);

}  // namespace photic::truth
