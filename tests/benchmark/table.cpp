// SPDX-License-Identifier: Apache-2.0
#include "tests/benchmark/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace photic::benchmark {

std::string markdown(const Table& table) {
    std::string out = fmt::format("\n## {}\n\n", table.title);
    if (!table.note.empty()) out += table.note + "\n\n";
    out += fmt::format("| {} |\n|", fmt::join(table.head, " | "));
    for (std::size_t i = 0; i < table.head.size(); ++i) out += i == 0 ? "---|" : "---:|";
    out += "\n";
    for (const auto& row : table.rows) out += fmt::format("| {} |\n", fmt::join(row, " | "));
    return out;
}

std::string csv(const std::vector<Table>& tables) {
    const auto quoted = [](const std::string& s) {
        std::string q = "\"";
        for (const char c : s) q += c == '"' ? std::string("\"\"") : std::string(1, c);
        return q + "\"";
    };
    std::string out = "table,row,column,value\n";
    for (const Table& t : tables) {
        for (const auto& row : t.rows) {
            for (std::size_t c = 1; c < row.size(); ++c) {
                out += fmt::format("{},{},{},{}\n", quoted(t.title), quoted(row[0]), quoted(t.head[c]), quoted(row[c]));
            }
        }
    }
    return out;
}

namespace {

constexpr double kWidth = 800, kHeight = 480, kLeft = 70, kRight = 210, kTop = 40, kBottom = 50;

struct Axis {
    double low, high, from, to;  // powers of ten, pixels
    double at(double v) const { return from + (std::log10(v) - low) / (high - low) * (to - from); }
};

Axis spanning(const std::vector<Point>& points, double Point::*member, double from, double to) {
    double low = 1e300, high = 1e-300;
    for (const Point& p : points) low = std::min(low, p.*member), high = std::max(high, p.*member);
    return {std::floor(std::log10(low)), std::max(std::ceil(std::log10(high)), std::floor(std::log10(low)) + 1), from,
            to};
}

}  // namespace

std::string paretoSvg(const std::string& title, const std::vector<Point>& points) {
    if (points.empty()) return {};
    const Axis x = spanning(points, &Point::seconds, kLeft, kWidth - kRight),
               y = spanning(points, &Point::error, kHeight - kBottom, kTop);
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "font-family=\"sans-serif\" "
        "font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<text x=\"{2}\" y=\"22\" "
        "font-size=\"15\">{3}</text>\n",
        kWidth, kHeight, kLeft, title);
    for (double e = x.low; e <= x.high; ++e) {
        const double px = x.at(std::pow(10, e));
        out += fmt::format(
            "<path d=\"M{0} {1}V{2}\" stroke=\"#ddd\"/><text x=\"{0}\" y=\"{3}\" text-anchor=\"middle\">{4:g} "
            "s</text>\n",
            px, kTop, kHeight - kBottom, kHeight - kBottom + 18, std::pow(10, e));
    }
    for (double e = y.low; e <= y.high; ++e) {
        const double py = y.at(std::pow(10, e));
        out += fmt::format(
            "<path d=\"M{1} {0}H{2}\" stroke=\"#ddd\"/><text x=\"{3}\" y=\"{0}\" text-anchor=\"end\" "
            "dy=\"4\">{4:g}</text>\n",
            py, kLeft, kWidth - kRight, kLeft - 6, std::pow(10, e));
    }
    out += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">one core</text>\n",
                       (kLeft + kWidth - kRight) / 2, kHeight - 12);

    std::vector<Point> front = points;
    std::sort(front.begin(), front.end(), [](const Point& a, const Point& b) { return a.seconds < b.seconds; });
    std::string path;
    double best = 1e300;
    for (const Point& p : front) {
        if (p.error >= best) continue;
        best = p.error;
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x.at(p.seconds), y.at(p.error));
    }
    out += fmt::format("<path d=\"{}\" fill=\"none\" stroke=\"#999\" stroke-dasharray=\"5 4\"/>\n", path);

    const std::vector<std::string> colours{"#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf"};
    std::map<std::string, std::size_t> series;
    for (const Point& p : points) {
        const auto [it, fresh] = series.emplace(p.series, series.size());
        const std::string& colour = colours[it->second % colours.size()];
        out += fmt::format(
            "<circle cx=\"{0:.1f}\" cy=\"{1:.1f}\" r=\"4\" fill=\"{2}\"><title>{3}: {4:.3g} s, "
            "{5:.3g}</title></circle>\n",
            x.at(p.seconds), y.at(p.error), colour, p.label, p.seconds, p.error);
        if (fresh) {
            out += fmt::format(
                "<circle cx=\"{0}\" cy=\"{1}\" r=\"4\" fill=\"{2}\"/><text x=\"{3}\" y=\"{1}\" dy=\"4\">{4}</text>\n",
                kWidth - kRight + 20, kTop + 20.0 * static_cast<double>(it->second) + 10, colour, kWidth - kRight + 30,
                p.series);
        }
    }
    return out + "</svg>\n";
}

}  // namespace photic::benchmark
