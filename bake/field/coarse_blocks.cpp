// SPDX-License-Identifier: Apache-2.0
#include "bake/field/coarse_blocks.h"

#include <cstdio>

#include "bake/report/error.h"

namespace photic {

CoarseBlocks::CoarseBlocks(const glm::ivec3& low, const glm::ivec3& high) : low_(low), size_(high - low + 1) {
    marks_.assign(
        static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y) * static_cast<std::size_t>(size_.z),
        false);
}

std::ptrdiff_t CoarseBlocks::flat(const glm::ivec3& block) const {
    const glm::ivec3 at = block - low_;
    for (int a = 0; a < 3; ++a)
        if (at[a] < 0 || at[a] >= size_[a]) return -1;
    return (std::ptrdiff_t{at.z} * size_.y + at.y) * size_.x + at.x;
}

void CoarseBlocks::mark(const glm::ivec3& block) {
    const auto at = static_cast<std::size_t>(flat(block));
    marked_ += !marks_[at];
    marks_[at] = true;
}

bool CoarseBlocks::has(const glm::ivec3& block) const {
    if (marked_ == 0) return false;
    const std::ptrdiff_t at = flat(block);
    return at >= 0 && marks_[static_cast<std::size_t>(at)];
}

std::string CoarseBlocks::text() const {
    char head[96];
    std::snprintf(head, sizeof(head), "%d,%d,%d,%d,%d,%d:", low_.x, low_.y, low_.z, size_.x, size_.y, size_.z);
    std::string out = head;
    for (std::size_t i = 0; i < marks_.size(); i += 4) {
        unsigned digit = 0;
        for (std::size_t bit = 0; bit < 4 && i + bit < marks_.size(); ++bit)
            digit |= static_cast<unsigned>(marks_[i + bit]) << bit;
        out.push_back("0123456789abcdef"[digit]);
    }
    return out;
}

CoarseBlocks CoarseBlocks::fromText(const std::string& text) {
    glm::ivec3 low(0), size(0);
    int used = 0;
    const auto damaged = [] { throw Error(ErrorCode::Input, "is no list of blocks", "coarse_blocks"); };
    if (std::sscanf(text.c_str(), "%d,%d,%d,%d,%d,%d:%n", &low.x, &low.y, &low.z, &size.x, &size.y, &size.z, &used) !=
            6 ||
        used == 0)
        damaged();
    constexpr int kMost = 1 << 20;
    double blocks = 1;
    for (int a = 0; a < 3; ++a) {
        if (size[a] < 1 || size[a] > kMost || low[a] < -(1 << 28) || low[a] > 1 << 28) damaged();
        blocks *= size[a];
    }
    const std::string digits = text.substr(static_cast<std::size_t>(used));
    if (static_cast<double>(digits.size()) * 4 < blocks) damaged();
    CoarseBlocks out(low, low + size - 1);
    std::size_t i = 0;
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x, ++i) {
                const char c = digits[i / 4];
                const unsigned digit = c >= '0' && c <= '9'   ? static_cast<unsigned>(c - '0')
                                       : c >= 'a' && c <= 'f' ? static_cast<unsigned>(c - 'a' + 10)
                                                              : 16;
                if (digit > 15) damaged();
                if (digit >> (i % 4) & 1) out.mark(low + glm::ivec3(x, y, z));
            }
    return out;
}

}  // namespace photic
