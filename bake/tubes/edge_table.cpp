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

EdgeTable::EdgeTable() : places_(kFewest, 0) {}

EdgeTable::Edge& EdgeTable::at(const EmissionParam& middle, bool& fresh) {
    const std::uint32_t hash = hashOf(middle);
    const std::size_t mask = places_.size() - 1;
    std::size_t place = hash & mask;
    for (; places_[place] != 0; place = (place + 1) & mask) {
        Entry& entry = entries_[places_[place] - 1];
        if (entry.hash != hash || !(entry.middle == middle)) continue;
        fresh = false;
        return entry.edge;
    }
    fresh = true;
    Entry& entry = entries_.add();
    entry = {middle, hash, {}};
    places_[place] = static_cast<std::uint32_t>(entries_.size());
    if (2 * entries_.size() > places_.size()) grow();
    return entry.edge;
}

void EdgeTable::grow() {
    places_.assign(2 * places_.size(), 0);
    const std::size_t mask = places_.size() - 1;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        std::size_t place = entries_[i].hash & mask;
        while (places_[place] != 0) place = (place + 1) & mask;
        places_[place] = static_cast<std::uint32_t>(i + 1);
    }
}

void EdgeTable::clear() {
    std::fill(places_.begin(), places_.end(), 0);
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
