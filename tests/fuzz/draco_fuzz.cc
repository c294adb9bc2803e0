// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Fuzzes the reader of uploaded Draco meshes, and the chunk decoder of clients.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/codec/draco_decode.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto mesh =
      latticed::ReadDracoMesh(std::string_view(reinterpret_cast<const char*>(data), size));
  if (mesh.ok() && !latticed::Validate(*mesh).ok()) std::abort();
  (void)latticed::DecodeDracoChunk({data, size});
  return 0;
}
