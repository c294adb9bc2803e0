// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The deformed surface of a scene as one file.
//
//   state -> float view of all chunks -> TriangleMesh -> PLY, OBJ, STL, GLB or DRC
//   state -> Bézier control nets
//
// Layout   patch after patch in plan order, inside a patch in pattern order. So the order of vertices
//          depends only on mesh, lattice structure and segments. UVs are interpolated in the source
//          triangle; groups are those of the source face.
//          Control nets, little endian: "LATTNETS", uint32 version 1, uint32 degree n, uint32 m =
//          (n+1)(n+2)/2, uint32 0, uint64 patches; then m x 3 doubles a patch, T_{n,0,0} first.
// Units    world units; GLB is relative to the translation of its node
// Errors   kResourceExhausted from the backend, kCancelled when `cancelled` says so
// Threads  pure functions on an immutable state; `cancelled` is asked now and then
#ifndef LATTICED_SERVER_ENGINE_SURFACE_EXPORT_H_
#define LATTICED_SERVER_ENGINE_SURFACE_EXPORT_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/triangle_mesh.h"
#include "server/engine/scene.h"

namespace latticed {

struct ExportSpec {
  std::optional<MeshFormat> format;  // nullopt: control nets
  int segments = 10;
  NormalMode normals = NormalMode::kFacet;
  int position_bits = 16;  // DRC alone
  int normal_bits = 12;    // DRC alone
  MeshUnits units;         // of the uploaded mesh
};

using Cancelled = std::function<bool()>;

// Bytes that an export holds at its peak, for admission.
[[nodiscard]] uint64_t ExportMemoryBytes(const DeformPlan& plan, const ExportSpec& spec);

[[nodiscard]] absl::StatusOr<TriangleMesh> AssembleSurface(const RenderInput& input, int segments,
                                                           NormalMode normals,
                                                           const Cancelled& cancelled);
[[nodiscard]] absl::StatusOr<std::string> WriteControlNets(const RenderInput& input,
                                                           const Cancelled& cancelled);
// The whole file.
[[nodiscard]] absl::StatusOr<std::string> ExportSurface(const RenderInput& input,
                                                        const ExportSpec& spec,
                                                        const Cancelled& cancelled);

[[nodiscard]] std::string_view ExportMediaType(std::optional<MeshFormat> format);
[[nodiscard]] std::string_view ExportExtension(std::optional<MeshFormat> format);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SURFACE_EXPORT_H_
