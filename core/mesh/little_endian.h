// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Little-endian numbers of binary mesh files. Load reads sizeof(T) bytes: the caller has checked
// them.
#ifndef LATTICED_CORE_MESH_LITTLE_ENDIAN_H_
#define LATTICED_CORE_MESH_LITTLE_ENDIAN_H_

#include <bit>
#include <cstring>
#include <string>
#include <type_traits>

namespace latticed {

static_assert(std::endian::native == std::endian::little,
              "binary mesh files are copied as they are");

template <typename T>
T LoadLittleEndian(const char* bytes) {
  static_assert(std::is_trivially_copyable_v<T>);
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

template <typename T>
void AppendLittleEndian(T value, std::string* out) {
  static_assert(std::is_trivially_copyable_v<T>);
  out->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_LITTLE_ENDIAN_H_
