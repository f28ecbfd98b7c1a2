// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace photic::house {

/// A breach of a house rule: file (relative to the root), line (0: the whole file), what is wrong and what would be
/// right.
struct Breach {
    std::string file;
    int line = 0;
    std::string what;
};

/// Which rooms a room may include, besides itself and the rooms that every room may use (report, threads,
/// libraries).
using Arrows = std::map<std::string, std::set<std::string>>;
const Arrows& arrows();

/// The files of a source tree that rules apply to, relative to `root`, sorted; build trees, outputs and .git left out.
std::vector<std::filesystem::path> sourceFiles(const std::filesystem::path& root);

/// Includes of another room's headers that follow no arrow, and rooms that the table does not know.
std::vector<Breach> backArrows(const std::filesystem::path& root);

/// Rooms that a CMakeLists.txt links in `photic_room(... ROOMS ...)` or as `photic_NAME` against the arrows.
std::vector<Breach> linksAgainstArrows(const std::filesystem::path& root);

/// Files that include OpenVDB or NanoVDB; each costs some twenty seconds to compile.
std::vector<std::string> filesIncludingOpenVdb(const std::filesystem::path& root);

/// Headers of other people's libraries that differ between versions, included past bake/libraries; lists that fmt
/// joins without the header that newer versions have that in; and <regex>, which g++ 12 warns about under sanitizers.
std::vector<Breach> versionedHeaders(const std::filesystem::path& root);

/// Functions of the standard library whose header a file names neither itself nor by a header of ours: other versions
/// of the library, and of other people's headers, do not bring it along.
std::vector<Breach> missingHeaders(const std::filesystem::path& root);

/// Files without the SPDX line of Apache-2.0 among their first two lines.
std::vector<Breach> missingLicence(const std::filesystem::path& root);

/// Source files of more than `limit` lines.
std::vector<Breach> longFiles(const std::filesystem::path& root, int limit);

/// Rooms of bake/ and other named folders without a README.md of at least one sentence.
std::vector<Breach> missingReadmes(const std::filesystem::path& root);

/// String literals outside bake/methods that name a method of the catalogue. A name that is an everyday word ("wave")
/// counts where it stands as a method's: alone, before a full stop and an option, or after the word "method".
std::vector<Breach> namedMethods(const std::filesystem::path& root);

/// Absolute paths of somebody's machine.
std::vector<Breach> machinePaths(const std::filesystem::path& root);

}  // namespace photic::house
