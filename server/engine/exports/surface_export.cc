// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/exports/surface_export.h"

#include <algorithm>

#include "core/adaptive/edge_levels.h"
#include "core/base/status_macros.h"
#include "core/codec/draco_decode.h"
#include "core/mesh/write/write_mesh.h"
#include "core/mesh/write/writing_memory.h"
#include "server/engine/exports/control_nets.h"
#include "server/engine/exports/exact_surface.h"
#include "server/engine/exports/original_mesh.h"

namespace latticed {
namespace {

// The vertices of a chunk, and what does not grow with the surface.
constexpr uint64_t kSmallBytes = uint64_t{128} << 10;

// The upload, if the exported file takes materials from it.
std::string_view MaterialsOf(const ExportSpec& spec) {
  return spec.upload == nullptr ? std::string_view() : *spec.upload;
}

ViewSpec ViewOf(const ExportSpec& spec) {
  return {.segments = spec.segments, .tolerance = spec.tolerance, .normals = spec.normals};
}

Welding WeldingOf(const ExportSpec& spec) {
  return spec.geometry == ExportGeometry::kPatches ? Welding::kNone : Welding::kShared;
}

// How far the grid of a DRC file moves points. Its cube is not larger than the quantisation box.
double FileRounding(const QuantisationBox& box, const ExportSpec& spec) {
  if (spec.format != MeshFormat::kDraco) return 0;
  return PointError(box, spec.position_bits) - PointError(box, 0);
}

absl::StatusOr<PolygonMesh> MeshToWrite(const RenderInput& input, const ExportSpec& spec,
                                        StopCheck stop, double* certified_error) {
  if (spec.geometry == ExportGeometry::kOriginal) {
    return OriginalMesh(*input.state, spec.normals, KeepsPolygons(*spec.format), stop);
  }
  ViewSpec view = ViewOf(spec);
  const Welding welding = WeldingOf(spec);
  if (!(view.tolerance > 0)) return ExactSurface(input, view, stop, welding);
  const double rounding = FileRounding(input.state->box, spec);
  view.tolerance -= rounding;
  LATTICED_ASSIGN_OR_RETURN(auto mesh, ExactSurface(input, view, stop, welding, certified_error));
  *certified_error += rounding;
  return mesh;
}

}  // namespace

uint64_t ExportMemoryBytes(const DeformPlan& plan, const ExportSpec& spec) {
  if (!spec.format.has_value()) return ControlNetsBytes(plan);
  const SurfaceMemory memory =
      spec.geometry == ExportGeometry::kOriginal
          ? MemoryOfOriginalMesh(plan, spec.normals, KeepsPolygons(*spec.format))
          : MemoryOfExactSurface(plan, ViewOf(spec), WeldingOf(spec));
  return MeshBytes(memory.sizes) +
         std::max(memory.working_bytes,
                  MostWritingBytes(*spec.format, memory.sizes, MaterialsOf(spec))) +
         kSmallBytes;
}

absl::StatusOr<ExportedFile> ExportSurface(const RenderInput& input, const ExportSpec& spec,
                                           StopCheck stop) {
  ExportedFile file;
  if (!spec.format.has_value()) {
    LATTICED_ASSIGN_OR_RETURN(file.bytes, WriteControlNets(input, stop));
    return file;
  }
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, MeshToWrite(input, spec, stop, &file.certified_error));
  if (*spec.format == MeshFormat::kDraco) {
    LATTICED_ASSIGN_OR_RETURN(file.bytes,
                              WriteDracoMesh(mesh, spec.position_bits, spec.normal_bits));
    return file;
  }
  LATTICED_ASSIGN_OR_RETURN(
      file.bytes,
      WriteMesh(*spec.format, mesh,
                {.units = spec.units, .source = MaterialsOf(spec), .source_format = *spec.format}));
  return file;
}

std::string_view ExportMediaType(std::optional<MeshFormat> format) {
  if (!format.has_value()) return "application/octet-stream";
  switch (*format) {
    case MeshFormat::kObj:
      return "model/obj";
    case MeshFormat::kStl:
      return "model/stl";
    case MeshFormat::kGlb:
      return "model/gltf-binary";
    case MeshFormat::kUsd:
      return "model/vnd.usda";
    case MeshFormat::kPly:
    case MeshFormat::kDraco:
      break;
  }
  return "application/octet-stream";  // neither has a registered type
}

std::string_view ExportExtension(std::optional<MeshFormat> format) {
  return format.has_value() ? MeshFormatExtension(*format) : "nets";
}

}  // namespace latticed
