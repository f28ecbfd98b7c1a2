// SPDX-License-Identifier: Apache-2.0
#include "bake/scene/spline_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace photic {
namespace {

/// Samples' widths that a rectangle holds along a side.
int intervals(SampleSite site, int count) { return site == SampleSite::Corners ? count - 1 : count; }

/// Place of sample 0 from the corner [samples].
double firstSample(SampleSite site) { return site == SampleSite::Corners ? 0.0 : 0.5; }

class SplineField final : public HeightField {
public:
    SplineField(const SplineFieldShape& shape, const SampleGrid& heights,
                const std::optional<std::array<SampleGrid, 2>>& displacement)
        : patch_(shape.bounded ? Patch::around(glm::dvec2(shape.center), shape.size, shape.center.z)
                               : Patch::unbounded()),
          center_z_(shape.center.z),
          corner_(glm::dvec2(shape.center) - 0.5 * shape.size),
          samples_per_metre_(glm::dvec2(intervals(shape.site, heights.width), intervals(shape.site, heights.height)) /
                             shape.size),
          first_sample_(firstSample(shape.site)),
          height_(heights, shape.boundary, shape.interpolation) {
        if (displacement)
            for (const SampleGrid& grid : *displacement) moves_.emplace_back(grid, shape.boundary, shape.interpolation);
    }

    SurfacePoint at(glm::dvec2 uv) const override {
        if (!patch_.contains(uv)) return patch_.beyond(uv);
        const glm::dvec2 s = (uv - corner_) * samples_per_metre_ - first_sample_;
        const glm::dvec3 h = perMetre(height_.at(s.x, s.y));
        if (moves_.empty()) return {{uv.x, uv.y, center_z_ + h.x}, {-h.y, -h.z, 1}};
        const glm::dvec3 x = perMetre(moves_[0].at(s.x, s.y)), y = perMetre(moves_[1].at(s.x, s.y));
        return {{uv.x + x.x, uv.y + y.x, center_z_ + h.x},
                {y.y * h.z - h.y * (1 + y.z), h.y * x.z - (1 + x.y) * h.z, (1 + x.y) * (1 + y.z) - y.y * x.z}};
    }

    void row(glm::dvec2 start, double step, std::size_t count, SurfaceRow& out) const override {
        if (!(step > 0)) return HeightField::row(start, step, count, out);
        const RowRange range = rowInside(patch_, start, step, count);
        const std::size_t length = range.last - range.first;
        const Line line = lineOver(start, step, range);
        // Few points over many samples: collapsing the samples between them would not pay.
        if (length > 0 && line.columns > 16 * length) return HeightField::row(start, step, count, out);
        out.resize(count);
        fillBeyond(patch_, start, step, range, out);
        if (length == 0) return;

        const std::size_t first = range.first;
        std::vector<double> x(length);
        for (std::size_t i = 0; i < length; ++i) {
            out.px[first + i] = start.x + step * static_cast<double>(first + i), out.py[first + i] = start.y,
                           out.nz[first + i] = 1;
            x[i] = (out.px[first + i] - corner_.x) * samples_per_metre_.x - first_sample_ -
                   static_cast<double>(line.first_column);
        }
        std::vector<double> scratch(2 * line.columns);
        const auto evaluate = [&](const SplineGrid& grid, const SplineGrid::RowTarget& target) {
            grid.collapse(line.y, line.first_column, line.columns, scratch.data(), scratch.data() + line.columns);
            grid.evaluate(scratch.data(), scratch.data() + line.columns, line.columns, x.data(), length, target);
        };
        const glm::dvec2 scale = samples_per_metre_;
        if (moves_.empty())
            return evaluate(height_, {center_z_, -scale.x, -scale.y, &out.pz[first], &out.nx[first], &out.ny[first]});

        std::vector<double> d(8 * length);
        double *hu = &d[0], *hv = hu + length, *mx = hv + length, *xu = mx + length, *xv = xu + length,
               *my = xv + length, *yu = my + length, *yv = yu + length;
        evaluate(height_, {center_z_, scale.x, scale.y, &out.pz[first], hu, hv});
        evaluate(moves_[0], {0, scale.x, scale.y, mx, xu, xv});
        evaluate(moves_[1], {0, scale.x, scale.y, my, yu, yv});
        for (std::size_t i = 0; i < length; ++i) {
            out.px[first + i] += mx[i], out.py[first + i] += my[i];
            out.nx[first + i] = yu[i] * hv[i] - hu[i] * (1 + yv[i]);
            out.ny[first + i] = hu[i] * xv[i] - (1 + xu[i]) * hv[i];
            out.nz[first + i] = (1 + xu[i]) * (1 + yv[i]) - yu[i] * xv[i];
        }
    }

