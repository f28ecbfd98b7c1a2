// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <string>
#include <vector>

namespace photic {

/// Blocks of 16^3 voxels (16 b ... 16 b + 15 along each axis), some of them marked.
class CoarseBlocks {
public:
    static constexpr int kSide = 16;  ///< fine voxels

    CoarseBlocks() = default;
    /// None marked; `low` to `high` can be.
    CoarseBlocks(const glm::ivec3& low, const glm::ivec3& high);

    void mark(const glm::ivec3& block);
    bool has(const glm::ivec3& block) const;
    bool empty() const { return marked_ == 0; }
    int count() const { return marked_; }

    /// "x,y,z,nx,ny,nz:" and a hexadecimal digit for four blocks, x fastest, the first in the lowest bit:
    /// `coarse_blocks` of docs/schemas/runtime.md.
    std::string text() const;
    /// @throws Error{Input} for what is no such text
    static CoarseBlocks fromText(const std::string& text);

private:
    /// Or -1 outside.
    std::ptrdiff_t flat(const glm::ivec3& block) const;
    glm::ivec3 low_{0}, size_{0};
    std::vector<bool> marks_;
    int marked_ = 0;
};

}  // namespace photic
