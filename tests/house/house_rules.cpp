// SPDX-License-Identifier: Apache-2.0
#include "tests/house/house_rules.h"

#include <algorithm>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>
#include <utility>

namespace photic::house {
namespace {

namespace fs = std::filesystem;

const std::set<std::string> kEveryRoomMayUse = {"report", "threads", "libraries"};

std::vector<std::string> linesOf(const fs::path& file) {
    std::ifstream in(file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

std::string contentsOf(const fs::path& file) {
    std::ifstream in(file);
    std::stringstream all;
    all << in.rdbuf();
    return all.str();
}

bool isCpp(const fs::path& file) {
    const auto e = file.extension();
    return e == ".h" || e == ".cpp" || e == ".inl" || e == ".hpp" || e == ".cc";
}

bool isScript(const fs::path& file) {
    const std::string first = file.string();
    return file.extension() == ".py" || file.extension() == ".sh" || first.rfind("scripts/", 0) == 0 ||
           first == ".ci/run";
}

bool isCMake(const fs::path& file) { return file.filename() == "CMakeLists.txt" || file.extension() == ".cmake"; }

/// "bake/scene/scene.h" -> "scene", "runtime/format/x.h" -> "format", "runtime/src/x.h" -> "runtime"; "" for what is in
/// no room.
std::string roomOf(const std::string& path) {
    static const std::regex pattern(
        "^(?:bake/([a-z0-9_]+)|runtime/(format)|(runtime)/(?:src|include)|runtime/(vdb|headless|viewer))/.*");
    std::smatch m;
    if (!std::regex_match(path, m, pattern)) return {};
    return m[1].str() + m[2].str() + m[3].str() + m[4].str();  // those that did not match are empty
}

std::string listOf(const std::set<std::string>& names) {
    std::string out;
    for (const auto& n : names) {
        if (!out.empty()) out += ", ";
        out += n;
    }
    return out.empty() ? "nothing" : out;
}

/// Empty when `from` may use `to`, otherwise the reason why not.
std::string refusal(const std::string& from, const std::string& to) {
    if (from == to) return {};
    const auto row = arrows().find(from);
    if (row == arrows().end()) return "room '" + from + "' is not in the table of arrows (tests/house/house_rules.cpp)";
    if (kEveryRoomMayUse.count(to) && from != "report" && from != "runtime") return {};
    if (row->second.count(to)) return {};
    return "room '" + from + "' may not use '" + to + "'; it may use " + listOf(row->second) +
           (from == "report" ? "" : " (and report, threads, libraries)");
}

}  // namespace

const Arrows& arrows() {
    static const Arrows table = {
        {"libraries", {}},  // headers of others whose versions differ
        {"report", {}},
        {"threads", {}},
        {"format", {}},
        {"headless", {"runtime"}},  // a GL context without a screen
        {"viewer", {"runtime", "vdb", "headless", "picture", "scene", "field", "file", "image"}},
        {"vdb", {"runtime", "file", "field"}},  // runtime/vdb: the baker's reader for tools that use the runtime
        {"runtime", {"format"}},                // what a game links: nothing of the baker
        {"simd", {}},
        {"volume", {"simd"}},
        {"optics", {}},
        {"image", {}},
        {"scene", {"image", "simd", "volume"}},
        {"graded", {"scene", "simd"}},
        {"field", {"scene", "optics", "simd"}},  // optics: a sheared grid leans along the refracted light
        {"numerics", {"simd"}},
        {"paths", {"optics", "scene", "field", "simd"}},
        {"tubes", {"paths", "optics", "scene", "field", "simd"}},
        {"deposit", {"tubes", "optics", "field", "simd"}},
        {"file", {"image", "field", "simd", "volume", "format"}},
        {"methods", {"scene", "graded", "paths", "tubes", "deposit", "numerics", "field", "optics", "simd"}},
        {"picture", {"file", "scene", "image", "field", "optics", "paths"}},  // eye rays meet what light does
        {"baker", {"methods", "scene", "field", "file", "simd", "picture"}},  // file: how a volume is going to be
                                                                              // stored; picture: its look-ups
        {"web",
         {"picture", "file", "scene", "field"}},  // picture: what of a receiver lies in the domain, and from where
        {"cli", {"baker", "methods", "scene", "graded", "field", "file", "picture", "web", "image"}},
    };
    return table;
}

std::vector<fs::path> sourceFiles(const fs::path& root) {
    static const std::set<std::string> skipped = {"build", "out", "__pycache__"};
    std::vector<fs::path> files;
    for (auto it = fs::recursive_directory_iterator(root); it != fs::recursive_directory_iterator(); ++it) {
        const std::string name = it->path().filename().string();
        const bool hidden = name.front() == '.' && name != ".ci";
        if (it->is_directory() && (skipped.count(name) || hidden)) {
            it.disable_recursion_pending();
        } else if (it->is_regular_file() && name != ".git") {  // of a worktree: where its repository is
            files.push_back(fs::relative(it->path(), root));
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<Breach> backArrows(const fs::path& root) {
    static const std::regex include(R"(^\s*#\s*include\s*[<"]((?:bake|runtime)/[^">]+)[">].*)");
    std::vector<Breach> breaches;
    for (const auto& file : sourceFiles(root)) {
        const std::string from = roomOf(file.generic_string());
        if (!isCpp(file) || from.empty()) continue;
        const auto lines = linesOf(root / file);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            std::smatch m;
            if (!std::regex_match(lines[i], m, include)) continue;
            const std::string why = refusal(from, roomOf(m[1].str()));
            if (!why.empty()) breaches.push_back({file.generic_string(), static_cast<int>(i) + 1, why});
        }
    }
    return breaches;
}

std::vector<Breach> linksAgainstArrows(const fs::path& root) {
    static const std::regex rooms(R"(\bROOMS\s+([a-z0-9_\s]+))"), linked(R"(\bphotic_([a-z0-9_]+))");
    static const std::set<std::string> not_rooms = {"room",    "test",    "build_flags", "kernels", "codecs",
                                                    "openvdb", "nanovdb", "embree",      "glm"};
    std::vector<Breach> breaches;
    for (const auto& file : sourceFiles(root)) {
        const std::string name = file.generic_string(), from = roomOf(name);
        if (file.filename() != "CMakeLists.txt" || from.empty()) continue;
        const std::string text = contentsOf(root / file);
        std::set<std::string> uses;
        for (std::sregex_iterator it(text.begin(), text.end(), rooms), end; it != end; ++it) {
            std::istringstream words((*it)[1].str());
            for (std::string word; words >> word;) uses.insert(word);
        }
        for (std::sregex_iterator it(text.begin(), text.end(), linked), end; it != end; ++it) {
            std::string room = (*it)[1].str();
            if (room == "runtime_vdb") room = "vdb";
            if (room == "headless_gl") room = "headless";
            if (!not_rooms.count(room)) uses.insert(room);
        }
        for (const auto& to : uses) {
            const std::string why = refusal(from, to);
            if (!why.empty()) breaches.push_back({name, 0, why});
        }
    }
    return breaches;
}

std::vector<std::string> filesIncludingOpenVdb(const fs::path& root) {
    static const std::regex include(R"(^\s*#\s*include\s*[<"](openvdb/|nanovdb/|bake/libraries/(open|nano)vdb).*)");
    std::vector<std::string> files;
    for (const auto& file : sourceFiles(root)) {
        if (!isCpp(file)) continue;
        const auto lines = linesOf(root / file);
        if (std::any_of(lines.begin(), lines.end(),
                        [&](const std::string& l) { return std::regex_match(l, include); })) {
            files.push_back(file.generic_string());
        }
    }
    return files;
}

std::vector<Breach> versionedHeaders(const fs::path& root) {
    static const std::regex include(
        R"(^\s*#\s*include\s*[<"](toml\+\+/|tiny_gltf|imgui/|embree\d/|nanovdb/|openvdb/(openvdb\.h|io/)).*)");
    // In two halves, so that this file is none of its own findings.
    static const std::string join = std::string("fmt::") + "join", ranges = "#include <fmt/ranges.h>";
    static const std::string expressions = "#include <regex>";
    std::vector<Breach> breaches;
    for (const auto& file : sourceFiles(root)) {
        const std::string name = file.generic_string();
        if (!isCpp(file) || roomOf(name) == "libraries" || file.filename() == "imgui_headers.h") continue;
        const bool sanitized = name.rfind("tests/house/", 0) != 0;
        const auto lines = linesOf(root / file);
        const bool has_ranges = std::find(lines.begin(), lines.end(), ranges) != lines.end();
        for (std::size_t i = 0; i < lines.size(); ++i) {
            const int line = static_cast<int>(i) + 1;
            if (std::regex_match(lines[i], include))
                breaches.push_back({name, line, "include its file of bake/libraries, which knows the versions"});
            if (sanitized && lines[i] == expressions)
                breaches.push_back(
                    {name, line, "g++ 12 warns inside this header where it is sanitized: take the text apart"});
            if (!has_ranges && lines[i].find(join) != std::string::npos)
                breaches.push_back({name, line, "include <fmt/ranges.h>, where fmt 11 has " + join});
        }
    }
    return breaches;
}

std::vector<Breach> missingHeaders(const fs::path& root) {
    static const std::vector<std::pair<std::string, std::set<std::string>>> kHeaders = {
        {"algorithm",
         {"clamp",  "min",    "max",     "sort",    "stable_sort", "minmax",      "fill",        "copy",
          "all_of", "any_of", "none_of", "find_if", "count_if",    "lower_bound", "max_element", "min_element",
          "unique", "equal",  "reverse", "find",    "upper_bound", "transform",   "nth_element", "remove_if"}},
        {"numeric", {"accumulate", "iota", "inner_product", "gcd"}},
        {"cmath",
         {"sqrt", "pow", "sin", "cos", "tan", "exp", "log", "fabs", "floor", "ceil", "lround", "isfinite", "hypot"}},
        {"memory", {"unique_ptr", "shared_ptr", "make_unique", "make_shared"}},
        {"limits", {"numeric_limits"}},
        {"tuple", {"tuple", "tie"}},
        {"utility", {"move", "exchange", "pair", "swap"}},
    };
    std::map<std::string, std::set<std::string>> named;  // of each file: all that its own headers include
    std::map<std::string, std::vector<std::string>> lines;
    for (const auto& file : sourceFiles(root))
        if (isCpp(file)) lines[file.generic_string()] = linesOf(root / file);
    const std::function<const std::set<std::string>&(const std::string&)> headersOf = [&](
        const std::string& file) -> auto& {
        const auto [entry, fresh] = named.try_emplace(file);
        if (!fresh) return entry->second;
        std::set<std::string> found;
        for (const std::string& line : lines[file]) {
            if (line.rfind("#include ", 0) != 0 || line.size() < 12) continue;
            const std::string header = line.substr(10, line.find_first_of(">\"", 10) - 10);
            if (line[9] == '<') found.insert(header);
            for (const std::string& place :
                 {header, "runtime/include/" + header, (fs::path(file).parent_path() / header).generic_string()})
                if (lines.count(place) && place != file) found.merge(std::set<std::string>(headersOf(place)));
        }
        return named[file] = std::move(found);
    };
    std::vector<Breach> breaches;
    for (const auto& [file, text] : lines) {
        std::set<std::string> missing;
        for (std::size_t i = 0; i < text.size(); ++i) {
            const std::string code = text[i].substr(0, text[i].find("//"));
            for (std::size_t at = code.find("std::"); at != std::string::npos; at = code.find("std::", at + 5)) {
                const std::string name =
                    code.substr(at + 5, code.find_first_not_of("abcdefghijklmnopqrstuvwxyz_", at + 5) - at - 5);
                for (const auto& [header, names] : kHeaders)
                    if (names.count(name) && !headersOf(file).count(header) && missing.insert(header).second)
                        breaches.push_back(
                            {file, static_cast<int>(i) + 1, "include <" + header + "> for std::" + name});
            }
        }
    }
    return breaches;
}

std::vector<Breach> missingLicence(const fs::path& root) {
    const std::string wanted = std::string("SPDX-License-") + "Identifier: ";
    std::vector<Breach> breaches;
    for (const auto& file : sourceFiles(root)) {
        if (!isCpp(file) && !isScript(file) && !isCMake(file)) continue;
        const std::string name = file.generic_string();
        const std::string licence = name.rfind("blender_addon/", 0) == 0 ? "GPL-3.0-or-later" : "Apache-2.0";
        auto lines = linesOf(root / file);
        lines.resize(2);
        const std::string line = wanted + licence;
        if (lines[0].find(line) == std::string::npos && lines[1].find(line) == std::string::npos) {
            breaches.push_back({name, 1, "the first or second line must hold '" + line + "'"});
        }
    }
    return breaches;
}

std::vector<Breach> longFiles(const fs::path& root, int limit) {
    std::vector<Breach> breaches;
    for (const auto& file : sourceFiles(root)) {
        if (!isCpp(file) && !isScript(file) && !isCMake(file)) continue;
        const int count = static_cast<int>(linesOf(root / file).size());
        if (count > limit) {
            breaches.push_back(
                {file.generic_string(), limit + 1,
                 std::to_string(count) + " lines exceed " + std::to_string(limit) + "; split it by idea"});
        }
    }
    return breaches;
}

std::vector<Breach> missingReadmes(const fs::path& root) {
    std::vector<Breach> breaches;
    std::set<fs::path> folders;
    for (const char* parent : {"bake", "examples"}) {
        if (!fs::is_directory(root / parent)) continue;
        for (const auto& entry : fs::directory_iterator(root / parent)) {
            if (entry.is_directory() && !fs::is_empty(entry.path())) folders.insert(fs::relative(entry.path(), root));
        }
    }
    for (const auto& folder : folders) {
        const std::string text = contentsOf(root / folder / "README.md");
        if (text.find(". ") == std::string::npos && text.find(".\n") == std::string::npos) {
            breaches.push_back(
                {folder.generic_string(), 0, "has no README.md with a sentence that says what belongs in it"});
        }
    }
    return breaches;
}

namespace {

/// The rows' names, as `Method xMethod() { return {"x", ...` gives them.
std::set<std::string> methodNames(const fs::path& root) {
    static const std::regex row(R"re(Method\s+\w+Method\(\)\s*\{\s*return\s*\{\s*"(\w+)")re");
    std::set<std::string> names;
    if (!fs::is_directory(root / "bake/methods")) return names;
    for (const auto& entry : fs::directory_iterator(root / "bake/methods")) {
        const std::string text = contentsOf(entry.path());
        for (std::sregex_iterator it(text.begin(), text.end(), row), end; it != end; ++it) names.insert((*it)[1].str());
    }
    return names;
}

}  // namespace

std::vector<Breach> namedMethods(const fs::path& root) {
    static const std::set<std::string> everyday = {"wave"};
    static const std::regex literal_or_comment(R"re("(?:[^"\\]|\\.)*"|//.*$)re");
    std::vector<Breach> breaches;
    for (const std::string& name : methodNames(root)) {
        const std::regex named(everyday.count(name)
                                   ? "^\"" + name + "\"$|\\b" + name + "\\.[a-z]|\\bmethods? '?" + name + "\\b"
                                   : "\\b" + name + "\\b");
        for (const auto& file : sourceFiles(root)) {
            const std::string path = file.generic_string();
            const bool ours = path.rfind("bake/", 0) == 0 || path.rfind("runtime/", 0) == 0;
            if (!ours || !isCpp(file) || path.rfind("bake/methods/", 0) == 0) continue;
            const auto lines = linesOf(root / file);
            for (std::size_t i = 0; i < lines.size(); ++i) {
                const std::string& code = lines[i];
                if (code.find("#include") != std::string::npos) continue;
                for (std::sregex_iterator it(code.begin(), code.end(), literal_or_comment), end; it != end; ++it) {
                    const std::string text = it->str();
                    if (text.front() == '"' && std::regex_search(text, named))
                        breaches.push_back({path, static_cast<int>(i) + 1,
                                            "names the method '" + name + "', which only its row may: " + text});
                }
            }
        }
    }
    return breaches;
}

std::vector<Breach> machinePaths(const fs::path& root) {
    // In two halves, so that this file is none of its own findings.
    static const std::regex path(std::string("(^|[^A-Za-z0-9_.}$-])/(work|root|home|Users|tmp") +
                                 "|var/tmp)/[A-Za-z0-9_.]");
    static const std::set<std::string> binary = {".exr", ".png", ".vdb", ".glb", ".gz"};
    std::vector<Breach> breaches;
    for (const auto& file : sourceFiles(root)) {
        if (binary.count(file.extension().string())) continue;
        const auto lines = linesOf(root / file);
        for (std::size_t i = 0; i < lines.size(); ++i) {
            if (std::regex_search(lines[i], path)) {
                breaches.push_back(
                    {file.generic_string(), static_cast<int>(i) + 1, "names a machine's path: " + lines[i]});
            }
        }
    }
    return breaches;
}

}  // namespace photic::house
