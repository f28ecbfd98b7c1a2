// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "bake/paths/path.h"

namespace photic {

/// Values that stay where they are while more come, a few hundred an allocation.
template <class T>
class StablePool {
public:
    /// A value as it is by default, or as it was left before clear().
    T& add() {
        if (count_ == kChunk * chunks_.size()) chunks_.push_back(std::make_unique<std::array<T, kChunk>>());
        T& value = (*chunks_[count_ / kChunk])[count_ % kChunk];
        ++count_;
        return value;
    }
    T& operator[](std::size_t i) { return (*chunks_[i / kChunk])[i % kChunk]; }
    std::size_t size() const { return count_; }
    void clear() { count_ = 0; }

private:
    static constexpr std::size_t kChunk = 256;
    std::vector<std::unique_ptr<std::array<T, kChunk>>> chunks_;
    std::size_t count_ = 0;
};

/// The edges that a refiner has met, by the middle's parameter: an open table of numbers, probed in turn. A block of
/// cells has some hundred edges and there are thousands of blocks, so its memory is kept for the next one.
class EdgeTable {
public:
    struct Edge {
        const Path* middle = nullptr;  ///< null: not traced
        bool split = false;
    };

    EdgeTable();
    /// The edge of a middle, which stays where it is until clear(). @param fresh  whether it was not met before
    Edge& at(const EmissionParam& middle, bool& fresh);
    /// Keeps a path until clear().
    const Path& keep(const Path& path) { return paths_.add() = path; }
    void clear();
    /// Whether so many were met that the memory is better given back.
    bool isLarge() const;

private:
    struct Entry {
        EmissionParam middle;
        Edge edge;
    };
    /// The hash stands beside the entry's number: in a large table each look at an entry waits for memory, and this one
    /// tells nearly all others apart.
    struct Place {
        std::uint32_t entry = 0;  ///< and 1 more; 0: free
        std::uint32_t hash = 0;
    };
    void grow();

    std::vector<Place> places_;
    StablePool<Entry> entries_;
    StablePool<Path> paths_;
};

/// A table for as long as it stands, whose memory the next one on this thread takes over.
class LentEdgeTable {
public:
    LentEdgeTable();
    ~LentEdgeTable();
    LentEdgeTable(const LentEdgeTable&) = delete;
    LentEdgeTable& operator=(const LentEdgeTable&) = delete;
    EdgeTable* operator->() { return table_.get(); }

private:
    std::unique_ptr<EdgeTable> table_;
};

}  // namespace photic
