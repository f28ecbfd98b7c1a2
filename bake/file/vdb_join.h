// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bake/file/checked_file.h"
#include "bake/volume/vdb_layout.h"

namespace photic {

/// A light volume's file without its values: what there is to say of it, where its voxels are, and where in the file
/// the bytes of each leaf stand. About a hundred bytes for each leaf and grid.
class VdbPart {
public:
    struct Grid {
        VdbGridLayout layout;
        std::vector<VdbTopology> leaves;
        struct Bytes {
            std::int64_t at = 0;
            std::uint32_t size = 0;
        };
        std::vector<Bytes> bytes;  ///< of each leaf
    };

    /// Reads a file, and keeps none of its values.
    /// @param name  that messages call it
    /// @throws Error{Input} as readVdb(), and for a grid that is not made of leaves of floats
    VdbPart(const std::string& path, std::string name);

    const std::string& path() const { return path_; }
    const std::string& name() const { return name_; }
    const std::map<std::string, std::string>& metadata() const { return metadata_; }  ///< without the `photic:` prefix
    /// Its grids by name; of a dark one, those with the one voxel that stands for nothing.
    const std::vector<Grid>& grids() const { return grids_; }
    const Grid* grid(const std::string& name) const;
    bool dark() const { return dark_; }

private:
    std::string path_, name_;
    std::map<std::string, std::string> metadata_;
    std::vector<Grid> grids_;
    bool dark_ = false;
};

/// Writes one file of all leaves of several, their bytes as they are. Dark parts add nothing, unless all are. The bytes
/// are those that writeVdb() would write of the whole.
/// @param parts     whose grids are stored alike and have no leaf in common
/// @param metadata  of the result
/// @return active voxels
/// @throws Error{Input} naming two parts that hold the same leaf, or one that changes meanwhile; Error{Failed}
std::int64_t joinVdb(CheckedFile& file, const std::vector<std::unique_ptr<VdbPart>>& parts,
                     const std::map<std::string, std::string>& metadata, double reference_irradiance,
                     std::int64_t clamped);

}  // namespace photic
