// SPDX-License-Identifier: Apache-2.0
#include "bake/tubes/edge_table.h"

#include <gtest/gtest.h>

#include <vector>

namespace photic {
namespace {

EmissionParam place(int i) { return {{0.5 * i, -3.0 + i % 7, 0}, glm::dvec3(0)}; }

// Refiners hold on to edges and paths while others come.
TEST(EdgeTable, EdgesStayWhereTheyAreWhileItGrows) {
    constexpr int kMany = 20000;
    EdgeTable table;
    std::vector<EdgeTable::Edge*> edges;
    for (int i = 0; i < kMany; ++i) {
        bool fresh = false;
        edges.push_back(&table.at(place(i), fresh));
        ASSERT_TRUE(fresh) << i;
        Path path;
        path.param = place(i);
        edges.back()->middle = &table.keep(path);
        edges.back()->split = i % 3 == 0;
    }
    for (int i = kMany; i-- > 0;) {
        bool fresh = true;
        const EdgeTable::Edge& found = table.at(place(i), fresh);
        ASSERT_FALSE(fresh) << i;
        ASSERT_EQ(&found, edges[static_cast<std::size_t>(i)]);
        ASSERT_EQ(found.middle->param, place(i));
        ASSERT_EQ(found.split, i % 3 == 0);
    }
}

TEST(EdgeTable, WhatTheNextOneTakesOverIsEmpty) {
    const EdgeTable::Edge* before = nullptr;
    for (int times = 0; times < 2; ++times) {
        LentEdgeTable table;
        bool fresh = false;
        EdgeTable::Edge& edge = table->at(place(1), fresh);
        EXPECT_TRUE(fresh);
        EXPECT_EQ(edge.middle, nullptr);
        EXPECT_FALSE(edge.split);
        edge = {&table->keep({}), true};
        EXPECT_TRUE(!before || before == &edge) << "its memory is not kept";
        before = &edge;
    }
}

}  // namespace
}  // namespace photic
