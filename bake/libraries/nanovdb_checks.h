// SPDX-License-Identifier: Apache-2.0
/// NanoVDB 32.4 to 32.9: its own checks of a grid, and its way back to OpenVDB.
#pragma once

#if __has_include(<nanovdb/tools/GridValidator.h>)
#include <nanovdb/tools/GridValidator.h>
#include <nanovdb/tools/NanoToOpenVDB.h>
namespace photic::nano {
namespace checks = nanovdb::tools;
}
#else
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/NanoToOpenVDB.h>
namespace photic::nano {
namespace checks = nanovdb;
}
#endif

namespace photic::nano {

/// What NanoVDB says of a grid, checksum and all; it prints what is wrong.
template <class Build>
bool isValid(const nanovdb::NanoGrid<Build>& grid) {
    return checks::isValid(grid, true, true);
}

/// The same grid, as OpenVDB has it.
template <class Build>
openvdb::GridBase::Ptr toOpenVdb(const nanovdb::NanoGrid<Build>& grid) {
    return checks::nanoToOpenVDB(grid);
}

}  // namespace photic::nano
