// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The most that an exported mesh has, and the bytes that making it takes besides the mesh, for admission.
#ifndef LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_MEMORY_H_
#define LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_MEMORY_H_

#include <cstdint>

#include "core/mesh/write/writing_memory.h"

namespace latticed {

struct SurfaceMemory {
  WrittenSizes sizes;
  uint64_t working_bytes = 0;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_MEMORY_H_
