// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace photic {

/// A corner of a clipped triangle: its place in the image and its barycentric place in the source.
struct ClipPoint {
    double x, y, b1, b2;
};

/// A triangle cut by four lines has at most seven corners.
struct ClipPolygon {
    ClipPoint points[8];
    int count = 0;
};

/// Keeps the part where sign * (coordinate - limit) >= 0.
template <double ClipPoint::*kCoordinate>
ClipPolygon clip(const ClipPolygon& in, double limit, double sign) {
    ClipPolygon out;
    for (int i = 0; i < in.count; ++i) {
        const ClipPoint& a = in.points[i];
        const ClipPoint& b = in.points[i + 1 == in.count ? 0 : i + 1];
        const double da = sign * (a.*kCoordinate - limit), db = sign * (b.*kCoordinate - limit);
        if (da >= 0) out.points[out.count++] = a;
        if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
            const double s = da / (da - db);
            out.points[out.count++] = {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.b1 + s * (b.b1 - a.b1),
                                       a.b2 + s * (b.b2 - a.b2)};
        }
    }
    return out;
}

/// Fraction of the source triangle: twice the polygon's area in the barycentric plane.
double sourceFraction(const ClipPolygon& p);

inline ClipPolygon wholeTriangle(const double x[3], const double y[3]) {
    return {{{x[0], y[0], 0, 0}, {x[1], y[1], 1, 0}, {x[2], y[2], 0, 1}}, 3};
}

/// Some rows of a grid.
struct RowRange {
    int first, end;
};

/// Calls visit(row, column, fraction) for the cells of a grid, a unit wide, that a triangle lies in, with the share of
/// the source triangle that each gets: sub-cell exact at any size, and where the image of the triangle collapses. Of
/// some rows the shares are the same bits as of all.
template <class Visit>
void shareAmongCells(const double x[3], const double y[3], int columns, RowRange rows, const Visit& visit) {
    const auto [least_x, most_x] = std::minmax({x[0], x[1], x[2]});
    const auto [least_y, most_y] = std::minmax({y[0], y[1], y[2]});
    if (!(most_x > 0 && most_y > rows.first && least_x < columns && least_y < rows.end)) return;
    const int first_column = std::max(0, static_cast<int>(std::floor(least_x)));
    const int last_column = std::min(columns - 1, static_cast<int>(std::floor(most_x)));
    const int first_row = std::max(rows.first, static_cast<int>(std::floor(least_y)));
    const int last_row = std::min(rows.end - 1, static_cast<int>(std::floor(most_y)));
    if (least_x >= first_column && most_x <= first_column + 1 && least_y >= first_row && most_y <= first_row + 1) {
        visit(first_row, first_column, 1.0);
        return;
    }
    const ClipPolygon whole = wholeTriangle(x, y);
    for (int row = first_row; row <= last_row; ++row) {
        const ClipPolygon strip = clip<&ClipPoint::y>(clip<&ClipPoint::y>(whole, row, 1), row + 1, -1);
        if (strip.count < 3) continue;
        // A long thin triangle comes by few of its box's columns in a row.
        const auto by_x = [](const ClipPoint& a, const ClipPoint& b) { return a.x < b.x; };
        const auto [least, most] = std::minmax_element(strip.points, strip.points + strip.count, by_x);
        const int first = std::max(first_column, static_cast<int>(std::floor(least->x)));
        const int last = std::min(last_column, static_cast<int>(std::floor(most->x)));
        for (int column = first; column <= last; ++column) {
            const ClipPolygon cell = clip<&ClipPoint::x>(clip<&ClipPoint::x>(strip, column, 1), column + 1, -1);
            if (cell.count >= 3) visit(row, column, sourceFraction(cell));
        }
    }
}

}  // namespace photic
