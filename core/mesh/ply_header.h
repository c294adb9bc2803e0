// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The header of a PLY file: what its body holds, element by element.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE, naming the line; those of `memory`
// Threads  pure
#ifndef LATTICED_CORE_MESH_PLY_HEADER_H_
#define LATTICED_CORE_MESH_PLY_HEADER_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"

namespace latticed {

class ReadingMemory;  // core/mesh/reading_memory.h

enum class PlyEncoding { kAscii, kLittleEndian, kBigEndian };
struct PlyType {
  std::array<std::string_view, 2> names;
  size_t bytes;
  bool is_integer;
  double (*load)(const char* bytes);  // of a value in little endian; every type fits a double
};

struct PlyProperty {
  std::string name;
  const PlyType* type = nullptr;        // of the items, for a list
  const PlyType* count_type = nullptr;  // of a list's length; null: not a list
  bool is_list() const { return count_type != nullptr; }
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;

  // The least bytes of one record in a binary file, where lists may be empty.
  [[nodiscard]] size_t MinBinaryBytes() const;
  // Index of the first property with one of the names and the given kind, or -1.
  [[nodiscard]] int FindProperty(std::initializer_list<std::string_view> names, bool is_list) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::kAscii;
  std::vector<PlyElement> elements;
  size_t body_offset = 0;
  uint64_t memory_bytes = 0;  // more than all elements take

  [[nodiscard]] const PlyElement* FindElement(std::string_view name) const;
};

// `memory` may be null.
[[nodiscard]] absl::StatusOr<PlyHeader> ReadPlyHeader(std::string_view bytes,
                                                      ReadingMemory* memory);

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_PLY_HEADER_H_
