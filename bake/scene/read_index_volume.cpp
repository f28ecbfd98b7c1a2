// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <cmath>
#include <set>
#include <sstream>

#include "bake/report/error.h"
#include "bake/scene/index_volume.h"

namespace photic {
namespace {

constexpr std::int64_t kMostVoxels = std::int64_t{1} << 28;  // 1 GiB of samples

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("cannot read the index volume '{}': {}", path, why));
}

openvdb::GridPtrVec gridsOf(const std::string& path, const std::string& bytes) {
    std::int32_t magic = 0;
    if (bytes.size() > sizeof(magic)) std::memcpy(&magic, bytes.data(), sizeof(magic));
    if (magic != openvdb::OPENVDB_MAGIC) refuse(path, "it is no .vdb file");
    openvdb::initialize();
    std::istringstream in(bytes);
    // OpenVDB itself does not look whether a read came up short.
    in.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
    try {
        return *openvdb::io::Stream(in, false).getGrids();
    } catch (const std::ios_base::failure&) {
        refuse(path, "it ends too soon; write or copy it again");
    } catch (const openvdb::Exception& e) {
        refuse(path, fmt::format("it is damaged or of an unknown version ({})", e.what()));
    } catch (const std::exception&) {
        refuse(path, "it is damaged, or larger than memory");
    }
}

openvdb::FloatGrid::ConstPtr chooseGrid(const std::string& path, const openvdb::GridPtrVec& grids,
                                        const std::string& name) {
    static const std::set<std::string> usual{"ior", "index", "n"};
    std::vector<std::string> names;
    std::vector<openvdb::FloatGrid::ConstPtr> fitting, floats;
    for (const auto& grid : grids) {
        names.push_back(
            fmt::format("{} ({})", grid->getName().empty() ? "unnamed" : grid->getName(), grid->valueType()));
        const auto values = openvdb::gridConstPtrCast<openvdb::FloatGrid>(grid);
        if (!values) continue;
        floats.push_back(values);
        if (name.empty() ? usual.count(grid->getName()) > 0 : grid->getName() == name) fitting.push_back(values);
    }
    if (fitting.empty() && name.empty() && floats.size() == 1) fitting = floats;
    if (fitting.size() == 1) return fitting.front();
    const std::string all = names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
    if (fitting.size() > 1)
        refuse(path, fmt::format("several of its grids fit; name one with 'grid'. It holds {}", all));
    if (name.empty())
        refuse(path,
               fmt::format("no float grid of it is called ior, index or n; name one with 'grid'. It holds {}", all));
    refuse(path, fmt::format("it has no float grid '{}'. It holds {}", name, all));
}

}  // namespace

IndexVolume readIndexVolume(const std::string& path, const std::string& bytes, const std::string& name, double medium,
                            Monitor& monitor) {
    const openvdb::GridPtrVec grids = gridsOf(path, bytes);
    const auto grid = chooseGrid(path, grids, name);
    if (!grid->transform().isLinear())
        refuse(path, fmt::format("grid {} has a perspective transform; resample it to a linear one", grid->getName()));
    const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    if (box.empty() || grid->activeVoxelCount() == 0)
        refuse(path, fmt::format("grid {} has no active voxel", grid->getName()));
    const openvdb::Coord size = box.dim();
    if (double(size.x()) * size.y() * size.z() > double(kMostVoxels))
        refuse(path,
               fmt::format("grid {} spans {} x {} x {} voxels, more than the {} that are read; crop or coarsen it",
                           grid->getName(), size.x(), size.y(), size.z(), kMostVoxels));

    if (grid->saveFloatAsHalf())
        monitor.warn(fmt::format(
            "'{}': grid {} is stored as half floats, which hold an index near 1.33 to 0.001: light bends at "
            "its steps; save 32-bit floats",
            path, grid->getName()));

    IndexVolume::Samples samples;
    const auto mat = grid->transform().baseMap()->getAffineMap()->getMat4();
    for (int axis = 0; axis < 3; ++axis) samples.world_from_index[axis] = {mat(axis, 0), mat(axis, 1), mat(axis, 2)};
    const openvdb::Vec3d origin = grid->transform().indexToWorld(box.min());
    samples.origin_world = {origin.x(), origin.y(), origin.z()};
    samples.size = {size.x(), size.y(), size.z()};
    samples.values.assign(std::size_t(size.x()) * std::size_t(size.y()) * std::size_t(size.z()),
                          std::numeric_limits<float>::quiet_NaN());
    const auto put = [&](const openvdb::Coord& c, float n) {
        const openvdb::Coord p = c - box.min();
        samples.values[(std::size_t(p.z()) * std::size_t(size.y()) + std::size_t(p.y())) * std::size_t(size.x()) +
                       std::size_t(p.x())] = n;
    };
    for (auto it = grid->cbeginValueOn(); it; ++it) {
        const float n = *it;
        if (!(double(n) >= kLeastIndex && double(n) <= kLargestIndex))
            refuse(path, fmt::format("voxel ({}, {}, {}) of grid {} is {}; an index must lie between {} and {}",
                                     it.getCoord().x(), it.getCoord().y(), it.getCoord().z(), grid->getName(), n,
                                     kLeastIndex, kLargestIndex));
        openvdb::CoordBBox covered;
        it.getBoundingBox(covered);
        for (auto c = covered.begin(); c; ++c) put(*c, n);
    }
    return {std::move(samples), medium};
}

}  // namespace photic
