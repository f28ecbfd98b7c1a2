// SPDX-License-Identifier: Apache-2.0
#pragma once

// The light volume's format: what docs/light_volume.md says in words. Includes nothing, so that any reader can include
// it.

namespace photic::format {

/// Of the contract. A reader refuses a larger major version than it knows.
inline constexpr int kVersion = 1;

// Grids. All of a file share one transform (index to world, metres, Z up) and one set of active voxels.
/// float, or vec3s for coloured light: fluence rate (scalar irradiance) in units of the reference irradiance.
inline constexpr const char* kIrradiance = "irradiance";
/// vec3s, contravariant_relative: the irradiance-weighted mean of the directions of travel; length at most 1.
inline constexpr const char* kDirection = "direction";
/// As `irradiance` and `direction`, of light that travels against kMetaLobeAxis where light opposes itself; sparse. All
/// light is the sum of both lobes.
inline constexpr const char* kIrradiance2 = "irradiance_2";
inline constexpr const char* kDirection2 = "direction_2";
/// float: the method's own indicator of focus.
inline constexpr const char* kCaustic = "caustic";
/// float [m of optical path]: first arrival at the voxel's centre.
inline constexpr const char* kArrivalTime = "arrival_time";
/// float: 1 inside the medium.
inline constexpr const char* kDensity = "density";

// Metadata, on the file and on every grid.
inline constexpr const char* kPrefix = "photic:";
inline constexpr const char* kMetaVersion = "photic:version";        // int: kVersion
inline constexpr const char* kMetaMethod = "photic:method";          // string: "beams" ...
inline constexpr const char* kMetaOptions = "photic:options";        // string: the method's options, JSON
inline constexpr const char* kMetaPaths = "photic:paths";            // string: "caustic" | "all"
inline constexpr const char* kMetaQuadrature = "photic:quadrature";  // int: points across a layer
inline constexpr const char* kMetaPrefilter = "photic:prefilter";    // bool: made for trilinear look-ups
inline constexpr const char* kMetaReferenceIrradiance =
    "photic:reference_irradiance";                                    // double [W/m2]: stored 1 means this
inline constexpr const char* kMetaIor = "photic:ior";                 // double: of the medium
inline constexpr const char* kMetaScattering = "photic:scattering";   // string: [1/m], a number or [r,g,b]
inline constexpr const char* kMetaAbsorption = "photic:absorption";   // string: the same
inline constexpr const char* kMetaAnisotropy = "photic:anisotropy";   // string: Henyey-Greenstein g
inline constexpr const char* kMetaLobeAxis = "photic:lobe_axis";      // string: [x,y,z], unit
inline constexpr const char* kMetaPeriod = "photic:period";           // string: [x,y,0] [m]
inline constexpr const char* kMetaWaterLevel = "photic:water_level";  // double [m]: z of the still water's surface
inline constexpr const char* kMetaUpAxis = "photic:up_axis";          // string: "Z"
inline constexpr const char* kMetaFrame = "photic:frame";             // int
inline constexpr const char* kMetaLedger = "photic:ledger";           // string: both ledgers, JSON
inline constexpr const char* kMetaReceiverErrors = "photic:receiver_errors";  // string: JSON array
inline constexpr const char* kMetaSceneHash = "photic:scene_hash";            // string: 16 hexadecimal digits
inline constexpr const char* kMetaTile = "photic:tile";                       // string: JSON; of parts of a volume
inline constexpr const char* kMetaClamped = "photic:clamped";                 // int64: values cut to kLargest

/// Largest half float; no stored value exceeds it, in 32-bit files either.
inline constexpr float kLargest = 65504.0f;
/// Voxels with more irradiance (in units of the reference) or density than this are active.
inline constexpr float kActiveAbove = 1e-6f;

// Light in BC6H blocks (docs/files.md): the blind data of a grid without voxels beside those of an .nvdb.
inline constexpr const char* kBlocksGrid = "bc6h";  // of the second lobe with _2 behind it
inline constexpr char kBlocksMagic[] = "PhoticB6";  // its first eight bytes, without a NUL
inline constexpr unsigned kBlocksVersion = 1;
inline constexpr unsigned kBlocksBricks = 1, kBlocksBox = 2;      // how the textures hold voxels
inline constexpr unsigned kBlocksHeader = 64, kBlocksBrick = 16;  // [bytes]

/// Of the slice atlas's JSON sidecar (docs/schemas/atlas.md).
inline constexpr int kAtlasVersion = 1;
inline constexpr int kAtlasLargestSide = 16384;   // texels: the limit of textures on current GPUs
inline constexpr int kTextureLargestSide = 2048;  // texels: the limit of 3D textures on current GPUs

}  // namespace photic::format
