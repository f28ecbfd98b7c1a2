// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

namespace photic::truth {

/// A height profile z = h(u) and its first two derivatives.
struct ProfilePoint {
    double h = 0, slope = 0, curvature = 0;
};
using Profile = std::function<ProfilePoint(double u)>;

/// z = amplitude cos(wavenumber u).
Profile cosineProfile(double amplitude, double wavenumber);

/// Voxel averages in the plane, i (along x) fastest.
struct VoxelMeans {
    int nx = 0, nz = 0;
    std::vector<double> fluence;  ///< mean scalar irradiance [W/m2]
    std::vector<double> down;     ///< mean of -F_z, the irradiance on horizontal planes [W/m2]
    std::vector<double> across;   ///< mean of F_x [W/m2]
    std::vector<double>
        jacobian;  ///< least |J| of all arrivals in the voxel, 0 where a sheet folds; +inf without light
    std::size_t index(int i, int k) const { return static_cast<std::size_t>(k) * nx + i; }
};

/// Light that falls straight down on z = h(x), y-invariant, and is refracted once.
///
/// A ray launched at u has landed, at height z, at X(u, z) = u + (h - z) tan(alpha), alpha = beta - t, beta = atan h',
/// sin t = sin(beta) / eta. A voxel's mean is the integral over u of power x exact path length through the voxel,
/// over its area: bounded, without the singularities of 1/|J|.
class WaveLight {
public:
    /// @param u_min, u_max  launched patch [m]
    /// @param cells         of the parameter, between which sheets are taken to be monotone once split where J = 0
    WaveLight(Profile profile, double eta, double u_min, double u_max, int cells, double extinction = 0, double e0 = 1);

    double landing(double u, double z) const;
    /// dX/du at height z.
    double jacobian(double u, double z) const;
    /// Irradiance on the plane z at x, summed over arrivals; unbounded at caustics.
    double horizontal(double x, double z) const;
    double fluence(double x, double z) const;

    /// Means over voxels [x0 + i dx, x0 + (i+1) dx] x [z0 + k dz, z0 + (k+1) dz]; voxels above the surface hold 0, and
    /// cut ones the light in their wet part. Converged to 1e-8 or so of the mean.
    VoxelMeans voxelMeans(double x0, double dx, int nx, double z0, double dz, int nz) const;

private:
    struct Ray {
        double u, h, tan_alpha, cos_alpha, transmittance, d_tan, slope;
    };
    struct Sum {
        double fluence = 0, down = 0, across = 0;
        Sum& operator+=(const Sum& s) {
            fluence += s.fluence, down += s.down, across += s.across;
            return *this;
        }
    };
    struct Layer {
        double bottom, top;
    };
    struct Root {
        int line;
        double u;
    };
    Ray ray(double u) const;
    static double heightIn(const Ray& r, double z);
    static double landingIn(const Ray& r, double z);
    Sum weight(const Ray& r, double z_low, double z_high) const;
    Sum gauss(double a, double b, const std::function<Sum(const Ray&)>& f) const;
    std::vector<double> breaks(double z) const;
    std::vector<Root> roots(double z, const std::vector<double>& parts, double x0, double dx, int lines) const;
    std::vector<double> arrivals(double x, double z) const;
    void fillLayer(VoxelMeans& out, int k, double x0, double dx, const Layer& layer) const;
    void fillJacobian(VoxelMeans& out, double x0, double dx, double z0, double dz) const;

    Profile profile_;
    double eta_, u_min_, u_max_, extinction_, e0_;
    int cells_;
};

}  // namespace photic::truth
