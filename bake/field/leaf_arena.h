// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

namespace photic {

/// Memory for many items of one size, carved from large chunks: 64-byte aligned, zero when fresh, thread-safe.
/// Chunks are mapped on 2 MiB borders with huge pages where the system has them: first touch of a field is dominated
/// by page faults otherwise. Nothing is resident before it is touched. Up to 512 MiB of chunks that are given back wait
/// for the next arena: the frames of a sequence use the same memory.
class LeafArena {
public:
    /// @param item_bytes  multiple of 64
    /// @param max_items   that will ever be asked for at once; bounds the size of a chunk
    LeafArena(std::size_t item_bytes, std::int64_t max_items);
    ~LeafArena();
    LeafArena(const LeafArena&) = delete;
    LeafArena& operator=(const LeafArena&) = delete;

    /// @param zeroed  set when the item is known to hold zeros
    /// @throws Error{Failed} with figures when memory runs out
    void* allocate(bool& zeroed);
    /// Takes an item back for later use.
    void release(void* item);
    /// Bytes handed out so far, released items included.
    std::int64_t bytes() const;

private:
    struct Chunk {
        void* mapping;
        std::size_t mapped_bytes;
        std::byte* base;
        std::size_t items;
        bool fresh;  ///< zero until touched
        std::atomic<std::size_t> next{0};
    };
    Chunk* addChunk();

    std::size_t item_bytes_, chunk_items_;
    std::atomic<Chunk*> current_{nullptr};
    std::atomic<std::size_t> free_count_{0};
    mutable std::mutex mutex_;  // guards what follows
    std::vector<Chunk*> chunks_;
    std::vector<void*> free_;
};

}  // namespace photic
