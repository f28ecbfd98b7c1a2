// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include "bake/field/needed_voxels.h"
#include "bake/file/vdb.h"
#include "bake/image/atomic_file.h"
#include "bake/report/error.h"
#include "runtime/format/light_volume_format.h"

namespace photic {
namespace {

constexpr int kVoxels = LightField::kLeafVoxels;
constexpr std::uint64_t kLargestTiles = std::uint64_t{1}
                                        << 26;  // voxels in tiles that are expanded: 1 GiB with direction

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw Error(ErrorCode::Input, fmt::format("cannot read {}: {}", path, why), path);
}

// All grids of a file. A stream that throws at its end: OpenVDB itself does not look whether a read came up short.
openvdb::GridPtrVecPtr readGrids(const std::string& path, openvdb::MetaMap::Ptr& meta) {
    checkReadable(path);
    std::vector<char> buffer(std::size_t{1} << 17);
    std::ifstream in;
    in.rdbuf()->pubsetbuf(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    in.open(path, std::ios::binary);
    if (!in) refuse(path, fmt::format("{}; give the path of a .vdb file", std::strerror(errno)));
    std::int32_t magic = 0;
    if (!in.read(reinterpret_cast<char*>(&magic), sizeof(magic)) || magic != openvdb::OPENVDB_MAGIC)
        refuse(path, "it is no .vdb file");
    in.seekg(0);
    in.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
    try {
        openvdb::io::Stream stream(in, false);
        meta = stream.getMetadata();
        return stream.getGrids();
    } catch (const std::ios_base::failure&) {
        refuse(path, "it ends too soon; write or copy it again");
    } catch (const openvdb::Exception& e) {
        refuse(path, fmt::format("it is damaged or of an unknown version ({})", e.what()));
    } catch (const std::bad_alloc&) {
        refuse(path, "it is damaged, or larger than memory");
    } catch (const std::length_error&) {
        refuse(path, "it is damaged");
    }
}

std::string gridNames(const openvdb::GridPtrVec& grids) {
    std::vector<std::string> names;
    for (const auto& g : grids)
        names.push_back(fmt::format("{} ({})", g->getName().empty() ? "unnamed" : g->getName(), g->valueType()));
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

// Leaves instead of tiles, as long as they are not too many.
template <class Grid>
void expandTiles(const std::string& path, Grid& grid) {
    const std::uint64_t in_tiles = grid.tree().activeVoxelCount() - grid.tree().activeLeafVoxelCount();
    if (in_tiles == 0) return;
    if (in_tiles > kLargestTiles)
        refuse(path, fmt::format("grid {} holds {} voxels in tiles, more than the {} that are expanded; crop it",
                                 grid.getName(), in_tiles, kLargestTiles));
    grid.tree().voxelizeActiveTiles();
}

GridFrame frameOf(const std::string& path, const openvdb::GridBase& grid) {
    if (!grid.transform().isLinear())
        refuse(path, fmt::format("grid {} has a perspective transform; resample it to a linear one", grid.getName()));
    const auto mat = grid.transform().baseMap()->getAffineMap()->getMat4();
    GridFrame frame;
    glm::dmat3 world_from_index;
    for (int axis = 0; axis < 3; ++axis) world_from_index[axis] = {mat(axis, 0), mat(axis, 1), mat(axis, 2)};
    frame.setWorldFromIndex(world_from_index);
    frame.origin_world = {mat(3, 0), mat(3, 1), mat(3, 2)};
    if (!(frame.voxelVolume() > 0) || !std::isfinite(frame.voxelVolume()))
        refuse(path, fmt::format("grid {} has voxels of no volume", grid.getName()));
    return frame;
}

std::string textOf(const openvdb::Metadata& meta) {
    // Numbers with all their digits: str() gives six.
    if (meta.typeName() == openvdb::DoubleMetadata::staticTypeName())
        return fmt::format("{}", static_cast<const openvdb::DoubleMetadata&>(meta).value());
    if (meta.typeName() == openvdb::FloatMetadata::staticTypeName())
        return fmt::format("{}", static_cast<const openvdb::FloatMetadata&>(meta).value());
    return meta.str();
}

void readMetadata(const openvdb::MetaMap& from, std::map<std::string, std::string>& to) {
    const std::string prefix = format::kPrefix;
    for (auto it = from.beginMeta(); it != from.endMeta(); ++it)
        if (it->first.compare(0, prefix.size(), prefix) == 0) to[it->first.substr(prefix.size())] = textOf(*it->second);
}

// The grids that make a light volume; null where there is none.
struct KnownGrids {
    openvdb::FloatGrid::Ptr white;
    openvdb::Vec3SGrid::Ptr coloured, direction;
    std::map<std::string, openvdb::FloatGrid::Ptr> scalars;
    std::vector<openvdb::GridBase::Ptr> all;
};

KnownGrids findGrids(const std::string& path, const openvdb::GridPtrVec& grids) {
    KnownGrids known;
    const auto wrongType = [&](const openvdb::GridBase& grid, const char* wanted) {
        refuse(path, fmt::format("grid {} holds {}, not {}", grid.getName(), grid.valueType(), wanted));
    };
    for (const auto& grid : grids) {
        const std::string name = grid->getName();
        const auto white = openvdb::GridBase::grid<openvdb::FloatGrid>(grid);
        const auto vectors = openvdb::GridBase::grid<openvdb::Vec3SGrid>(grid);
        if (name == format::kIrradiance) {
            if (!white && !vectors) wrongType(*grid, "float or vec3s");
            known.white = white, known.coloured = vectors;
        } else if (name == format::kDirection) {
            if (!vectors) wrongType(*grid, "vec3s");
            known.direction = vectors;
        } else if (name == format::kCaustic || name == format::kArrivalTime || name == format::kDensity) {
            if (!white) wrongType(*grid, "float");
            known.scalars[name] = white;
        } else {
            continue;
        }
        if (white) expandTiles(path, *white);
        if (vectors) expandTiles(path, *vectors);
        known.all.push_back(grid);
    }
    if (!known.white && !known.coloured && known.scalars.empty())
        refuse(path, fmt::format("it holds no light: looked for irradiance, density, caustic or arrival_time, found {}",
                                 gridNames(grids)));
    return known;
}

template <class Grid>
void addActive(NeededVoxels& needed, const Grid& grid) {
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        NeededVoxels::Mask mask;
        for (std::size_t w = 0; w < 8; ++w)
            mask[w] = leaf->getValueMask().template getWord<std::uint64_t>(static_cast<openvdb::Index>(w));
        needed.addLeaf({leaf->origin().x(), leaf->origin().y(), leaf->origin().z()}, mask);
    }
}

std::shared_ptr<const NeededVoxels> activeVoxels(const std::string& path, const KnownGrids& known) {
    GridFrame frame = frameOf(path, *known.all.front());
    openvdb::CoordBBox box;
    for (const auto& grid : known.all) {
        const GridFrame other = frameOf(path, *grid);
        double difference = glm::length(other.origin_world - frame.origin_world);
        for (int a = 0; a < 3; ++a)
            difference = std::max(difference, glm::length(other.worldFromIndex()[a] - frame.worldFromIndex()[a]));
        if (difference > 1e-6 * std::cbrt(frame.voxelVolume()))
            refuse(path, fmt::format("grids {} and {} have different transforms; a light volume has one",
                                     known.all.front()->getName(), grid->getName()));
        box.expand(grid->evalActiveVoxelBoundingBox());
    }
    if (box.empty()) box = openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(0));
    frame.min = {box.min().x(), box.min().y(), box.min().z()},
    frame.max = {box.max().x(), box.max().y(), box.max().z()};
    NeededVoxels needed = NeededVoxels::none(frame);
    if (known.white) addActive(needed, *known.white);
    if (known.coloured) addActive(needed, *known.coloured);
    if (known.direction) addActive(needed, *known.direction);
    for (const auto& [name, grid] : known.scalars) addActive(needed, *grid);
    needed.finish();
    return std::make_shared<const NeededVoxels>(std::move(needed));
}

const openvdb::FloatGrid::TreeType::LeafNodeType* leafAt(const openvdb::FloatGrid::Ptr& grid, const glm::ivec3& o) {
    return grid ? grid->constTree().probeConstLeaf(openvdb::Coord(o.x, o.y, o.z)) : nullptr;
}
const openvdb::Vec3SGrid::TreeType::LeafNodeType* leafAt(const openvdb::Vec3SGrid::Ptr& grid, const glm::ivec3& o) {
    return grid ? grid->constTree().probeConstLeaf(openvdb::Coord(o.x, o.y, o.z)) : nullptr;
}

void fillLight(LightField& field, const KnownGrids& known, float reference) {
    forEachLeaf(field.needed(), [&](int slot) {
        const glm::ivec3 origin = field.needed().leafOrigin(slot);
        const auto* white = leafAt(known.white, origin);
        const auto* coloured = leafAt(known.coloured, origin);
        if (white == nullptr && coloured == nullptr) return;
        const auto* direction = leafAt(known.direction, origin);
        float* data = field.makeDense(slot);
        float* flux = data + field.channels().irradiance * kVoxels;
        for (int i = 0; i < kVoxels; ++i) {
            const auto n = static_cast<openvdb::Index>(i);
            float mean = 0;
            if (white != nullptr && white->isValueOn(n)) mean = data[i] = white->getValue(n) * reference;
            if (coloured != nullptr && coloured->isValueOn(n)) {
                const openvdb::Vec3f v = coloured->getValue(n) * reference;
                for (int c = 0; c < 3; ++c) data[c * kVoxels + i] = v[c];
                mean = (v[0] + v[1] + v[2]) * (1.0f / 3);
            }
            if (direction == nullptr || !direction->isValueOn(n)) continue;
            const openvdb::Vec3f d = direction->getValue(n);
            for (int a = 0; a < 3; ++a) flux[a * kVoxels + i] = mean * d[a];
        }
    });
}

LightField scalarField(const openvdb::FloatGrid::Ptr& grid, const std::shared_ptr<const NeededVoxels>& needed) {
    LightField field(needed, {1, false});
    forEachLeaf(*needed, [&](int slot) {
        const auto* leaf = leafAt(grid, needed->leafOrigin(slot));
        if (leaf == nullptr) return;
        float* data = field.makeDense(slot);
        for (int i = 0; i < kVoxels; ++i)
            data[i] =
                leaf->isValueOn(static_cast<openvdb::Index>(i)) ? leaf->getValue(static_cast<openvdb::Index>(i)) : 0.0f;
    });
    return field;
}

double referenceOf(const std::string& path, const std::map<std::string, std::string>& metadata) {
    const auto at = metadata.find(format::kMetaReferenceIrradiance + std::strlen(format::kPrefix));
    if (at == metadata.end()) return 1;
    double reference = 0;
    try {
        reference = std::stod(at->second);
    } catch (const std::logic_error&) {
        reference = 0;
    }
    if (!(reference > 0) || !std::isfinite(reference))
        refuse(path, fmt::format("its reference irradiance is \"{}\", not a positive number", at->second));
    return reference;
}

}  // namespace

