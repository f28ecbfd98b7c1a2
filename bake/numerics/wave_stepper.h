// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "bake/numerics/wave_absorber.h"
#include "bake/numerics/wave_band.h"
#include "bake/numerics/wave_kernel.h"
#include "bake/numerics/wave_pulse.h"

namespace photic {

/// A cell whose value is given, amplitude * f(t - arrival): what lies on the source's side of an interface.
struct WaveDriven {
    int block = 0;
    std::uint16_t cell = 0;  ///< in the block
    float amplitude = 0;
    double arrival = 0;
};

/// The cells of a block that do not follow the wave equation: 0 unless driven. One bit a cell.
struct WaveHeld {
    int block = 0;
    std::array<std::uint64_t, 8> cells{};
};

/// A value at rest at the start.
struct WaveStart {
    int block = 0;
    std::uint16_t cell = 0;
    float value = 0;
};

/// Everything that moves the waves.
struct WaveSource {
    WavePulse pulse{1};
    std::vector<WaveDriven> driven;  ///< their cells are held
    std::vector<WaveHeld> held;
    std::vector<WaveStart> start;
};

struct WaveSettings {
    int order = 4;          ///< of the differences in space: 2 or 4
    double courant = 0.95;  ///< part of the largest stable step; in (0, 1]
    /// Of the waves where nothing varies: near 1, so that the scheme's own error in speed is made up for (tunedSpeed);
    /// courant * speed <= 1.
    double speed = 1;
    double damping = 0;  ///< gamma of phi_tt + 2 gamma phi_t = lap phi, everywhere [1/s]
    WaveAbsorber absorber = WaveAbsorber::Pml;
    int sponge_cells = 16;
    WaveSum sum = WaveSum::EnergyAndFlux;
    bool sum_field = false;   ///< one more channel: the integral of phi
    int sum_every = 1;        ///< steps
    bool clamp = false;       ///< phi >= 0 after each step [Mercier 2014, section 5.2]
    double threshold = 1e-3;  ///< of |phi|, below which a block is given up
    bool sparse = true;       ///< false: all blocks take part in every step
    /// Fills c^2 of a block's cells, in (0, 1]; called from several threads. Empty: 1. Not with the sponge.
    std::function<void(int block, float* speed2)> speed2{};
};

/// What the run has done so far.
struct WaveCounts {
    std::int64_t steps = 0;
    std::int64_t block_steps = 0;  ///< sum over the steps of the blocks that took part
    std::int64_t blocks = 0;       ///< of the domain
    std::int64_t peak_blocks = 0;
    std::int64_t peak_bytes = 0;
};

/// phi_tt + 2 gamma phi_t = lap phi on a sparse band of blocks that moves with the waves. The speed is 1: times are
/// lengths. With `speed2` it is c(x) <= 1, phi_tt + 2 c gamma phi_t = c^2 lap phi, and steps are those of the largest.
///
/// Leapfrog in time, central differences of order 2 or 4 in space, single precision. A block takes part while
/// |phi| > threshold in it, or while waves could reach it before the band is looked at again.
/// Open sides (no neighbour, not periodic, not held) end as `absorber` says: in the perfectly matched layer in their
/// outermost block, in the sponge over its width from the sides of the box.
/// Sums are integrals over time: phi_t^2, then -phi_t grad phi (three), then phi; they are not taken in absorbing
/// blocks. Memory: 8 bytes a cell of the band, 4 more where c varies, 4 more a channel where sums are wanted, 8 more a
/// matched axis. Results do not depend on the number of threads.
class WaveStepper {
public:
    /// The sums of a block that the waves have left; it may come back, with further sums.
    using Sink = std::function<void(int block, const float* sums)>;

    /// @param wanted  by block: sums are taken; empty: nowhere
    /// @throws Error{Input} for a Courant number outside (0, 1], an order that is neither 2 nor 4, and a speed that
    /// varies with the sponge
    WaveStepper(WaveGrid grid, const WaveSettings& settings, WaveSource source, std::vector<std::uint8_t> wanted,
                Sink sink);
    ~WaveStepper();

    double dt() const { return dt_; }
    double time() const { return time_; }        ///< of the latest level
    bool finished() const { return finished_; }  ///< no wave is left, and no source to come
    void step();
    /// Hands all sums to the sink.
    void finish();

    /// phi at a cell, 0 outside of the band; slow.
    float value(int block, int cell) const;
    /// The discrete energy, which leapfrog conserves: |phi_t|^2 / 2 c^2 - phi(n+1) lap phi(n) / 2, times a cell's
    /// volume; slow.
    double energy() const;
    WaveCounts counts() const;
    const WaveBand& band() const { return *band_; }

    /// Largest stable step: the operator's largest eigenvalue times dt^2 is at most 4.
    static double largestStep(const glm::dvec3& spacing, int order);

private:
    struct Driver {  // the held and driven cells of a block
        int block = 0;
        std::array<std::uint64_t, 8> held{};
        std::size_t first = 0, count = 0;  // of source_.driven
        double from = 0, to = 0;           // when it drives
    };
    enum class Kind : std::uint8_t { Plain, Matched, Sponge, Held };

    void prepareDrivers();
    void prepareKinds();
    void prepareWeights();
    void updateBand();
    void stepBlock(int number);
    void drive(const Driver& driver, float* values, double time) const;
    WaveMemory memoryOf(const WaveActive& active) const;
    WaveBlock view(const WaveActive& active) const;
    void retire(const WaveActive& active);
    int channels() const;

    WaveGrid grid_;
    WaveSettings settings_;
    WaveSource source_;
    Sink sink_;
    const WaveKernels& kernels_;
    double dt_ = 0, time_ = 0;
    WaveWeights weights_;
    std::array<PmlTable, 3> pml_;
    std::vector<Driver> drivers_;
    std::vector<std::int32_t> driver_of_;       // by block; -1: none
    std::vector<Kind> kinds_;                   // by block
    std::vector<std::uint8_t> open_;            // by block: bit per absorbing side
    std::array<std::vector<float>, 3> sponge_;  // gamma dt by cell along each axis
    std::unique_ptr<WaveBand> band_;
    int level_ = 0;  // of the two in a block's field: the latest
    bool finished_ = false, sums_now_ = false, look_now_ = false;
    std::vector<std::array<float, 6>> largest_;  // by active block, at the last look
    WaveCounts counts_;
};

}  // namespace photic
