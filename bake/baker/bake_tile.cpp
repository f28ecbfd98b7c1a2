// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/bake_tile.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

#include "bake/methods/lobe_axis.h"
#include "bake/report/error.h"

namespace photic {
namespace {

using Json = nlohmann::ordered_json;

/// A box of leaves, and the needed ones in it.
struct LeafBox {
    glm::ivec3 first{0}, last{0};  // in leaves, both inside
    std::vector<int> slots;        // where not everything is needed

    std::int64_t capacity() const {
        const glm::ivec3 size = last - first + 1;
        return std::int64_t{size.x} * size.y * size.z;
    }
};

class TileCutter {
public:
    explicit TileCutter(const NeededVoxels& needed) : needed_(needed), start_(needed.frame().min >> 3) {}

    std::vector<VoxelBox> cut(int count) {
        LeafBox all{start_, needed_.frame().max >> 3, {}};
        if (all.capacity() < count)
            throw Error(
                ErrorCode::Usage,
                fmt::format("{} tiles of a box that has {} blocks of 8^3 voxels; ask for fewer", count, all.capacity()),
                "--tile");
        if (!needed_.isEverything()) {
            all.slots.resize(static_cast<std::size_t>(needed_.leafCount()));
            for (std::size_t i = 0; i < all.slots.size(); ++i) all.slots[i] = static_cast<int>(i);
        }
        split(std::move(all), count);
        return std::move(boxes_);
    }

private:
    // Needed leaves of a box before each of its planes along an axis; the last is all of them.
    std::vector<std::int64_t> leavesBefore(const LeafBox& box, int axis) const {
        const int length = box.last[axis] - box.first[axis] + 1;
        std::vector<std::int64_t> before(static_cast<std::size_t>(length) + 1, 0);
        for (const int slot : box.slots)
            ++before[static_cast<std::size_t>((needed_.leafOrigin(slot)[axis] >> 3) - box.first[axis] + 1)];
        const bool even = box.slots.empty();  // where everything is needed, or nothing
        for (std::size_t i = 1; i < before.size(); ++i) before[i] = even ? std::int64_t(i) : before[i] + before[i - 1];
        return before;
    }

    /// Where a box is cut.
    struct Cut {
        int axis = 0, plane = 1;  // [leaves from the box's first]
        double off = 2;           // by how much of all the halves miss their share
    };

    // The best plane across an axis.
    Cut cutAcross(const LeafBox& box, int axis, double share) const {
        constexpr double kNearlyEven = 0.05;
        const std::vector<std::int64_t> before = leavesBefore(box, axis);
        const auto all = static_cast<double>(std::max<std::int64_t>(before.back(), 1));
        const int length = static_cast<int>(before.size()) - 1, offset = box.first[axis] - start_[axis];
        Cut best{axis, 1, 2};
        for (const int step : {16, 8, 1}) {
            Cut cut{axis, 1, 2};
            for (int plane = 1; plane < length; ++plane) {
                if ((offset + plane) % step != 0) continue;
                const double off =
                    std::fabs(static_cast<double>(before[static_cast<std::size_t>(plane)]) / all - share);
                if (off < cut.off) cut.plane = plane, cut.off = off;
            }
            if (cut.off < best.off) best = cut;
            if (best.off <= kNearlyEven) break;
        }
        return best;
    }

    // Across the longest side that parts the needed leaves well, or else the one that does it best.
    Cut cutOf(const LeafBox& box, double share) const {
        constexpr double kWell = 0.1;
        const glm::ivec3 size = box.last - box.first + 1;
        std::array<int, 3> axes{0, 1, 2};
        std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return size[a] > size[b]; });
        Cut best;
        for (const int axis : axes) {
            if (size[axis] < 2) continue;
            const Cut cut = cutAcross(box, axis, share);
            if (cut.off < best.off) best = cut;
            if (best.off <= kWell) break;
        }
        return best;
    }

