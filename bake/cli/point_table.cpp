// SPDX-License-Identifier: Apache-2.0
#include "bake/cli/point_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <system_error>

#include "bake/report/error.h"

namespace photic::cli {
namespace {

constexpr std::array<std::string_view, 6> kNames{"x", "y", "z", "nx", "ny", "nz"};

using Fields = std::vector<std::string_view>;

std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

/// What parts the fields of a table: the first of these that its first row holds, or else blanks.
char separatorOf(std::string_view row) {
    for (const char c : {';', ',', '\t'})
        if (row.find(c) != std::string_view::npos) return c;
    return ' ';
}

Fields fieldsOf(std::string_view row, char separator) {
    Fields fields;
    while (!row.empty() || separator != ' ') {
        const std::size_t end = row.find(separator);
        const std::string_view field = trimmed(row.substr(0, end));
        if (separator != ' ' || !field.empty()) fields.push_back(field);
        if (end == std::string_view::npos) break;
        row.remove_prefix(end + 1);
    }
    return fields;
}

std::optional<double> numberOf(std::string_view field) {
    if (field.starts_with('+')) field.remove_prefix(1);
    double value = 0;
    const auto [end, failure] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (failure != std::errc() || end != field.data() + field.size()) return {};
    return value;
}

/// "X [m]" is x: without the unit that often stands behind a column's name.
std::string plainName(std::string_view field) {
    const std::string_view name = trimmed(field.substr(0, field.find_first_of("[(")));
    std::string lower(name);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return lower;
}

/// Reads one table, row by row.
class Reader {
public:
    explicit Reader(std::string source) : source_(std::move(source)) {}

    void row(std::string_view line, int number) {
        line_ = number;
        if (line.find('"') != std::string_view::npos)
            fail("quotes are not read; write plain numbers, and names without commas");
        if (width_ == 0) {
            separator_ = separatorOf(line);
            const Fields fields = fieldsOf(line, separator_);
            width_ = fields.size();
            if (!numberOf(fields.front())) return header(fields);
            if (width_ != 3 && width_ != 6) {
                fail(
                    fmt::format("{} numbers; a point is x,y,z or, with its normal, x,y,z,nx,ny,nz. Other columns want "
                                "a first row that names them all",
                                width_));
            }
            for (std::size_t i = 0; i < width_; ++i) place_[i] = static_cast<int>(i);
            table_.normals = width_ == 6;
        }
        point(fieldsOf(line, separator_));
    }

    PointTable take() {
        if (table_.points.empty())
            throw Error(ErrorCode::Input, "holds no points; write one a line, x,y,z in metres", source_);
        return std::move(table_);
    }

private:
    [[noreturn]] void fail(const std::string& message) const {
        throw Error(ErrorCode::Input, message, fmt::format("{}:{}", source_, line_));
    }

    void header(const Fields& fields) {
        for (std::size_t i = 0; i < fields.size(); ++i) {
            const auto known = std::find(kNames.begin(), kNames.end(), plainName(fields[i]));
            if (known == kNames.end()) {
                table_.carried_names.emplace_back(fields[i]);
                carried_.push_back(i);
                continue;
            }
            int& place = place_[static_cast<std::size_t>(known - kNames.begin())];
            if (place >= 0) fail(fmt::format("two columns are named {}; rename one", *known));
            place = static_cast<int>(i);
        }
        const auto missing = [&](std::size_t i) { return place_[i] < 0; };
        for (std::size_t i = 0; i < 3; ++i) {
            if (missing(i)) {
                fail(
                    fmt::format("no column {} among: {}; the first row must name x, y and z (and may nx, ny and nz), "
                                "or be left out",
                                kNames[i], fmt::join(fields, ", ")));
            }
        }
        const int normals =
            static_cast<int>(!missing(3)) + static_cast<int>(!missing(4)) + static_cast<int>(!missing(5));
        if (normals != 0 && normals != 3) fail("a normal is nx, ny and nz; name all three or none");
        table_.normals = normals == 3;
    }

    double number(const Fields& fields, std::size_t which) const {
        const std::string_view field = fields[static_cast<std::size_t>(place_[which])];
        const std::optional<double> value = numberOf(field);
        if (!value)
            fail(fmt::format("{} is '{}', which is no number; write metres such as 0.25", kNames[which], field));
        if (!std::isfinite(*value))
            fail(fmt::format("{} is {}, which is not finite; take the row out", kNames[which], field));
        return *value;
    }

    void point(const Fields& fields) {
        if (fields.size() != width_) {
            fail(fmt::format("{} columns, where the table's first row has {}; give every row as many, parted alike",
                             fields.size(), width_));
        }
        SamplePoint point;
        for (int axis = 0; axis < 3; ++axis) point.position[axis] = number(fields, static_cast<std::size_t>(axis));
        if (table_.normals) {
            glm::dvec3 normal{0};
            for (int axis = 0; axis < 3; ++axis) normal[axis] = number(fields, static_cast<std::size_t>(axis) + 3);
            const double length = glm::length(normal);
            if (!(length > 0) || !std::isfinite(length))
                fail(
                    fmt::format("the normal ({}, {}, {}) has no direction; give one of any length but 0, out of the "
                                "lit face",
                                normal.x, normal.y, normal.z));
            point.normal = normal / length;
        }
        for (const std::size_t column : carried_) point.carried.emplace_back(fields[column]);
        table_.points.push_back(std::move(point));
    }

    std::string source_;
    int line_ = 0;
    char separator_ = ',';
    std::size_t width_ = 0;  // columns; 0 before the first row
    std::array<int, 6> place_{-1, -1, -1, -1, -1, -1};
    std::vector<std::size_t> carried_;
    PointTable table_;
};

}  // namespace

PointTable parsePoints(std::string_view text, const std::string& source) {
    constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    Reader reader(source);
    for (int line = 1; !text.empty(); ++line) {
        const std::size_t end = text.find('\n');
        std::string_view row = text.substr(0, end);
        while (!row.empty() && (row.back() == '\r' || row.back() == ' ')) row.remove_suffix(1);
        if (!trimmed(row).empty() && row.front() != '#') reader.row(row, line);
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return reader.take();
}

}  // namespace photic::cli
