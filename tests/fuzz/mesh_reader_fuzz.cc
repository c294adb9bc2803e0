// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Fuzzes the mesh reader of the format LATTICED_FUZZ_FORMAT, which the build defines.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/mesh/mesh_io.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using latticed::MeshFormat;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const auto mesh = latticed::ReadMesh(MeshFormat::LATTICED_FUZZ_FORMAT, bytes);
  if (mesh.ok() && !latticed::Validate(*mesh).ok()) std::abort();
  return 0;
}
