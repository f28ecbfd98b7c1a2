// SPDX-License-Identifier: Apache-2.0
#include "runtime/src/shape_tree.h"

#include <algorithm>
#include <limits>

namespace photic::runtime {

void ShapeTree::Box::add(const std::array<float, 3>& p) {
    for (std::size_t a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
}
void ShapeTree::Box::add(const Box& other) {
    add(other.low);
    add(other.high);
}
double ShapeTree::Box::area() const {
    double side[3];
    for (std::size_t a = 0; a < 3; ++a) side[a] = std::max(double(high[a]) - double(low[a]), 0.0);
    return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
}

ShapeTree::ShapeTree(const SharpShape& mesh) {
    std::vector<Item> items;
    items.reserve(mesh.triangles.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        Item item;
        for (const std::uint32_t v : mesh.triangles[t]) item.box.add(mesh.positions[v]);
        for (std::size_t a = 0; a < 3; ++a) item.middle[a] = 0.5F * item.box.low[a] + 0.5F * item.box.high[a];
        item.triangle = t;
        items.push_back(item);
    }
    const Child root = build(items, 0, items.size(), 0);
    // So few triangles that they are one leaf: the root has it on one side, and none on the other.
    if (root.to < 0) nodes.push_back({root, Child{root.box, ~0}});
}

ShapeTree::Child ShapeTree::build(std::vector<Item>& items, std::size_t begin, std::size_t end, int depth) {
    Child child;
    for (std::size_t i = begin; i < end; ++i) child.box.add(items[i].box);
    if (end - begin <= kMostInLeaf) {
        child.to = ~static_cast<std::int32_t>(8 * order.size() + (end - begin));
        for (std::size_t i = begin; i < end; ++i) order.push_back(items[i].triangle);
        return child;
    }
    // Halves from here on: 2^21 triangles are in leaves 19 nodes further down.
    constexpr int kByArea = 10;
    const std::size_t middle = split(items, begin, end, depth >= kByArea);
    child.to = static_cast<std::int32_t>(nodes.size());
    nodes.emplace_back();
    const Child left = build(items, begin, middle, depth + 1), right = build(items, middle, end, depth + 1);
    nodes[static_cast<std::size_t>(child.to)] = {left, right};
    return child;
}

std::size_t ShapeTree::split(std::vector<Item>& items, std::size_t begin, std::size_t end, bool halves) {
    constexpr std::size_t kBins = 16;
    Box middles;
    for (std::size_t i = begin; i < end; ++i) middles.add(items[i].middle);
    const auto width = [&](std::size_t a) { return middles.high[a] - middles.low[a]; };
    std::size_t axis = 0;
    for (const std::size_t a : {std::size_t{1}, std::size_t{2}})
        if (width(a) > width(axis)) axis = a;
    const auto binOf = [&](const Item& item) {
        const float share = (item.middle[axis] - middles.low[axis]) / width(axis);
        return std::min(static_cast<std::size_t>(share * float{kBins}), kBins - 1);
    };
    const auto first = items.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = items.begin() + static_cast<std::ptrdiff_t>(end);
    if (!halves && width(axis) > 0) {
        std::array<Box, kBins> boxes;
        std::array<std::size_t, kBins> counts{};
        for (auto item = first; item != last; ++item) boxes[binOf(*item)].add(item->box), ++counts[binOf(*item)];
        std::array<double, kBins> behind{};
        Box box;
        std::size_t count = 0;
        for (std::size_t b = kBins - 1; b > 0; --b) {
            if (counts[b] > 0) box.add(boxes[b]);
            count += counts[b];
            behind[b] = count > 0 ? static_cast<double>(count) * box.area() : 0;
        }
        double least = std::numeric_limits<double>::infinity();
        std::size_t best = 0;
        box = {}, count = 0;
        for (std::size_t b = 0; b + 1 < kBins; ++b) {
            if (counts[b] > 0) box.add(boxes[b]);
            count += counts[b];
            if (count == 0 || count == end - begin) continue;
            const double cost = static_cast<double>(count) * box.area() + behind[b + 1];
            if (cost < least) least = cost, best = b;
        }
        const auto middle = std::partition(first, last, [&](const Item& item) { return binOf(item) <= best; });
        if (middle != first && middle != last) return static_cast<std::size_t>(middle - items.begin());
    }
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(
        first, items.begin() + static_cast<std::ptrdiff_t>(middle), last, [axis](const Item& a, const Item& b) {
            return a.middle[axis] != b.middle[axis] ? a.middle[axis] < b.middle[axis] : a.triangle < b.triangle;
        });
    return middle;
}

}  // namespace photic::runtime
