// SPDX-License-Identifier: Apache-2.0
#pragma once

// The file of index volumes, .ivol: what docs/index_volumes.md says in words. Includes nothing, so that any reader can
// include it. All numbers are little-endian.

namespace photic::format {

inline constexpr char kIndexMagic[] = "PhoticIV";  // the first eight bytes, without a NUL
inline constexpr unsigned kIndexVersion = 3;       // the latest
inline constexpr unsigned kIndexCoatVersion = 2;   // without shapes
inline constexpr unsigned kIndexFirstVersion = 1;  // without what is said of faces; its objects' headers are shorter

// The file's header.
inline constexpr unsigned kIndexFileHeader = 32;  // [bytes]
inline constexpr unsigned kIndexVersionAt = 8;    // u32
inline constexpr unsigned kIndexObjectsAt = 12;   // u32: how many
inline constexpr unsigned kIndexFileSizeAt = 16;  // u64 [bytes]
inline constexpr unsigned kIndexMostObjects = 256;
inline constexpr unsigned kIndexMostDrawn = 16;  // of them at a time, by the run-time library's pass

// Behind it one of these for each object; places count from the object's own header.
inline constexpr unsigned kIndexObjectHeader = 320;    // [bytes]
inline constexpr unsigned kIndexFirstHeader = 256;     // in version 1
inline constexpr unsigned kIndexNameAt = 0;            // text, ended by a NUL
inline constexpr unsigned kIndexNameSize = 64;         // with it
inline constexpr unsigned kIndexWorldFromNodeAt = 64;  // 12 f64: three rows of world = matrix * (node, 1) [m]
inline constexpr unsigned kIndexNodesAt = 160;         // 3 u32: along x, y, z
inline constexpr unsigned kIndexChannelsAt = 172;      // u32: 1, or 3 for red, green and blue
inline constexpr unsigned kIndexFlagsAt = 176;         // u32
inline constexpr unsigned kIndexScatteringAt = 180;    // 3 f32 [1/m], times the attenuation's fourth number
inline constexpr unsigned kIndexAnisotropyAt = 192;    // f32: g, where there is no glow
inline constexpr unsigned kIndexOffsetsAt = 200;       // 4 u64, from the file's start; 0: there is none
inline constexpr unsigned kIndexBoxAt = 232;           // 6 f32: low x, y, z and high x, y, z, in nodes
inline constexpr unsigned kIndexAlbedoAt = 256;        // 3 f32: of faces, where there is no coat; from version 2 on
inline constexpr unsigned kIndexRoughnessAt = 268;     // f32, of highlights on faces; 0: there are none
inline constexpr unsigned kIndexCoatAt = 272;          // u64: place of the fifth array
inline constexpr unsigned kIndexShapeAt = 280;         // u64: place of the shape's block; 0: there is none; version 3
inline constexpr unsigned kIndexSharpSides = 1;        // flag: the object ends at the box as at a polished face

// Four of the arrays, by their place among the offsets; x fastest, then y, then z.
inline constexpr unsigned kIndexSpline = 0;  // f32 a node, a channel behind the other: coefficients of (n^2 - 1) / 2
inline constexpr unsigned kIndexAttenuation = 1;  // 4 halves a node: absorption r, g, b [1/m]; how much of it is there
inline constexpr unsigned kIndexGlow = 2;         // 4 halves a node: emission r, g, b [W/(m3 sr)]; g
inline constexpr unsigned kIndexFaces = 3;        // u8 a node: 255 where a face goes through, else 0
// The fifth, from version 2 on: 3 u8 a node, the albedo of faces, of 255.
inline constexpr unsigned kIndexAlignment = 16;  // of the arrays [bytes]

inline constexpr unsigned kIndexLeastNodes = 4, kIndexMostNodes = 2048;  // a side; 0 of a shape without samples

// A shape with sharp faces, from version 3 on: this block, and behind it without gaps positions, normals (of smooth
// ones alone) and triangles. Positions are in nodes.
inline constexpr unsigned kShapeHeader = 80;        // [bytes]
inline constexpr unsigned kShapeKindAt = 0;         // u32
inline constexpr unsigned kShapeVerticesAt = 4;     // u32
inline constexpr unsigned kShapeTrianglesAt = 8;    // u32
inline constexpr unsigned kShapeFacesAt = 12;       // u32: what they do to light
inline constexpr unsigned kShapeIndexAt = 16;       // 3 f32: n inside, where there is no spline
inline constexpr unsigned kShapeRankAt = 28;        // u32: of shapes around a place the one of the highest is there
inline constexpr unsigned kShapeAbsorptionAt = 32;  // 3 f32 [1/m]: inside, where there is no spline
inline constexpr unsigned kShapeColourAt = 48;      // 3 f32: of a mirror, the share that it sends back
inline constexpr unsigned kShapeBallAt = 60;        // 4 f32: centre and radius of a ball
inline constexpr unsigned kShapeSmooth = 0, kShapeFlat = 1, kShapeBall = 2;
inline constexpr unsigned kFacesGlass = 0, kFacesClear = 1, kFacesMirror = 2, kFacesThin = 3;
inline constexpr unsigned kShapeMostTriangles = 1u << 21;  // vertices: up to three times as many
inline constexpr unsigned kShapeHighestRank = 255;

}  // namespace photic::format
