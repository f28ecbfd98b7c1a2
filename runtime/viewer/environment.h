// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace photic::viewer {

/// Radiance from all directions by longitude and latitude: Z up, the middle along +x, the left half towards +y; row 0
/// looks down. What glass reflects and bends, and what is seen where nothing stands.
struct Environment {
    int width = 0, height = 0;
    std::vector<float> pixels;  ///< RGBA
    /// What a level receiver gets of it from above, mean of the channels [W/m2 per unit of radiance].
    double irradiance() const;
};

/// A photographer's room: soft boxes, strip lights, a wall of coloured books around, a dark floor.
Environment studio();
/// An EXR, wider than high, as cameras' panoramas are (row 0 of the file looks up). @throws Error{Input}
Environment loadEnvironment(const std::string& path);

}  // namespace photic::viewer
