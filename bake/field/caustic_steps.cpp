// SPDX-License-Identifier: Apache-2.0
// The steps of [Mercier 2014] on caustic grids.
#include "bake/field/caustic_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <vector>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

constexpr int kSmoothings = 4;  // of the layer that waves start from: lines become three voxels wide

/// One layer of voxels as an image, 0 where nothing is needed.
class LayerImage {
public:
    explicit LayerImage(LightField& field)
        : field_(field), low_(field.frame().min), nx_(field.frame().size().x), ny_(field.frame().size().y) {}

    std::size_t count() const { return static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_); }
    int width() const { return nx_; }
    int height() const { return ny_; }

    void read(int z, std::vector<double>& to) const {
        to.assign(count(), 0.0);
        each(z, [&](int slot, int offset, std::size_t at) {
            if (field_.state(slot) == LeafState::Dense) to[at] = static_cast<double>(field_.dense(slot)[offset]);
            if (field_.state(slot) == LeafState::Constant) to[at] = static_cast<double>(field_.constant(slot)[0]);
        });
    }
    void write(int z, const std::vector<double>& from) {
        each(z, [&](int slot, int offset, std::size_t at) {
            field_.makeDense(slot)[offset] = static_cast<float>(from[at]);
        });
    }

private:
    template <class Body>
    void each(int z, const Body& body) const {
        const NeededVoxels& needed = field_.needed();
        const int leaves_x = ((low_.x + nx_ - 1) >> 3) - (low_.x >> 3) + 1,
                  leaves_y = ((low_.y + ny_ - 1) >> 3) - (low_.y >> 3) + 1;
        parallelFor(std::int64_t(leaves_x) * leaves_y, [&](std::int64_t n) {
            const glm::ivec3 origin(((low_.x >> 3) + static_cast<int>(n) / leaves_y) * 8,
                                    ((low_.y >> 3) + static_cast<int>(n) % leaves_y) * 8, z & ~7);
            const int slot = needed.slotOf({std::max(origin.x, low_.x), std::max(origin.y, low_.y), z});
            if (slot < 0) return;
            for (int x = std::max(origin.x, low_.x); x < std::min(origin.x + 8, low_.x + nx_); ++x)
                for (int y = std::max(origin.y, low_.y); y < std::min(origin.y + 8, low_.y + ny_); ++y) {
                    const int offset = NeededVoxels::offsetInLeaf({x, y, z});
                    if (NeededVoxels::maskBit(needed.mask(slot), offset))
                        body(slot, offset,
                             static_cast<std::size_t>(y - low_.y) * static_cast<std::size_t>(nx_) +
                                 static_cast<std::size_t>(x - low_.x));
                }
        });
    }

    LightField& field_;
    glm::ivec3 low_;
    int nx_, ny_;
};

/// [1, 2, 1] / 4 along x and along y, mirrored at the sides.
void smooth(std::vector<double>& values, int nx, int ny) {
    std::vector<double> along(values.size());
    const auto at = [&](int i, int j) {
        return static_cast<std::size_t>(std::clamp(j, 0, ny - 1)) * static_cast<std::size_t>(nx) +
               static_cast<std::size_t>(std::clamp(i, 0, nx - 1));
    };
    for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i)
            along[at(i, j)] = 0.25 * (values[at(i - 1, j)] + 2 * values[at(i, j)] + values[at(i + 1, j)]);
    for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i)
            values[at(i, j)] = 0.25 * (along[at(i, j - 1)] + 2 * along[at(i, j)] + along[at(i, j + 1)]);
}

}  // namespace

void sharpenCaustic(LightField& caustic, double a, double b, double sign) {
    std::atomic<bool> finite{true};
    const auto sharper = [&](float v) {
        const auto sharp = static_cast<float>(a * std::pow(std::max(0.0, sign * static_cast<double>(v)), b));
        if (!std::isfinite(sharp)) finite = false;
        return sharp;
    };
    forEachLeaf(caustic.needed(), [&](int slot) {
        if (caustic.state(slot) == LeafState::Dense) {
            float* v = caustic.dense(slot);
            for (int i = 0; i < LightField::kLeafVoxels; ++i) v[i] = sharper(v[i]);
        } else if (caustic.state(slot) == LeafState::Constant) {
            const std::array<float, 1> value{sharper(caustic.constant(slot)[0])};
            caustic.setConstant(slot, value);
        }
    });
    if (!finite)
        throw Error(ErrorCode::Input,
                    fmt::format("sharpening by {:g} max(0, v)^{:g} leaves the range of a float; use a smaller "
                                "factor or exponent",
                                a, b));
}

void dissipateCaustic(LightField& caustic, double threshold, double speed) {
    const GridFrame& frame = caustic.frame();
    if (!(speed >= 0) || speed > kFastestDissipation)
        throw Error(
            ErrorCode::Input,
            fmt::format("a dissipation speed of {} voxels a layer; it must lie in 0 to {}, or the wave is not stable",
                        speed, kFastestDissipation));
    if (!frame.axisAligned())
        throw Error(ErrorCode::Input,
                    "dissipation spreads straight down, and the grid is sheared; bake it with shear = \"none\"");
    LayerImage image(caustic);
    const int first = static_cast<int>(std::ceil(frame.indexFromWorld({0, 0, threshold}).z)) - 1;  // below the plane
    if (first < frame.min.z) return;
    std::vector<double> before, now, next(image.count());
    image.read(std::min(first + 1, frame.max.z), now);
    for (double& v : now) v = std::max(0.0, v);
    const int nx = image.width(), ny = image.height();
    // Lines of one voxel are more than the scheme's waves can carry: they would leave ripples behind.
    for (int pass = 0; pass < kSmoothings; ++pass) smooth(now, nx, ny);
    before = now;
    for (int z = std::min(first, frame.max.z - 1); z >= frame.min.z; --z) {
        parallelFor(ny, [&](std::int64_t j) {
            const auto at = [&](int i, std::int64_t y) {
                return now[static_cast<std::size_t>(std::clamp<std::int64_t>(y, 0, ny - 1) * nx +
                                                    std::clamp(i, 0, nx - 1))];
            };
            for (int i = 0; i < nx; ++i) {
                const std::size_t here = static_cast<std::size_t>(j * nx + i);
                const double lap = at(i - 1, j) + at(i + 1, j) + at(i, j - 1) + at(i, j + 1) - 4 * now[here];
                next[here] = 2 * now[here] - before[here] + speed * speed * lap;
            }
        });
        std::swap(before, now), std::swap(now, next);
        std::vector<double> shown = now;
        for (double& v : shown) v = std::max(0.0, v);
        image.write(z, shown);
    }
}

}  // namespace photic
