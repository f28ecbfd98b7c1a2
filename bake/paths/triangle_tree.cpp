// SPDX-License-Identifier: Apache-2.0
#include "bake/paths/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace photic {
namespace {

constexpr std::size_t kLeafTriangles = 4;

// Ten bits, two zeros after each.
std::uint32_t spreadBits(std::uint32_t x) {
    x = (x | x << 16) & 0x030000ff;
    x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3;
    return (x | x << 2) & 0x09249249;
}

std::uint32_t mortonCode(const glm::dvec3& unit) {
    std::uint32_t code = 0;
    for (int a = 0; a < 3; ++a)
        code |= spreadBits(static_cast<std::uint32_t>(std::clamp(unit[a] * 1024, 0.0, 1023.0))) << (2 - a);
    return code;
}

float roundedDown(double x) { return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float roundedUp(double x) { return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

}  // namespace

TriangleTree::TriangleTree(const Scene& scene)
    : low_(std::numeric_limits<double>::infinity()), high_(-std::numeric_limits<double>::infinity()) {
    const auto add = [&](Target target, const std::shared_ptr<const TriangleMesh>& mesh) {
        if (!mesh || mesh->triangles.empty()) return;
        for (std::size_t t = 0; t < mesh->triangles.size(); ++t)
            items_.push_back({static_cast<std::uint32_t>(meshes_.size()), static_cast<std::uint32_t>(t)});
        for (const glm::dvec3& p : mesh->positions) low_ = glm::min(low_, p), high_ = glm::max(high_, p);
        meshes_.push_back({target, mesh});
    };
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
        add({Target::Kind::Surface, static_cast<int>(i)}, scene.surfaces[i].mesh);
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const auto* mesh = std::get_if<std::shared_ptr<const TriangleMesh>>(&scene.objects[i].shape);
        if (mesh && scene.objects[i].blocks()) add({Target::Kind::Object, static_cast<int>(i)}, *mesh);
    }
    if (items_.empty()) return;
    centre_ = 0.5 * (low_ + high_);
    const glm::dvec3 size = glm::max(high_ - low_, glm::dvec3(1e-300));
    std::vector<std::uint32_t> codes(items_.size());
    for (std::size_t i = 0; i < items_.size(); ++i) {
        const auto c = corners(items_[i]);
        codes[i] = mortonCode(((c[0] + c[1] + c[2]) / 3.0 - low_) / size);
    }
    build(std::move(codes));
}

std::array<glm::dvec3, 3> TriangleTree::corners(const Item& item) const {
    const TriangleMesh& mesh = *meshes_[item.mesh].mesh;
    const auto& t = mesh.triangles[item.triangle];
    return {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]};
}

// Sorts the triangles along the Z curve and halves ranges where the highest bit that differs changes.
void TriangleTree::build(std::vector<std::uint32_t> codes) {
    std::vector<std::uint32_t> order(items_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return codes[a] < codes[b]; });
    std::vector<Item> sorted;
    std::vector<std::uint32_t> sorted_codes;
    sorted.reserve(items_.size()), sorted_codes.reserve(items_.size());
    for (const std::uint32_t i : order) sorted.push_back(items_[i]), sorted_codes.push_back(codes[i]);
    items_ = std::move(sorted);

    nodes_.reserve(2 * items_.size() / kLeafTriangles + 2);
    nodes_.emplace_back();
    struct Range {
        std::size_t node, first, last;  // last exclusive
    };
    std::vector<Range> open{{0, 0, items_.size()}};
    while (!open.empty()) {
        const Range range = open.back();
        open.pop_back();
        if (range.last - range.first <= kLeafTriangles) {
            nodes_[range.node].first = static_cast<std::uint32_t>(range.first);
            nodes_[range.node].count = static_cast<std::uint32_t>(range.last - range.first);
            continue;
        }
        const auto from = sorted_codes.begin() + static_cast<std::ptrdiff_t>(range.first);
        const auto to = sorted_codes.begin() + static_cast<std::ptrdiff_t>(range.last);
        std::size_t middle = (range.first + range.last) / 2;
        if (const std::uint32_t differing = *from ^ *(to - 1); differing != 0) {
            std::uint32_t bit = 1u << (31 - __builtin_clz(differing));
            const std::uint32_t limit = (*(to - 1) & ~(bit - 1));
            middle = static_cast<std::size_t>(std::lower_bound(from, to, limit) - sorted_codes.begin());
        }
        const auto child = static_cast<std::uint32_t>(nodes_.size());
        nodes_[range.node].first = child, nodes_[range.node].count = 0;
        nodes_.emplace_back(), nodes_.emplace_back();
        open.push_back({child, range.first, middle}), open.push_back({child + 1, middle, range.last});
    }
    // Children stand behind their parents: boxes are fitted from the back.
    for (std::size_t n = nodes_.size(); n-- > 0;) fit(n);
}

