// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace photic {

/// The JSON beside an exported file: "NAME.EXT.json", one for each format. (Formerly "NAME.json", which the formats
/// of one volume shared, and which may be any other program's.)
std::string sidecarPath(const std::string& path);

/// "NAME" + `suffix` + ".EXT": a further texture of the same volume.
std::string partPath(const std::string& path, const char* suffix);

/// The name alone, without folders.
std::string nameOf(const std::string& path);

/// Whether an existing file may be replaced as a sidecar: it is one, of any format.
bool isSidecar(const std::string& path);

/// Whether an existing file may be replaced as a texture of the same format as `path` says: it begins as one does.
bool isTexture(const std::string& path);

}  // namespace photic
