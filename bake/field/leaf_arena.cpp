// SPDX-License-Identifier: Apache-2.0
#include "bake/field/leaf_arena.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <new>

#include "bake/report/error.h"

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#define PHOTIC_HAS_MMAP 1
#endif

namespace photic {
namespace {
constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kChunk = std::size_t{64} << 20;

// Mappings of fields that are gone, for the next frame's: a third of a bake's time is the system clearing fresh pages.
class SpareMappings {
public:
    ~SpareMappings() {
        for (const Mapping& m : spare_) unmap(m);
    }

    void* take(std::size_t bytes) {
        const std::lock_guard lock(mutex_);
        for (std::size_t i = spare_.size(); i-- > 0;) {
            if (spare_[i].bytes != bytes) continue;
            void* address = spare_[i].address;
            spare_.erase(spare_.begin() + static_cast<std::ptrdiff_t>(i));
            held_ -= bytes;
            return address;
        }
        return nullptr;
    }

    void give(void* address, std::size_t bytes) {
        const std::lock_guard lock(mutex_);
        if (held_ + bytes > kMostHeld) return unmap({address, bytes});
        spare_.push_back({address, bytes});
        held_ += bytes;
    }

private:
    static constexpr std::size_t kMostHeld = std::size_t{512} << 20;
    struct Mapping {
        void* address;
        std::size_t bytes;
    };
    static void unmap(const Mapping& m) {
#ifdef PHOTIC_HAS_MMAP
        munmap(m.address, m.bytes);
#else
        ::operator delete (m.address, std::align_val_t{64});
#endif
    }
    std::mutex mutex_;
    std::vector<Mapping> spare_;
    std::size_t held_ = 0;
};

SpareMappings& spareMappings() {
    static SpareMappings mappings;
    return mappings;
}
}  // namespace

LeafArena::LeafArena(std::size_t item_bytes, std::int64_t max_items) : item_bytes_(item_bytes) {
    const auto wanted = static_cast<std::size_t>(std::max<std::int64_t>(max_items, 1));
    chunk_items_ = std::clamp<std::size_t>(wanted, 1, std::max<std::size_t>(kChunk / item_bytes, 1));
}

LeafArena::~LeafArena() {
    for (Chunk* c : chunks_) {
        spareMappings().give(c->mapping, c->mapped_bytes);
        delete c;
    }
}

LeafArena::Chunk* LeafArena::addChunk() {
    const std::size_t wanted = chunk_items_ * item_bytes_;
    auto chunk = std::make_unique<Chunk>();
    chunks_.reserve(chunks_.size() + 1);
#ifdef PHOTIC_HAS_MMAP
    // A huge page needs its own alignment: map one more and start at the border.
    const bool huge = wanted >= kHugePage;
    chunk->mapped_bytes = wanted + (huge ? kHugePage : 0);
    chunk->mapping = spareMappings().take(chunk->mapped_bytes);
    chunk->fresh = chunk->mapping == nullptr;
    if (chunk->fresh)
        chunk->mapping = mmap(nullptr, chunk->mapped_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    const bool failed = chunk->mapping == MAP_FAILED;
    if (!failed) {
        auto address = reinterpret_cast<std::uintptr_t>(chunk->mapping);
        if (huge) address = (address + kHugePage - 1) & ~(kHugePage - 1);
        chunk->base = reinterpret_cast<std::byte*>(address);
#ifdef MADV_HUGEPAGE
        if (huge && chunk->fresh) madvise(chunk->base, wanted, MADV_HUGEPAGE);  // advice only: small pages work too
#endif
    }
#else
    chunk->mapped_bytes = wanted;
    chunk->fresh = false;
    chunk->mapping = ::operator new (wanted, std::align_val_t{64}, std::nothrow);
    const bool failed = chunk->mapping == nullptr;
    chunk->base = static_cast<std::byte*>(chunk->mapping);
#endif
    if (failed) {
        std::size_t held = 0;
        for (const Chunk* c : chunks_) held += c->items * item_bytes_;
        throw Error(
            ErrorCode::Failed,
            fmt::format("out of memory: the light field holds {} MiB and could not get {} MiB more; use larger voxels, "
                        "a smaller domain, or where = \"receivers\"",
                        held >> 20, (wanted + kHugePage - 1) >> 20));
    }
    chunk->items = chunk_items_;
    chunks_.push_back(chunk.get());
    return chunk.release();
}

void* LeafArena::allocate(bool& zeroed) {
    if (free_count_.load(std::memory_order_relaxed) > 0) {
        const std::lock_guard lock(mutex_);
        if (!free_.empty()) {
            void* item = free_.back();
            free_.pop_back();
            free_count_.store(free_.size(), std::memory_order_relaxed);
            zeroed = false;
            return item;
        }
    }
    for (;;) {
        Chunk* chunk = current_.load(std::memory_order_acquire);
        if (chunk) {
            const std::size_t i = chunk->next.fetch_add(1, std::memory_order_relaxed);
            zeroed = chunk->fresh;
            if (i < chunk->items) return chunk->base + i * item_bytes_;
        }
        const std::lock_guard lock(mutex_);
        if (current_.load(std::memory_order_relaxed) == chunk) current_.store(addChunk(), std::memory_order_release);
    }
}

void LeafArena::release(void* item) {
    const std::lock_guard lock(mutex_);
    free_.push_back(item);
    free_count_.store(free_.size(), std::memory_order_relaxed);
}

std::int64_t LeafArena::bytes() const {
    const std::lock_guard lock(mutex_);
    std::size_t items = 0;
    for (const Chunk* c : chunks_) items += std::min(c->next.load(std::memory_order_relaxed), c->items);
    return static_cast<std::int64_t>(items * item_bytes_);
}

}  // namespace photic
