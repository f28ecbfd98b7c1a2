// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "runtime/src/sharp_shape.h"

namespace photic::runtime {

/// A binary tree of boxes around the triangles of a mesh, split where the surface area heuristic says (Wald, On fast
/// Construction of SAH-based Bounding Volume Hierarchies, RT 2007). Each node holds the boxes of its two children.
struct ShapeTree {
    static constexpr int kMostDeep = 30;             ///< nodes on the way to a leaf
    static constexpr std::uint32_t kMostInLeaf = 4;  ///< triangles

    struct Box {
        std::array<float, 3> low{1e30F, 1e30F, 1e30F}, high{-1e30F, -1e30F, -1e30F};
        void add(const std::array<float, 3>& p);
        void add(const Box& other);
        double area() const;
    };
    struct Child {
        Box box;
        /// A node's number; of a leaf the complement of 8 times its first place in `order` plus how many triangles.
        std::int32_t to = ~0;
    };
    std::vector<std::array<Child, 2>> nodes;  ///< the first one is the root
    std::vector<std::uint32_t> order;         ///< triangles, as leaves have them

    explicit ShapeTree(const SharpShape& mesh);

private:
    struct Item {
        Box box;
        std::array<float, 3> middle;
        std::uint32_t triangle;
    };
    Child build(std::vector<Item>& items, std::size_t begin, std::size_t end, int depth);
    static std::size_t split(std::vector<Item>& items, std::size_t begin, std::size_t end, bool halves);
};

}  // namespace photic::runtime
