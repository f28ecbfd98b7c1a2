// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bake/file/checked_file.h"
#include "bake/volume/vdb_layout.h"

namespace photic {

/// Writes the bytes of a grid's leaf number i, mostBytesOfLeaf() of them at most, and returns how many. Called from
/// several threads.
using EncodeLeaf = std::function<std::size_t(std::int64_t i, char* to)>;

/// A grid to be written.
struct GridSource {
    VdbGridLayout layout;
    const std::vector<VdbTopology>* leaves;  ///< in tree order
    EncodeLeaf encode;
};

/// A volume's metadata (without the `photic:` prefix) as it stands in its file, in the types of the contract.
VdbValues fileMetadata(const std::map<std::string, std::string>& metadata, double reference_irradiance,
                       std::int64_t clamped);

/// Writes the grids behind one another, and reads back every byte. Bytes depend on what is written alone.
/// @param metadata  of the file, asked before the leaves and after them: its numbers may change meanwhile, its size may
///                  not
/// @throws Error{Failed}
void writeGrids(CheckedFile& file, std::vector<GridSource>& grids, const std::function<VdbValues()>& metadata);

}  // namespace photic
