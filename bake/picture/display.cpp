// SPDX-License-Identifier: Apache-2.0
#include "bake/picture/display.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/common.hpp>

#include "bake/picture/text.h"
#include "bake/report/error.h"

namespace photic {

namespace {

constexpr glm::dvec3 kPaper{0.11, 0.12, 0.13};  // behind film strips and colour bars
constexpr glm::dvec3 kInk{0.92, 0.93, 0.94};

Image displayImage(int width, int height, const glm::dvec3& fill) {
    Image image{width, height, 3, {}};
    image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = static_cast<float>(fill[static_cast<int>(i % 3)]);
    return image;
}

void put(Image& image, int x, int y, const glm::dvec3& colour) {
    for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(colour[c]);
}

/// Copies a display image into another, clipped to it.
void paste(Image& target, const Image& source, int left, int top) {
    for (int y = 0; y < std::min(source.height, target.height - top); ++y) {
        for (int x = 0; x < std::min(source.width, target.width - left); ++x) {
            for (int c = 0; c < 3; ++c)
                target.at(left + x, top + y, c) = source.at(x, y, std::min(c, source.channels - 1));
        }
    }
}

glm::dvec3 pixelAt(const Image& image, int x, int y) {
    if (image.channels < 3) return glm::dvec3(static_cast<double>(image.at(x, y, 0)));
    return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2)};
}

glm::dvec3 mapColour(ColourMap map, double value) {
    const auto c = colourOf(map, value);
    return {c[0], c[1], c[2]};
}

}  // namespace

double encodeSrgb(double linear) {
    const double v = std::clamp(linear, 0.0, 1.0);
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

double pixelMean(const Image& image, int x, int y) {
    if (image.channels < 3) return static_cast<double>(image.at(x, y, 0));
    const glm::dvec3 c = pixelAt(image, x, y);
    return (c.x + c.y + c.z) / 3;
}

double percentile(const Image& image, double fraction) {
    std::vector<double> values;
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            if (image.channels == 4 && image.at(x, y, 3) <= 0) continue;
            values.push_back(pixelMean(image, x, y));
        }
    }
    if (values.empty()) return 0;
    const auto rank =
        static_cast<std::ptrdiff_t>(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + rank, values.end());
    return values[static_cast<std::size_t>(rank)];
}

double niceCeiling(double value) {
    if (!(value > 0) || !std::isfinite(value)) return 1;
    const double decade = std::pow(10, std::floor(std::log10(value)));
    for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0}) {
        if (value <= step * decade * (1 + 1e-9)) return step * decade;
    }
    return 10 * decade;
}

Image displayLinear(const Image& image, double white) {
    Image out = displayImage(image.width, image.height, {});
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const glm::dvec3 v = pixelAt(image, x, y) / white;
            put(out, x, y, {encodeSrgb(v.x), encodeSrgb(v.y), encodeSrgb(v.z)});
        }
    }
    return out;
}

Image displayFilmic(const Image& radiance, double exposure) {
    const auto filmic = [](double x) { return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14); };
    Image out = displayImage(radiance.width, radiance.height, {});
    for (int y = 0; y < radiance.height; ++y) {
        const double down = (y + 0.5) / radiance.height;
        const glm::dvec3 background = glm::mix(glm::dvec3(0.20, 0.23, 0.27), glm::dvec3(0.07, 0.08, 0.10), down);
        for (int x = 0; x < radiance.width; ++x) {
            const glm::dvec3 v = glm::max(pixelAt(radiance, x, y), glm::dvec3(0)) * exposure;
            const double alpha = radiance.channels == 4 ? static_cast<double>(radiance.at(x, y, 3)) : 1.0;
            // Colour is premultiplied by alpha: undo it for the curve, and lay the result over the background.
            const glm::dvec3 full = alpha > 0 ? v / alpha : glm::dvec3(0);
            const glm::dvec3 shown{encodeSrgb(filmic(full.x)), encodeSrgb(filmic(full.y)), encodeSrgb(filmic(full.z))};
            put(out, x, y, glm::mix(background, shown, alpha));
        }
    }
    return out;
}

