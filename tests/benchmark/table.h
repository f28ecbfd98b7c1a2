// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace photic::benchmark {

/// A titled table of text cells.
struct Table {
    std::string title, note;
    std::vector<std::string> head;
    std::vector<std::vector<std::string>> rows;
    void add(std::vector<std::string> row) { rows.push_back(std::move(row)); }
};

std::string markdown(const Table& table);

/// All tables one after another: title, row, column, value; one line a cell, so that nothing has to agree in width.
std::string csv(const std::vector<Table>& tables);

/// A point of the picture of run time against error.
struct Point {
    std::string series, label;
    double seconds = 0, error = 0;
};

/// Log-log picture of run time (across) against error (up); points that nothing beats in both are joined.
std::string paretoSvg(const std::string& title, const std::vector<Point>& points);

}  // namespace photic::benchmark
