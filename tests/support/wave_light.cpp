// SPDX-License-Identifier: Apache-2.0
#include "tests/support/wave_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/support/closed_forms.h"

namespace photic::truth {
namespace {

// Gauss-Legendre on [0, 1], 6 points.
constexpr std::array<double, 6> kNode{0.033765242898423986, 0.16939530676686775, 0.3806904069584015,
                                      0.6193095930415985,   0.8306046932331322,  0.966234757101576};
constexpr std::array<double, 6> kWeight{0.08566224618958517, 0.18038078652406930, 0.23395696728634552,
                                        0.23395696728634552, 0.18038078652406930, 0.08566224618958517};

/// The root of a function that changes sign between a and b; Illinois' variant of false position, then bisection.
template <class F>
double bracketedRoot(const F& f, double a, double b, double fa, double fb) {
    int side = 0;
    for (int i = 0; i < 200; ++i) {
        const double x = i < 60 ? (a * fb - b * fa) / (fb - fa) : (a + b) / 2;
        const double fx = f(x);
        if (fx == 0 || std::fabs(b - a) < 1e-14 * (1 + std::fabs(a))) return x;
        if ((fx > 0) == (fb > 0)) {
            if (std::fabs(b - x) < 1e-15 * (1 + std::fabs(x))) return x;
            b = x, fb = fx;
            if (side == -1) fa /= 2;
            side = -1;
        } else {
            if (std::fabs(x - a) < 1e-15 * (1 + std::fabs(x))) return x;
            a = x, fa = fx;
            if (side == 1) fb /= 2;
            side = 1;
        }
    }
    return (a + b) / 2;
}

}  // namespace

Profile cosineProfile(double amplitude, double wavenumber) {
    return [=](double u) {
        const double c = std::cos(wavenumber * u), s = std::sin(wavenumber * u);
        return ProfilePoint{amplitude * c, -amplitude * wavenumber * s, -amplitude * wavenumber * wavenumber * c};
    };
}

WaveLight::WaveLight(Profile profile, double eta, double u_min, double u_max, int cells, double extinction, double e0)
    : profile_(std::move(profile)),
      eta_(eta),
      u_min_(u_min),
      u_max_(u_max),
      extinction_(extinction),
      e0_(e0),
      cells_(cells) {}

WaveLight::Ray WaveLight::ray(double u) const {
    const ProfilePoint p = profile_(u);
    const double length2 = 1 + p.slope * p.slope;
    const double cos_beta = 1 / std::sqrt(length2), sin_beta = p.slope * cos_beta;
    const double sin_t = sin_beta / eta_, cos_t = std::sqrt(1 - sin_t * sin_t);
    // alpha = beta - t, by the addition theorems
    const double sin_alpha = sin_beta * cos_t - cos_beta * sin_t;
    const double cos_alpha = cos_beta * cos_t + sin_beta * sin_t;
    const double d_beta = p.curvature / length2;
    const double d_t = cos_beta * d_beta / (eta_ * cos_t);
    return {u,
            p.h,
            sin_alpha / cos_alpha,
            cos_alpha,
            fresnelTransmittance(cos_beta, 1, eta_),
            (d_beta - d_t) / (cos_alpha * cos_alpha),
            p.slope};
}

double WaveLight::heightIn(const Ray& r, double z) { return std::min(z, r.h); }
double WaveLight::landingIn(const Ray& r, double z) { return r.u + (r.h - heightIn(r, z)) * r.tan_alpha; }

double WaveLight::landing(double u, double z) const {
    const Ray r = ray(u);
    return u + (r.h - z) * r.tan_alpha;
}

double WaveLight::jacobian(double u, double z) const {
    const Ray r = ray(u);
    return 1 + r.slope * r.tan_alpha + (r.h - z) * r.d_tan;
}

/// What a ray of unit width in u leaves between two heights.
WaveLight::Sum WaveLight::weight(const Ray& r, double z_low, double z_high) const {
    const double low = std::min(z_low, r.h), high = std::min(z_high, r.h);
    if (!(high > low)) return {};
    double height = high - low;
    if (extinction_ > 0) {
        const double per_height = extinction_ / r.cos_alpha;
        height = std::exp(-per_height * (r.h - high)) * -std::expm1(-per_height * (high - low)) / per_height;
    }
    const double down = e0_ * r.transmittance * height;
    return {down / r.cos_alpha, down, down * r.tan_alpha};
}

WaveLight::Sum WaveLight::gauss(double a, double b, const std::function<Sum(const Ray&)>& f) const {
    Sum sum;
    for (std::size_t i = 0; i < kNode.size(); ++i) {
        const Sum s = f(ray(a + (b - a) * kNode[i]));
        const double w = (b - a) * kWeight[i];
        sum += {w * s.fluence, w * s.down, w * s.across};
    }
    return sum;
}

/// The parameter cut so that between cuts rays of level z have one kind: under water or not, J of one sign.
std::vector<double> WaveLight::breaks(double z) const {
    std::vector<double> out{u_min_};
    const double du = (u_max_ - u_min_) / cells_;
    const auto above = [&](double u) { return profile_(u).h - z; };
    const auto j = [&](double u) { return jacobian(u, z); };
    double a = u_min_, above_a = above(a), j_a = j(a);
    for (int m = 1; m <= cells_; ++m) {
        const double b = m == cells_ ? u_max_ : u_min_ + du * m;
        const double above_b = above(b), j_b = j(b);
        const std::size_t first = out.size();
        if ((above_a > 0) != (above_b > 0)) out.push_back(bracketedRoot(above, a, b, above_a, above_b));
        if ((j_a > 0) != (j_b > 0)) out.push_back(bracketedRoot(j, a, b, j_a, j_b));
        std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
        out.push_back(b);
        a = b, above_a = above_b, j_a = j_b;
    }
    return out;
}

/// Where rays pass the lines x0 + i dx at height z (or at the surface, where that lies lower).
std::vector<WaveLight::Root> WaveLight::roots(double z, const std::vector<double>& parts, double x0, double dx,
                                              int lines) const {
    std::vector<Root> out;
    for (std::size_t p = 0; p + 1 < parts.size(); ++p) {
        const double xa = landingIn(ray(parts[p]), z), xb = landingIn(ray(parts[p + 1]), z);
        const int first = std::max(0, static_cast<int>(std::ceil((std::min(xa, xb) - x0) / dx)));
        const int last = std::min(lines - 1, static_cast<int>(std::floor((std::max(xa, xb) - x0) / dx)));
        for (int i = first; i <= last; ++i) {
            const double x = x0 + i * dx;
            const double u = xa == x   ? parts[p]
                             : xb == x ? parts[p + 1]
                                       : bracketedRoot([&](double v) { return landingIn(ray(v), z) - x; }, parts[p],
                                                       parts[p + 1], xa - x, xb - x);
            out.push_back({i, u});
        }
    }
    return out;
}

/// For each vertical line x_i, integrates over u what lies left of it in the layer; voxels are the differences.
void WaveLight::fillLayer(VoxelMeans& out, int k, double x0, double dx, const Layer& layer) const {
    const int lines = out.nx + 1;
    const std::vector<double> at_bottom = breaks(layer.bottom), at_top = breaks(layer.top);

    // Cumulative integral of whole rays from u_min, at every place where the integrand may have a kink.
    std::vector<double> parts;
    std::merge(at_bottom.begin(), at_bottom.end(), at_top.begin(), at_top.end(), std::back_inserter(parts));
    parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
    const auto whole = [&](const Ray& r) { return weight(r, layer.bottom, layer.top); };
    std::vector<Sum> cumulative(parts.size());
    for (std::size_t p = 1; p < parts.size(); ++p) {
        cumulative[p] = cumulative[p - 1];
        cumulative[p] += gauss(parts[p - 1], parts[p], whole);
    }
    const auto wholeUpTo = [&](double u) {
        const auto p = static_cast<std::size_t>(
            std::max<std::ptrdiff_t>(0, std::upper_bound(parts.begin(), parts.end(), u) - parts.begin() - 1));
        Sum s = cumulative[p];
        if (u > parts[p]) s += gauss(parts[p], u, whole);
        return s;
    };

    std::vector<std::vector<double>> cuts(static_cast<std::size_t>(lines));
    for (const Root& r : roots(layer.bottom, at_bottom, x0, dx, lines))
        cuts[static_cast<std::size_t>(r.line)].push_back(r.u);
    for (const Root& r : roots(layer.top, at_top, x0, dx, lines)) cuts[static_cast<std::size_t>(r.line)].push_back(r.u);

    std::vector<Sum> left(static_cast<std::size_t>(lines));
    for (int i = 0; i < lines; ++i) {
        const double x = x0 + i * dx;
        auto& cut = cuts[static_cast<std::size_t>(i)];
        cut.push_back(u_min_), cut.push_back(u_max_);
        std::sort(cut.begin(), cut.end());
        Sum sum;
        for (std::size_t c = 0; c + 1 < cut.size(); ++c) {
            const double a = cut[c], b = cut[c + 1];
            if (!(b > a)) continue;
            const Ray middle = ray((a + b) / 2);
            const bool top_left = landingIn(middle, layer.top) < x, bottom_left = landingIn(middle, layer.bottom) < x;
            if (top_left && bottom_left) {
                const Sum to = wholeUpTo(b), from = wholeUpTo(a);
                sum += {to.fluence - from.fluence, to.down - from.down, to.across - from.across};
            } else if (top_left != bottom_left) {
                // These rays pass the line inside the layer, at height h - (x - u) / tan(alpha).
                const auto partly = [&](const Ray& r) {
                    const double crossing = std::clamp(r.h - (x - r.u) / r.tan_alpha, layer.bottom, layer.top);
                    return top_left ? weight(r, crossing, layer.top) : weight(r, layer.bottom, crossing);
                };
                auto p = std::upper_bound(parts.begin(), parts.end(), a);
                for (double from = a; from < b;) {
                    const double to = p == parts.end() ? b : std::min(b, *p++);
                    sum += gauss(from, to, partly);
                    from = to;
                }
            }
        }
        left[static_cast<std::size_t>(i)] = sum;
    }
    const double area = dx * (layer.top - layer.bottom);
    for (int i = 0; i < out.nx; ++i) {
        const Sum &a = left[static_cast<std::size_t>(i)], &b = left[static_cast<std::size_t>(i) + 1];
        const std::size_t v = out.index(i, k);
        out.fluence[v] = (b.fluence - a.fluence) / area;
        out.down[v] = (b.down - a.down) / area;
        out.across[v] = (b.across - a.across) / area;
    }
}

void WaveLight::fillJacobian(VoxelMeans& out, double x0, double dx, double z0, double dz) const {
    const int rays = static_cast<int>(std::min(1e5, std::ceil((u_max_ - u_min_) / dx * 32)));
    for (int m = 0; m <= rays; ++m) {
        const double u = u_min_ + (u_max_ - u_min_) * m / rays;
        const Ray r = ray(u);
        for (int k = 0; k < out.nz && z0 + k * dz < r.h; ++k) {
            const double bottom = z0 + k * dz, top = std::min(bottom + dz, r.h);
            const double j_top = jacobian(u, top), j_bottom = jacobian(u, bottom);
            const double least = j_top * j_bottom <= 0 ? 0 : std::min(std::fabs(j_top), std::fabs(j_bottom));
            const auto [low, high] = std::minmax({landingIn(r, top), landingIn(r, bottom)});
            const int first = std::max(0, static_cast<int>(std::floor((low - x0) / dx)));
            const int last = std::min(out.nx - 1, static_cast<int>(std::floor((high - x0) / dx)));
            for (int i = first; i <= last; ++i) {
                auto& value = out.jacobian[out.index(i, k)];
                value = std::min(value, least);
            }
        }
    }
}

VoxelMeans WaveLight::voxelMeans(double x0, double dx, int nx, double z0, double dz, int nz) const {
    VoxelMeans out;
    out.nx = nx, out.nz = nz;
    const auto count = static_cast<std::size_t>(nx) * nz;
    out.fluence.resize(count), out.down.resize(count), out.across.resize(count);
    out.jacobian.assign(count, std::numeric_limits<double>::infinity());
    for (int k = 0; k < nz; ++k) fillLayer(out, k, x0, dx, {z0 + k * dz, z0 + (k + 1) * dz});
    fillJacobian(out, x0, dx, z0, dz);
    return out;
}

std::vector<double> WaveLight::arrivals(double x, double z) const {
    std::vector<double> out;
    for (const Root& r : roots(z, breaks(z), x, 1, 1)) {
        if (profile_(r.u).h > z) out.push_back(r.u);
    }
    return out;
}

double WaveLight::horizontal(double x, double z) const {
    double sum = 0;
    for (const double u : arrivals(x, z)) {
        const Ray r = ray(u);
        sum += e0_ * r.transmittance * std::exp(-extinction_ * (r.h - z) / r.cos_alpha) / std::fabs(jacobian(u, z));
    }
    return sum;
}

double WaveLight::fluence(double x, double z) const {
    double sum = 0;
    for (const double u : arrivals(x, z)) {
        const Ray r = ray(u);
        sum += e0_ * r.transmittance * std::exp(-extinction_ * (r.h - z) / r.cos_alpha) /
               (std::fabs(jacobian(u, z)) * r.cos_alpha);
    }
    return sum;
}

}  // namespace photic::truth
