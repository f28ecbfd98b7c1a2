// SPDX-License-Identifier: Apache-2.0
#include "bake/baker/copy_frame.h"

#include <fmt/format.h>

#include <charconv>
#include <memory>
#include <optional>
#include <vector>

#include "bake/file/vdb_join.h"
#include "bake/report/error.h"

namespace photic {
namespace {

template <class Number>
std::optional<Number> numberIn(const std::map<std::string, std::string>& metadata, const char* key) {
    const auto found = metadata.find(key);
    if (found == metadata.end()) return {};
    Number value{};
    const char* end = found->second.data() + found->second.size();
    const auto read = std::from_chars(found->second.data(), end, value);
    return read.ec == std::errc() && read.ptr == end ? std::optional(value) : std::nullopt;
}

}  // namespace

bool copyFrame(const std::string& from, const std::string& of_source, CheckedFile& to, int frame,
               const std::string& hash) {
    std::vector<std::unique_ptr<VdbPart>> parts;
    try {
        parts.push_back(std::make_unique<VdbPart>(from, from));
    } catch (const Error& error) {
        if (error.code() != ErrorCode::Input) throw;
        return false;
    }
    std::map<std::string, std::string> metadata = parts.front()->metadata();
    const auto own = metadata.find("scene_hash");
    const auto reference = numberIn<double>(metadata, "reference_irradiance");
    if (own == metadata.end() || own->second != of_source || !reference) return false;
    metadata["scene_hash"] = hash, metadata["frame"] = fmt::format("{}", frame);
    joinVdb(to, parts, metadata, *reference, numberIn<std::int64_t>(metadata, "clamped").value_or(0));
    return true;
}

}  // namespace photic
