// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/edge_table.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace photic {
namespace {

constexpr std::size_t kFewest = 1024;       // places: a block's
constexpr std::size_t kMostToKeep = 20000;  // entries: some 8 MB with their paths

std::uint32_t hashOf(const EmissionParam& p) {
    std::uint64_t hash = 0x9e3779b97f4a7c15ull;
    for (const double value : {p.position.x, p.position.y, p.position.z, p.normal.x, p.normal.y, p.normal.z}) {
        std::uint64_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        hash = (hash ^ bits) * 0xbf58476d1ce4e5b9ull;
        hash ^= hash >> 29;
    }
    return static_cast<std::uint32_t>(hash ^ hash >> 32);
}

// Tables that nobody uses.
std::vector<std::unique_ptr<EdgeTable>>& spareTables() {
    thread_local std::vector<std::unique_ptr<EdgeTable>> spare;
    return spare;
}

}  // namespace

EdgeTable::EdgeTable() : places_(kFewest) {}

EdgeTable::Edge& EdgeTable::at(const EmissionParam& middle, bool& fresh) {
    const std::uint32_t hash = hashOf(middle);
    const std::size_t mask = places_.size() - 1;
    std::size_t place = hash & mask;
    for (; places_[place].entry != 0; place = (place + 1) & mask) {
        if (places_[place].hash != hash) continue;
        Entry& entry = entries_[places_[place].entry - 1];
        if (!(entry.middle == middle)) continue;
        fresh = false;
        return entry.edge;
    }
    fresh = true;
    Entry& entry = entries_.add();
    entry = {middle, {}};
    places_[place] = {static_cast<std::uint32_t>(entries_.size()), hash};
    if (2 * entries_.size() > places_.size()) grow();
    return entry.edge;
}

void EdgeTable::grow() {
    std::vector<Place> wider(2 * places_.size());
    const std::size_t mask = wider.size() - 1;
    for (const Place& taken : places_) {
        if (taken.entry == 0) continue;
        std::size_t place = taken.hash & mask;
        while (wider[place].entry != 0) place = (place + 1) & mask;
        wider[place] = taken;
    }
    places_ = std::move(wider);
}

void EdgeTable::clear() {
    // What one block has filled is not swept for all the small ones after it.
    if (8 * entries_.size() < places_.size()) places_.resize(std::max(kFewest, places_.size() / 2));
    std::fill(places_.begin(), places_.end(), Place{});
    entries_.clear(), paths_.clear();
}

bool EdgeTable::isLarge() const { return entries_.size() > kMostToKeep; }

LentEdgeTable::LentEdgeTable() {
    auto& spare = spareTables();
    if (spare.empty()) {
        table_ = std::make_unique<EdgeTable>();
    } else {
        table_ = std::move(spare.back());
        spare.pop_back();
    }
}

LentEdgeTable::~LentEdgeTable() {
    if (table_->isLarge()) return;
    table_->clear();
    spareTables().push_back(std::move(table_));
}

}  // namespace photic
