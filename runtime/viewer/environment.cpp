// SPDX-License-Identifier: Apache-2.0
#include "runtime/viewer/environment.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <numbers>

#include "bake/image/image.h"
#include "bake/report/error.h"

namespace photic::viewer {
namespace {

constexpr double kPi = std::numbers::pi;

/// 1 within a window of directions, with soft edges [degrees].
double window(double azimuth, double height, double at_azimuth, double at_height, double half_width,
              double half_height) {
    constexpr double kSoft = 1.2;
    double across = std::fabs(azimuth - at_azimuth);
    across = std::min(across, 360 - across);
    const double x = std::clamp((half_width - across) / kSoft + 0.5, 0.0, 1.0),
                 y = std::clamp((half_height - std::fabs(height - at_height)) / kSoft + 0.5, 0.0, 1.0);
    return x * y;
}

/// A shelf of books around the room: colours and heights by their number.
glm::dvec3 books(double azimuth, double height) {
    const double place = azimuth / 3.0, number = std::floor(place), within = place - number;
    const auto random = [&](double salt) {
        const double v = std::sin(number * 12.9898 + salt * 78.233) * 43758.5453;
        return v - std::floor(v);
    };
    const double shelf = height < 0 ? -12 : 1, tall = 9 + 3 * random(1 + shelf);
    if (height < shelf || height > shelf + tall || within < 0.06) return glm::dvec3(0.03);
    const double hue = random(2 + shelf);
    const glm::dvec3 colour =
        glm::clamp(glm::abs(glm::fract(glm::dvec3(hue, hue + 2.0 / 3, hue + 1.0 / 3)) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    return 0.06 + glm::mix(glm::dvec3(0.42, 0.38, 0.34), colour, 0.4) * (0.2 + 0.5 * random(3 + shelf));
}

glm::dvec3 studioLight(const glm::dvec3& d) {
    const double height = std::asin(std::clamp(d.z, -1.0, 1.0)) * 180 / kPi;
    double azimuth = std::atan2(d.y, d.x) * 180 / kPi;
    if (azimuth < 0) azimuth += 360;
    glm::dvec3 light = d.z > 0 ? glm::mix(glm::dvec3(0.34, 0.33, 0.36), glm::dvec3(0.16, 0.17, 0.20), d.z)
                               : glm::mix(glm::dvec3(0.20, 0.17, 0.14), glm::dvec3(0.07), -d.z);
    if (height > -13 && height < 14) light = books(azimuth, height);
    light += 9.0 * glm::dvec3(1, 0.96, 0.90) * window(azimuth, height, 130, 44, 24, 15);  // the key light
    light += 5.0 * glm::dvec3(0.70, 0.85, 1) * window(azimuth, height, 335, 36, 5, 26);   // a strip of daylight
    light += 5.0 * glm::dvec3(1, 0.80, 0.60) * window(azimuth, height, 232, 30, 4, 18);   // and one of a lamp
    light += 3.0 * glm::dvec3(1) * window(azimuth, height, 60, 72, 40, 7);                // the ceiling's
    return light;
}

}  // namespace

double Environment::irradiance() const {
    double sum = 0;
    for (int y = height / 2; y < height; ++y) {
        const double up = ((y + 0.5) / height - 0.5) * kPi;
        double row = 0;
        for (int x = 0; x < width; ++x) {
            const float* p = &pixels[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                          static_cast<std::size_t>(x))];
            row += (double(p[0]) + double(p[1]) + double(p[2])) / 3;
        }
        sum += row / width * 2 * kPi * std::cos(up) * std::sin(up) * kPi / height;
    }
    return sum;
}

Environment studio() {
    Environment out{1024, 512, {}};
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            const double up = ((y + 0.5) / out.height - 0.5) * kPi, turn = (0.5 - (x + 0.5) / out.width) * 2 * kPi;
            const glm::dvec3 light =
                studioLight({std::cos(up) * std::cos(turn), std::cos(up) * std::sin(turn), std::sin(up)});
            for (int c = 0; c < 3; ++c) out.pixels.push_back(static_cast<float>(light[c]));
            out.pixels.push_back(1);
        }
    return out;
}

Environment loadEnvironment(const std::string& path) {
    const Image image = readExr(path);
    if (image.width < 2 || image.height < 2)
        throw Error(ErrorCode::Input, "an environment has at least 2 x 2 pixels", path);
    Environment out{image.width, image.height, {}};
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            for (int c = 0; c < 4; ++c) {
                const float value = c < 3 ? image.at(x, image.height - 1 - y, std::min(c, image.channels - 1)) : 1.0f;
                if (!std::isfinite(value))
                    throw Error(ErrorCode::Input, "a pixel of the environment is no number", path);
                out.pixels.push_back(std::clamp(value, 0.0f, 60000.0f));
            }
    return out;
}

}  // namespace photic::viewer
