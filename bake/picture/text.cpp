// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/text.h"

#include <stb/stb_easy_font.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace photic {

namespace {

/// As stb_easy_font_print writes it.
struct FontVertex {
    float x, y, z;
    unsigned char colour[4];
};

std::string ascii(const std::string& text) {
    std::string out = text;
    std::replace_if(
        out.begin(), out.end(), [](char c) { return c < 32 || c > 126; }, '?');
    return out;
}

}  // namespace

void drawText(Image& image, int x, int y, const std::string& text, int scale, const glm::dvec3& colour) {
    std::string line = ascii(text);
    // The library's own bound: about 270 bytes a character.
    std::vector<FontVertex> vertices((line.size() + 1) * 300 / sizeof(FontVertex) + 4);
    const int quads = stb_easy_font_print(0, 0, line.data(), nullptr, vertices.data(),
                                          static_cast<int>(vertices.size() * sizeof(FontVertex)));
    for (std::size_t quad = 0; quad < static_cast<std::size_t>(quads); ++quad) {
        const FontVertex &a = vertices[quad * 4], &b = vertices[quad * 4 + 2];
        const auto pixel = [scale](int start, float dots) {
            return start + static_cast<int>(std::lround(dots * static_cast<float>(scale)));
        };
        for (int py = std::max(0, pixel(y, a.y)); py < std::min(image.height, pixel(y, b.y)); ++py) {
            for (int px = std::max(0, pixel(x, a.x)); px < std::min(image.width, pixel(x, b.x)); ++px) {
                for (int c = 0; c < std::min(3, image.channels); ++c)
                    image.at(px, py, c) = static_cast<float>(colour[c]);
            }
        }
    }
}

int textWidth(const std::string& text, int scale) {
    std::string line = ascii(text);
    return stb_easy_font_width(line.data()) * scale;
}

}  // namespace photic