Image displayMapped(const Image& image, ColourMap map, double min, double max, const std::string& unit) {
    const int scale = std::max(1, image.height / 300);
    const int margin = 8 * scale, bar_width = 14 * scale;
    const int top = 22 * scale;
    const int bar_height = std::max(8, image.height - top - margin);
    // Labels at 0, 1/5 ... 1 of the range.
    std::vector<std::string> labels;
    int label_width = textWidth(unit, scale);
    for (int tick = 0; tick <= 5; ++tick) {
        labels.push_back(fmt::format("{:.4g}", min + (max - min) * tick / 5));
        label_width = std::max(label_width, bar_width + 6 * scale + textWidth(labels.back(), scale));
    }
    Image out = displayImage(image.width + 2 * margin + label_width, image.height, kPaper);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x)
            put(out, x, y, mapColour(map, (pixelMean(image, x, y) - min) / (max - min)));
    }
    const int left = image.width + margin;
    for (int y = 0; y < bar_height; ++y) {
        const glm::dvec3 colour = mapColour(map, 1 - (y + 0.5) / bar_height);
        for (int x = 0; x < bar_width; ++x) {
            if (top + y < out.height) put(out, left + x, top + y, colour);
        }
    }
    drawText(out, left, 5 * scale, unit, scale, kInk);
    for (int tick = 0; tick <= 5; ++tick) {
        const int y = top + static_cast<int>(std::lround((1 - tick / 5.0) * (bar_height - 1)));
        for (int x = 0; x < 3 * scale; ++x) {
            if (y < out.height) put(out, left + bar_width + x, y, kInk);
        }
        // Text hangs from its top: raise it by half a capital's height, and keep it inside.
        const int text_y = std::clamp(y - 4 * scale, 0, std::max(0, out.height - 10 * scale));
        drawText(out, left + bar_width + 5 * scale, text_y, labels[static_cast<std::size_t>(tick)], scale, kInk);
    }
    return out;
}

Image enlarge(const Image& image, int pixels, double aspect) {
    const int shorter = std::max(1, std::min(image.width, static_cast<int>(std::lround(image.height * aspect))));
    const int longer = std::max(image.width, static_cast<int>(std::lround(image.height * aspect)));
    const int factor = std::max(1, std::min((pixels + shorter - 1) / shorter, 4 * pixels / std::max(1, longer)));
    const int width = image.width * factor;
    const int height = std::max(1, static_cast<int>(std::lround(image.height * factor * aspect)));
    Image out{width, height, image.channels, {}};
    out.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                      static_cast<std::size_t>(image.channels));
    for (int y = 0; y < height; ++y) {
        const int from_y = std::min(image.height - 1, static_cast<int>((y + 0.5) / height * image.height));
        for (int x = 0; x < width; ++x) {
            for (int c = 0; c < image.channels; ++c) out.at(x, y, c) = image.at(x / factor, from_y, c);
        }
    }
    return out;
}

Image filmStrip(const std::vector<Image>& pictures, const std::vector<std::string>& captions, int columns) {
    if (pictures.empty()) throw Error(ErrorCode::Input, "a film strip needs at least one picture");
    const int count = static_cast<int>(pictures.size());
    columns = std::clamp(columns, 1, count);
    const int rows = (count + columns - 1) / columns;
    int cell_width = 0, cell_height = 0;
    for (const Image& p : pictures)
        cell_width = std::max(cell_width, p.width), cell_height = std::max(cell_height, p.height);
    const int scale = std::max(1, cell_height / 300), gap = 6 * scale, line = 14 * scale;
    Image out = displayImage(columns * (cell_width + gap) + gap, rows * (cell_height + line + gap) + gap, kPaper);
    for (int i = 0; i < count; ++i) {
        const int left = gap + i % columns * (cell_width + gap), top = gap + i / columns * (cell_height + line + gap);
        const auto index = static_cast<std::size_t>(i);
        paste(out, pictures[index], left, top);
        if (index < captions.size()) drawText(out, left, top + cell_height + 4 * scale, captions[index], scale, kInk);
    }
    return out;
}

}  // namespace photic
