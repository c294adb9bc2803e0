// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The deformed mesh of a scene as one file.
//
//   exact_surface.h, original_mesh.h   a PolygonMesh, which becomes PLY, OBJ, STL, GLB, USD or DRC
//   control_nets.h                     Bézier patches, a format of their own
//
// Units    world units; GLB and USD are relative to a translation
// Errors   kResourceExhausted from the backend, what `stop` returns
// Threads  pure functions on an immutable state; `stop` is asked now and then
#ifndef LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_EXPORT_H_
#define LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_EXPORT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/base/stop_check.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/mesh_units.h"
#include "server/engine/render/render_view.h"

namespace latticed {

enum class ExportGeometry {
  kExact,     // the tessellated surface
  kPatches,   // the same, each patch with vertices of its own
  kOriginal,  // the uploaded mesh's vertices and faces
};

struct ExportSpec {
  std::optional<MeshFormat> format;  // nullopt: control nets
  int segments = 10;
  double tolerance = 0;  // as of a ViewSpec; for DRC, rounding to position_bits included
  NormalMode normals = NormalMode::kFacet;
  int position_bits = 16;  // DRC alone
  int normal_bits = 12;    // DRC alone
  ExportGeometry geometry = ExportGeometry::kExact;
  MeshUnits units;  // of the uploaded mesh
  // The uploaded file, if it has this format: its materials and pictures are kept. Null: none.
  std::shared_ptr<const std::string> upload;
};

// Bytes that an export holds at its peak, for admission.
[[nodiscard]] uint64_t ExportMemoryBytes(const DeformPlan& plan, const ExportSpec& spec);

struct ExportedFile {
  std::string bytes;
  // With a tolerance: what DeformView::certified_error says, and for DRC the rounding to position_bits. Else 0.
  double certified_error = 0;
};
[[nodiscard]] absl::StatusOr<ExportedFile> ExportSurface(const RenderInput& input,
                                                         const ExportSpec& spec, StopCheck stop);

[[nodiscard]] std::string_view ExportMediaType(std::optional<MeshFormat> format);
[[nodiscard]] std::string_view ExportExtension(std::optional<MeshFormat> format);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_EXPORTS_SURFACE_EXPORT_H_