LightVolume readVdb(const std::string& path) {
    openvdb::initialize();
    openvdb::MetaMap::Ptr file_meta;
    const openvdb::GridPtrVecPtr grids = readGrids(path, file_meta);
    const KnownGrids known = findGrids(path, *grids);

    // What a grid says wins: files that were merged or cut keep it.
    std::map<std::string, std::string> metadata;
    if (file_meta) readMetadata(*file_meta, metadata);
    for (const auto& grid : known.all) readMetadata(*grid, metadata);
    if (const auto version = metadata.find("version");
        version != metadata.end() && std::atoi(version->second.c_str()) > format::kVersion)
        refuse(path, fmt::format("its format is version {}, this program knows up to {}; use a newer one",
                                 version->second, format::kVersion));

    const double reference = referenceOf(path, metadata);
    const auto needed = activeVoxels(path, known);
    LightVolume volume{LightField(needed, {known.coloured ? 3 : 1, known.direction != nullptr}),
                       reference,
                       known.white || known.coloured,
                       known.direction != nullptr,
                       {},
                       std::move(metadata)};
    fillLight(volume.field, known, static_cast<float>(reference));
    for (const auto& [name, grid] : known.scalars) volume.scalars.emplace(name, scalarField(grid, needed));
    return volume;
}

}  // namespace photic