    double minZ() const override {
        return center_z_ + (patch_.bounded() ? std::min(height_.min(), 0.0) : height_.min());
    }
    double maxZ() const override {
        return center_z_ + (patch_.bounded() ? std::max(height_.max(), 0.0) : height_.max());
    }
    double maxDisplacement() const override {
        double squared = 0;
        for (const SplineGrid& grid : moves_)
            squared += std::pow(std::max(std::fabs(grid.min()), std::fabs(grid.max())), 2);
        return std::sqrt(squared);
    }
    double featureSize() const override {
        const bool flat = height_.min() == height_.max() && moves_.empty();
        return flat ? std::numeric_limits<double>::infinity()
                    : 1 / std::max(samples_per_metre_.x, samples_per_metre_.y);
    }

    bool bounded() const { return patch_.bounded(); }

private:
    /// Columns of samples that a row needs, counted from the unwrapped grid.
    struct Line {
        double y = 0;
        std::int64_t first_column = 0;
        std::size_t columns = 0;
    };

    Line lineOver(glm::dvec2 start, double step, RowRange range) const {
        if (range.first == range.last) return {};
        const auto sample = [&](std::size_t i) {
            return (start.x + step * static_cast<double>(i) - corner_.x) * samples_per_metre_.x - first_sample_;
        };
        auto low = static_cast<std::int64_t>(std::floor(sample(range.first))),
             high = static_cast<std::int64_t>(std::floor(sample(range.last - 1)));
        if (patch_.bounded())
            low = std::max<std::int64_t>(low, -1), high = std::min<std::int64_t>(high, height_.width() - 1);
        return {(start.y - corner_.y) * samples_per_metre_.y - first_sample_, low - 1,
                static_cast<std::size_t>(high - low + 4)};
    }

    /// (value, d/du, d/dv) with derivatives per metre.
    glm::dvec3 perMetre(const SplineGrid::Value& v) const {
        return {v.value, v.dx * samples_per_metre_.x, v.dy * samples_per_metre_.y};
    }

    Patch patch_;
    double center_z_;
    glm::dvec2 corner_, samples_per_metre_;
    double first_sample_;  // [samples] from the corner
    SplineGrid height_;
    std::vector<SplineGrid> moves_;
};

}  // namespace

std::shared_ptr<const HeightField> makeSplineField(const SplineFieldShape& shape, const SampleGrid& heights,
                                                   const std::optional<std::array<SampleGrid, 2>>& displacement) {
    return std::make_shared<SplineField>(shape, heights, displacement);
}

bool isBoundedSpline(const HeightField& field) {
    const auto* spline = dynamic_cast<const SplineField*>(&field);
    return spline && spline->bounded();
}

double leastNormalZ(const HeightField& field, const SplineFieldShape& shape, int width, int height) {
    SurfaceRow row;
    double least = std::numeric_limits<double>::infinity();
    const glm::dvec2 texel = shape.size / glm::dvec2(intervals(shape.site, width), intervals(shape.site, height)),
                     first = glm::dvec2(shape.center) - 0.5 * shape.size + firstSample(shape.site) * texel;
    for (int y = 0; y < height; ++y) {
        field.row({first.x, first.y + y * texel.y}, texel.x, static_cast<std::size_t>(width), row);
        least = std::min(least, *std::min_element(row.nz.begin(), row.nz.end()));
    }
    return least;
}

}  // namespace photic