void TriangleTree::fit(std::size_t n) {
    Node& node = nodes_[n];
    for (int a = 0; a < 3; ++a) {
        node.low[a] = std::numeric_limits<float>::infinity(), node.high[a] = -std::numeric_limits<float>::infinity();
        if (node.count == 0) {
            for (const Node* child : {&nodes_[node.first], &nodes_[node.first + 1]})
                node.low[a] = std::min(node.low[a], child->low[a]),
                node.high[a] = std::max(node.high[a], child->high[a]);
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
            for (const glm::dvec3& p : corners(items_[i])) {
                node.low[a] = std::min(node.low[a], roundedDown(p[a] - centre_[a]));
                node.high[a] = std::max(node.high[a], roundedUp(p[a] - centre_[a]));
            }
    }
}

// Calls visit(item) for the triangles of all leaves that may reach into the region, until it returns true.
template <class Visit>
void TriangleTree::visit(const ConvexRegion& region, const Visit& visit) const {
    if (nodes_.empty()) return;
    const auto outside = [&](const Node& node) {
        for (int a = 0; a < 3; ++a)
            if (!(node.low[a] + centre_[a] <= region.high[a] && node.high[a] + centre_[a] >= region.low[a]))
                return true;
        for (std::size_t s = 0; s < region.side_count; ++s) {
            const glm::dvec3& n = region.sides[s].normal;
            double nearest = -region.sides[s].offset;
            for (int a = 0; a < 3; ++a) nearest += n[a] * (centre_[a] + (n[a] > 0 ? node.low[a] : node.high[a]));
            if (nearest > 0) return true;
        }
        return false;
    };
    std::uint32_t stack[96];
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const Node& node = nodes_[stack[--depth]];
        if (outside(node)) continue;
        if (node.count == 0) {
            if (depth + 2 > std::size(stack)) return;
            stack[depth++] = node.first, stack[depth++] = node.first + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
            if (visit(items_[i])) return;
    }
}

bool TriangleTree::reaches(const ConvexRegion& region, Target ignored) const {
    bool found = false;
    visit(region, [&](const Item& item) {
        if (ignored.kind != Target::Kind::Nothing && meshes_[item.mesh].target == ignored) return false;
        areaInside(region, corners(item), {0, 0, 1}, found);
        return found;
    });
    return found;
}

double TriangleTree::shownArea(const ConvexRegion& region, const glm::dvec3& direction) const {
    double towards = 0, away = 0;
    visit(region, [&](const Item& item) {
        const auto c = corners(item);
        bool touches = false;
        const double area = areaInside(region, c, direction, touches);
        (glm::dot(glm::cross(c[1] - c[0], c[2] - c[0]), direction) < 0 ? towards : away) += area;
        return false;
    });
    return std::max(towards, away);
}

void TriangleTree::shade(const ConvexRegion& region, std::span<const RayHit> first, ShadowedPatch& patch) const {
    for (const RayHit& hit : first)
        for (std::uint32_t m = 0; m < meshes_.size(); ++m)
            if (meshes_[m].target == hit.target) patch.shade(corners({m, hit.triangle}));
    if (patch.dark()) return;
    visit(region, [&](const Item& item) {
        patch.shade(corners(item));
        return patch.dark();
    });
}

}  // namespace photic