    void split(LeafBox box, int count) {
        if (count == 1) {
            const GridFrame& frame = needed_.frame();
            boxes_.push_back({glm::max(box.first * 8, frame.min), glm::min(box.last * 8 + 7, frame.max)});
            return;
        }
        const auto [axis, plane, off] = cutOf(box, static_cast<double>(count / 2) / count);
        LeafBox low = box, high = box;
        low.last[axis] = box.first[axis] + plane - 1, high.first[axis] = box.first[axis] + plane;
        const int side = axis;
        const auto beyond = std::stable_partition(box.slots.begin(), box.slots.end(), [&](int slot) {
            return needed_.leafOrigin(slot)[side] >> 3 <= low.last[side];
        });
        low.slots.assign(box.slots.begin(), beyond), high.slots.assign(beyond, box.slots.end());
        // A half has no more tiles than leaves.
        const auto in_low =
            static_cast<int>(std::clamp<std::int64_t>(count / 2, std::max<std::int64_t>(1, count - high.capacity()),
                                                      std::min<std::int64_t>(count - 1, low.capacity())));
        split(std::move(low), in_low);
        split(std::move(high), count - in_low);
    }

    const NeededVoxels& needed_;
    glm::ivec3 start_;
    std::vector<VoxelBox> boxes_;
};

}  // namespace

std::string Tile::name() const { return fmt::format("{}/{}", index, count); }

std::vector<VoxelBox> tileBoxes(const NeededVoxels& needed, int count) { return TileCutter(needed).cut(count); }

std::string tileRefusal(const Scene& scene, const Method& method, const GridFrame& frame,
                        const std::vector<std::string>& post) {
    if (!method.tile_reach || method.tile_reach(scene, frame, givenOptions(scene, method)) < 0)
        return fmt::format(
            "method '{}' {} needs the whole box at once; bake the frame whole, and share out frames instead",
            method.name, method.tile_reach ? "with these options" : "");
    if (scene.bake.prefilter)
        return "the prefilter reaches from end to end of the light, and would not be the same; bake with "
               "--no-prefilter";
    if (!post.empty()) return "--post works on the whole volume; use photic post on the one that is merged";
    return {};
}

int tileMargin(const Scene& scene, const Method& method, const GridFrame& frame) {
    const int reach = method.tile_reach(scene, frame, givenOptions(scene, method));
    // Whether a leaf keeps a second lobe depends on the leaves around it.
    const bool lobes =
        scene.bake.lobes > 1 && scene.bake.grids.direction && (scene.bake.lobe_axis || lightCanOppose(scene));
    constexpr int kLeaf = 8;
    return (reach + kLeaf - 1) / kLeaf + (lobes ? 1 : 0);
}

std::shared_ptr<const NeededVoxels> cutTile(const Scene& scene, const Method& method,
                                            std::shared_ptr<const NeededVoxels> whole, const Tile& tile,
                                            const std::vector<std::string>& post) {
    const std::string why = tileRefusal(scene, method, whole->frame(), post);
    if (!why.empty()) throw Error(ErrorCode::Usage, "this bake cannot be cut to tiles: " + why, "--tile");
    const std::vector<VoxelBox> boxes = tileBoxes(*whole, tile.count);
    const int margin = tileMargin(scene, method, whole->frame());
    return std::make_shared<const NeededVoxels>(
        NeededVoxels::partOf(std::move(whole), boxes[static_cast<std::size_t>(tile.index - 1)], margin));
}

std::string tileText(const NeededVoxels& part, const Tile& tile) {
    const auto list = [](const glm::ivec3& v) { return Json{v.x, v.y, v.z}; };
    return Json{
        {"index", tile.index}, {"count", tile.count}, {"min", list(part.tile().min)}, {"max", list(part.tile().max)}}
        .dump();
}

std::optional<PlacedTile> readTile(const std::string& text) {
    try {
        const Json json = Json::parse(text);
        const auto point = [&](const char* name) {
            const Json& v = json.at(name);
            return glm::ivec3(v.at(0).get<int>(), v.at(1).get<int>(), v.at(2).get<int>());
        };
        PlacedTile placed{{json.at("index").get<int>(), json.at("count").get<int>()}, {point("min"), point("max")}};
        const Tile& tile = placed.tile;
        if (tile.count < 1 || tile.index < 1 || tile.index > tile.count) return {};
        return placed;
    } catch (const Json::exception&) {
        return {};
    }
}

}  // namespace photic
