// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers of the GLB container and of glTF 2.0 that reader and writer share.
//
//   | magic | version | length |   chunk: | bytes | type | data, a multiple of 4 | …
//     "glTF"     2     of all               of data  JSON first, then BIN
//
// Source   https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html, chapter 4
#ifndef LATTICED_CORE_MESH_GLB_LAYOUT_H_
#define LATTICED_CORE_MESH_GLB_LAYOUT_H_

#include <cstddef>
#include <cstdint>

namespace latticed::glb {

inline constexpr uint32_t kMagic = 0x46546C67;
inline constexpr uint32_t kVersion = 2;
inline constexpr uint32_t kJsonChunk = 0x4E4F534A;
inline constexpr uint32_t kBinaryChunk = 0x004E4942;
inline constexpr size_t kHeaderBytes = 12;
inline constexpr size_t kChunkHeaderBytes = 8;

// Component types, primitive modes and buffer targets, as OpenGL numbers them.
inline constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123;
inline constexpr int kUnsignedInt = 5125, kFloat = 5126;
inline constexpr int kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6;
inline constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

constexpr size_t Aligned(size_t bytes) { return (bytes + 3) & ~size_t{3}; }

}  // namespace latticed::glb

#endif  // LATTICED_CORE_MESH_GLB_LAYOUT_H_
