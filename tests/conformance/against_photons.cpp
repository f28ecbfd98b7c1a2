// SPDX-License-Identifier: Apache-2.0
#include "tests/conformance/against_photons.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace photic {

double total(const LightField& field) { return field.sum(0); }

Compared againstPhotons(const std::string& toml, std::int64_t count) {
    const Baked beams = whole(bakeText(toml, "beams")),
                reference = whole(bakeText(toml, "photons", option("count", count)));
    const Compared c{blockDifference(beams.field(), reference.field(), 4),
                     total(beams.field()) / total(reference.field()) - 1};
    fmt::print("  blocks {:.4f}, total {:+.5f}; ledgers {:.1e} {:.1e}\n", c.blocks, c.total,
               beams.result.report.power.imbalance(), beams.result.report.path.imbalance());
    EXPECT_LT(beams.result.report.power.imbalance(), 1e-6);
    EXPECT_LT(beams.result.report.path.imbalance(), 1e-6);
    EXPECT_GT(total(reference.field()), 0);
    return c;
}

void expectAlike(const std::string& toml, double blocks, double all) {
    const Compared c = againstPhotons(toml);
    EXPECT_LT(c.blocks, blocks);
    EXPECT_NEAR(c.total, 0, all);
}

}  // namespace photic
