// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sizes of a binary STL file, in bytes.
//
//   80 of header, uint32 count, count x { float normal[3], vertices[3][3]; uint16 }
#ifndef LATTICED_CORE_MESH_STL_LAYOUT_H_
#define LATTICED_CORE_MESH_STL_LAYOUT_H_

#include <cstddef>
#include <cstdint>

namespace latticed::stl {

inline constexpr size_t kHeaderBytes = 80;
inline constexpr size_t kPreambleBytes = kHeaderBytes + sizeof(uint32_t);
inline constexpr size_t kFacetBytes = 50;

}  // namespace latticed::stl

#endif  // LATTICED_CORE_MESH_STL_LAYOUT_H_
