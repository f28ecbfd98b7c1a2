// SPDX-License-Identifier: Apache-2.0
#include "bake/numerics/wave_stepper.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "bake/report/error.h"
#include "bake/threads/parallel_for.h"

namespace photic {
namespace {

/// Steps between looks at the band: waves then come at most 2 cells far, and differences reach 2 further, which is the
/// half block that updateBand() looks at.
constexpr int kBandInterval = 4;
/// Blocks that a thread takes at a time.
constexpr std::int64_t kRun = 32;

alignas(64) constexpr float kNothing[kWaveCells] = {};

std::size_t at(int i) { return static_cast<std::size_t>(i); }

WaveDifferences differences(const glm::dvec3& spacing, int order) {
    WaveDifferences d;
    for (int a = 0; a < 3; ++a) {
        const double h = spacing[a], h2 = h * h;
        const auto f = [](double v) { return static_cast<float>(v); };
        d.first_1[at(a)] = f((order == 4 ? 8.0 / 12 : 0.5) / h),
        d.first_2[at(a)] = f((order == 4 ? -1.0 / 12 : 0.0) / h);
        d.half_1[at(a)] = f((order == 4 ? 15.0 / 12 : 1.0) / h),
        d.half_2[at(a)] = f((order == 4 ? -1.0 / 12 : 0.0) / h);
        d.step[at(a)] = f(1 / h);
        d.second_0[at(a)] = f((order == 4 ? -5.0 / 2 : -2.0) / h2);
        d.second_1[at(a)] = f((order == 4 ? 4.0 / 3 : 1.0) / h2);
        d.second_2[at(a)] = f((order == 4 ? -1.0 / 12 : 0.0) / h2);
    }
    return d;
}

}  // namespace

double WaveStepper::largestStep(const glm::dvec3& spacing, int order) {
    const double most = order == 4 ? 16.0 / 3 : 4.0;  // eigenvalue of -h^2 d2/dx2 at the shortest wave
    double sum = 0;
    for (int a = 0; a < 3; ++a) sum += most / (spacing[a] * spacing[a]);
    return 2 / std::sqrt(sum);
}

WaveStepper::WaveStepper(WaveGrid grid, const WaveSettings& settings, WaveSource source,
                         std::vector<std::uint8_t> wanted, Sink sink)
    : grid_(std::move(grid)),
      settings_(settings),
      source_(std::move(source)),
      sink_(std::move(sink)),
      kernels_(waveKernels()) {
    if (settings_.order != 2 && settings_.order != 4)
        throw Error(ErrorCode::Input,
                    fmt::format("differences of order {} are not built; use 2 or 4", settings_.order));
    if (settings_.speed2 && settings_.absorber == WaveAbsorber::Sponge)
        throw Error(ErrorCode::Input,
                    "the sponge is built for one speed; use absorber = \"pml\" where the index varies");
    const double largest = largestStep(grid_.spacing, settings_.order), factor = settings_.courant * settings_.speed;
    if (!(settings_.courant > 0 && settings_.speed > 0 && settings_.courant <= 1 && factor <= 1))
        throw Error(
            ErrorCode::Input,
            fmt::format("a time step of {:.6g} is {:.3g} times the largest stable one, {:.6g} (Courant, Friedrichs and "
                        "Lewy); use a factor in (0, 1]",
                        settings_.courant * largest, factor, largest / settings_.speed));
    dt_ = settings_.courant * largest;
    counts_.blocks = 0;
    for (int b = 0; b < grid_.count(); ++b) counts_.blocks += grid_.has(b);
    prepareDrivers();
    prepareKinds();
    prepareWeights();

    std::vector<std::uint8_t> memory(kinds_.size());
    for (std::size_t b = 0; b < kinds_.size(); ++b) {
        if (kinds_[b] != Kind::Matched) continue;
        for (int a = 0; a < 3; ++a)
            if (open_[b] >> (2 * a) & 3) memory[b] = static_cast<std::uint8_t>(memory[b] + 2);
    }
    if (!wanted.empty())
        for (std::size_t b = 0; b < kinds_.size(); ++b)
            if (kinds_[b] == Kind::Matched || kinds_[b] == Kind::Sponge) wanted[b] = 0;
    band_ = std::make_unique<WaveBand>(grid_, channels(), std::move(wanted), std::move(memory), settings_.speed2);

    // The first driver's pulse begins after the first step.
    time_ = 0;
    if (!drivers_.empty() && source_.start.empty()) {
        time_ = std::numeric_limits<double>::infinity();
        for (const Driver& d : drivers_)
            if (d.count > 0) time_ = std::min(time_, d.from);
        if (!std::isfinite(time_)) time_ = 0;
    }
    updateBand();
    for (const WaveStart& s : source_.start) {
        const int number = band_->find(s.block);
        float* field = band_->active()[at(number)].field;
        field[s.cell] = field[kWaveCells + s.cell] = s.value;
    }
}

WaveStepper::~WaveStepper() = default;

int WaveStepper::channels() const {
    return (settings_.sum == WaveSum::Nothing  ? 0
            : settings_.sum == WaveSum::Energy ? 1
                                               : 4) +
           (settings_.sum_field ? 1 : 0);
}

void WaveStepper::prepareDrivers() {
    driver_of_.assign(at(grid_.count()), -1);
    const auto driverFor = [&](int block) -> Driver& {
        std::int32_t& number = driver_of_[at(block)];
        if (number < 0) {
            number = static_cast<std::int32_t>(drivers_.size());
            drivers_.push_back({block});
        }
        return drivers_[at(number)];
    };
    for (const WaveHeld& h : source_.held) driverFor(h.block).held = h.cells;
    std::stable_sort(source_.driven.begin(), source_.driven.end(),
                     [](const WaveDriven& a, const WaveDriven& b) { return a.block < b.block; });
    for (std::size_t i = 0; i < source_.driven.size(); ++i) {
        const WaveDriven& driven = source_.driven[i];
        Driver& d = driverFor(driven.block);
        const double reach = source_.pulse.reach();
        if (d.count == 0) d.first = i, d.from = driven.arrival - reach, d.to = driven.arrival + reach;
        d.from = std::min(d.from, driven.arrival - reach), d.to = std::max(d.to, driven.arrival + reach);
        ++d.count;
        d.held[driven.cell >> 6] |= std::uint64_t{1} << (driven.cell & 63);
    }
}

void WaveStepper::prepareKinds() {
    kinds_.assign(at(grid_.count()), Kind::Plain);
    open_.assign(at(grid_.count()), 0);
    const auto heldTowards = [&](const Driver& d, int side) {  // the two outermost layers of a side
        for (int i = 0; i < kWaveCells; ++i) {
            const int k = i >> (6 - 3 * (side >> 1)) & 7;
            if (((side & 1) != 0 ? k >= 6 : k < 2) && (d.held[at(i >> 6)] >> (i & 63) & 1) == 0) return false;
        }
        return true;
    };
    for (int b = 0; b < grid_.count(); ++b) {
        if (!grid_.has(b)) continue;
        const int number = driver_of_[at(b)];
        if (number >= 0 && std::all_of(drivers_[at(number)].held.begin(), drivers_[at(number)].held.end(),
                                       [](std::uint64_t m) { return m == ~std::uint64_t{0}; })) {
            kinds_[at(b)] = Kind::Held;
            continue;
        }
        if (settings_.absorber != WaveAbsorber::Pml) continue;
        for (int side = 0; side < 6; ++side)
            if (grid_.neighbour(b, side) < 0 && (number < 0 || !heldTowards(drivers_[at(number)], side)))
                open_[at(b)] = static_cast<std::uint8_t>(open_[at(b)] | 1u << side);
        if (open_[at(b)]) kinds_[at(b)] = Kind::Matched;
    }
    if (settings_.absorber != WaveAbsorber::Sponge) return;
    for (int a = 0; a < 3; ++a) {
        const int cells = grid_.blocks[a] * kWaveSide;
        auto& sponge = sponge_[at(a)];
        sponge.assign(at(cells), 0.0f);
        if (grid_.periodic[at(a)]) continue;
        for (int i = 0; i < cells; ++i) {
            // Waves that are driven from above have no open side there.
            const bool open_above = a < 2 || source_.held.empty();
            const double depth = settings_.sponge_cells - (open_above ? std::min(i, cells - 1 - i) : i);
            sponge[at(i)] = static_cast<float>(spongeDamping(depth, settings_.sponge_cells, grid_.spacing[a], 1, dt_));
        }
    }
    for (int b = 0; b < grid_.count(); ++b) {
        if (!grid_.has(b) || kinds_[at(b)] == Kind::Held) continue;
        const glm::ivec3 place = grid_.place(b) * kWaveSide;
        for (int a = 0; a < 3; ++a)
            if (sponge_[at(a)][at(place[a])] > 0 || sponge_[at(a)][at(place[a] + 7)] > 0) kinds_[at(b)] = Kind::Sponge;
    }
}

void WaveStepper::prepareWeights() {
    weights_.d = differences(grid_.spacing, settings_.order);
    weights_.scale = static_cast<float>(dt_ * dt_ * settings_.speed * settings_.speed);
    weights_.keep = static_cast<float>(1 / (1 + settings_.damping * dt_));
    weights_.lose = static_cast<float>((1 - settings_.damping * dt_) / (1 + settings_.damping * dt_));
    weights_.per_two_steps = static_cast<float>(1 / (2 * dt_));
    for (int a = 0; a < 3; ++a) pml_[at(a)] = pmlTable(grid_.spacing[a], 1, dt_, source_.pulse.frequency());
}

void WaveStepper::updateBand() {
    std::vector<int> wanted;
    if (!settings_.sparse) {
        for (int b = 0; b < grid_.count(); ++b)
            if (grid_.has(b)) wanted.push_back(b);
    } else {
        // Blocks with waves in them, and those that waves are about to enter.
        const auto& active = band_->active();
        const auto limit = static_cast<float>(settings_.threshold);
        const auto want = [&](int block) {
            if (block >= 0 && kinds_[at(block)] != Kind::Held) wanted.push_back(block);
        };
        for (std::size_t i = 0; i < active.size(); ++i) {
            if (kinds_[at(active[i].block)] == Kind::Held) continue;
            bool here = false;
            for (int side = 0; side < 6; ++side) {
                if (!(largest_[i][at(side)] > limit)) continue;
                here = true;
                want(grid_.neighbour(active[i].block, side));
            }
            if (here) wanted.push_back(active[i].block);
        }
        // Sources that drive before the next look.
        bool to_come = false;
        for (const Driver& d : drivers_) {
            if (d.count == 0 || d.to < time_ - dt_) continue;
            to_come = true;
            if (d.from > time_ + (kBandInterval + 1) * dt_) continue;
            wanted.push_back(d.block);
            for (int side = 0; side < 6; ++side) want(grid_.neighbour(d.block, side));
        }
        if (counts_.steps == 0)
            for (const WaveStart& s : source_.start) {
                wanted.push_back(s.block);
                for (int side = 0; side < 6; ++side) want(grid_.neighbour(s.block, side));
            }
        std::sort(wanted.begin(), wanted.end());
        wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
        finished_ = wanted.empty() && !to_come;
    }
    band_->become(wanted, [&](const WaveActive& a) { retire(a); });
    largest_.resize(band_->active().size());
}

void WaveStepper::step() {
    if (finished_) return;
    sums_now_ = counts_.steps % settings_.sum_every == 0;
    look_now_ = (counts_.steps + 1) % kBandInterval == 0;
    const auto count = static_cast<std::int64_t>(band_->active().size());
    parallelFor((count + kRun - 1) / kRun, [&](std::int64_t run) {
        for (std::int64_t i = run * kRun; i < std::min(count, (run + 1) * kRun); ++i) stepBlock(static_cast<int>(i));
    });
    level_ ^= 1;
    time_ += dt_;
    counts_.block_steps += static_cast<std::int64_t>(band_->active().size());
    if (++counts_.steps % kBandInterval == 0) updateBand();
}

WaveBlock WaveStepper::view(const WaveActive& active) const {
    WaveBlock block;
    block.now = active.field + level_ * kWaveCells;
    block.other = active.field + (level_ ^ 1) * kWaveCells;
    for (std::size_t side = 0; side < 6; ++side) {
        const int n = active.neighbour[side];
        block.side[side] = n < 0 ? kNothing : band_->active()[at(n)].field + level_ * kWaveCells;
    }
    block.sums = active.sums, block.speed2 = active.speed2;
    return block;
}

void WaveStepper::stepBlock(int number) {
    const WaveActive& active = band_->active()[at(number)];
    WaveBlock block = view(active);
    block.largest = &largest_[at(number)];
    const Kind kind = kinds_[at(active.block)];
    const bool sum = sums_now_ && active.sums;
    const WaveSum what = sum ? settings_.sum : WaveSum::Nothing;
    switch (kind) {
        case Kind::Matched:
            kernels_.stepMatched(block, weights_, memoryOf(active));
            break;
        case Kind::Sponge: {
            std::array<std::array<float, 8>, 3> damping;
            const glm::ivec3 place = grid_.place(active.block) * kWaveSide;
            for (int a = 0; a < 3; ++a) std::copy_n(sponge_[at(a)].begin() + place[a], 8, damping[at(a)].begin());
            kernels_.stepSponge(block, weights_, damping);
            break;
        }
        case Kind::Plain:
            if (block.speed2)
                kernels_.stepVarying[static_cast<int>(what)](block, weights_);
            else
                kernels_.step[look_now_][static_cast<int>(what)](block, weights_);
            break;
        case Kind::Held:
            break;
    }
    if (settings_.clamp)
        for (int i = 0; i < kWaveCells; ++i) block.other[i] = std::max(block.other[i], 0.0f);
    if (const int d = driver_of_[at(active.block)]; d >= 0) drive(drivers_[at(d)], block.other, time_ + dt_);
    if (look_now_ && (kind != Kind::Plain || block.speed2 || driver_of_[at(active.block)] >= 0))
        kernels_.halves(block.now, block.other, largest_[at(number)]);
    if (sum && settings_.sum_field) {
        float* field_sum = active.sums + (channels() - 1) * kWaveCells;
        for (int i = 0; i < kWaveCells; ++i) field_sum[i] += block.other[i];
    }
}

WaveMemory WaveStepper::memoryOf(const WaveActive& active) const {
    WaveMemory memory;
    // Waves that run along a side would be bent by a wall of zeros behind the layer.
    memory.mirrors = open_[at(active.block)] & 15u;
    float* next = active.memory;
    for (int a = 0; a < 3; ++a) {
        const int sides = open_[at(active.block)] >> (2 * a) & 3;
        if (sides == 0) continue;
        memory.psi[at(a)] = next, memory.zeta[at(a)] = next + kWaveCells;
        next += 2 * kWaveCells;
        memory.outwards[at(a)] = sides == 1 ? -1 : 1;
        for (int i = 0; i < kWaveSide; ++i) {
            // Outwards from the side that is not open; a block that is open on both sides absorbs from its middle.
            const int k = sides == 2 ? i : sides == 1 ? 7 - i : std::abs(2 * i - 7);
            const PmlTable& table = pml_[at(a)];
            memory.a[at(a)][at(i)] = table.a[at(k)], memory.b[at(a)][at(i)] = table.b[at(k)];
            memory.a_half[at(a)][at(i)] = table.a_half[at(k)], memory.b_half[at(a)][at(i)] = table.b_half[at(k)];
        }
    }
    return memory;
}

void WaveStepper::drive(const Driver& driver, float* values, double time) const {
    for (int i = 0; i < kWaveCells; ++i)
        if (driver.held[at(i >> 6)] >> (i & 63) & 1) values[i] = 0;
    if (time < driver.from || time > driver.to) return;
    for (std::size_t i = driver.first; i < driver.first + driver.count; ++i) {
        const WaveDriven& d = source_.driven[i];
        values[d.cell] = static_cast<float>(d.amplitude * source_.pulse(time - d.arrival));
    }
}

void WaveStepper::retire(const WaveActive& active) {
    if (!active.sums || !sink_) return;
    const auto scale = static_cast<float>(dt_ * settings_.sum_every);
    for (int i = 0; i < channels() * kWaveCells; ++i) active.sums[i] *= scale;
    sink_(active.block, active.sums);
}

void WaveStepper::finish() {
    band_->become({}, [&](const WaveActive& a) { retire(a); });
    finished_ = true;
}

float WaveStepper::value(int block, int cell) const {
    const int n = block < 0 ? -1 : band_->find(block);
    return n < 0 ? 0.0f : band_->active()[at(n)].field[level_ * kWaveCells + cell];
}

double WaveStepper::energy() const {
    const WaveDifferences d = differences(grid_.spacing, settings_.order);
    double total = 0;
    for (const WaveActive& active : band_->active()) {
        const WaveBlock b = view(active);
        const auto now = [&](int axis, int i, int step) {
            const int shift = 6 - 3 * axis, k = (i >> shift & 7) + step;
            if (k >= 0 && k < 8) return static_cast<double>(b.now[i + step * (1 << shift)]);
            return static_cast<double>(b.side[at(2 * axis + (k > 7))][i + (step + (k > 7 ? -8 : 8)) * (1 << shift)]);
        };
        for (int i = 0; i < kWaveCells; ++i) {
            double laplacian = 0;
            for (int a = 0; a < 3; ++a)
                laplacian += static_cast<double>(d.second_0[at(a)]) * b.now[i] +
                             static_cast<double>(d.second_1[at(a)]) * (now(a, i, 1) + now(a, i, -1)) +
                             static_cast<double>(d.second_2[at(a)]) * (now(a, i, 2) + now(a, i, -2));
            const double rate = (static_cast<double>(b.now[i]) - b.other[i]) / dt_;
            const double c2 = settings_.speed * settings_.speed * (active.speed2 ? active.speed2[i] : 1.0);
            total += 0.5 * rate * rate / c2 - 0.5 * b.other[i] * laplacian;
        }
    }
    return total * grid_.spacing.x * grid_.spacing.y * grid_.spacing.z;
}

WaveCounts WaveStepper::counts() const {
    WaveCounts c = counts_;
    c.peak_blocks = static_cast<std::int64_t>(band_->peakBlocks());
    c.peak_bytes = band_->peakBytes();
    return c;
}

}  // namespace photic
