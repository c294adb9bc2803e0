// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes mesh files, by format.
//
//   format  polygons  vertex                    groups             units
//   OBJ     kept      position, uv, normal each usemtl             comment
//                     with an index of its own
//   PLY     kept      one record                none               comment
//   USD     kept      position; uv and normal   GeomSubset with    upAxis, metersPerUnit
//                     by corner                 a material
//   GLB     triangles one record                primitive with     root node (metres, +y up), asset.extras
//                                               a material
//   STL     triangles position alone            none               header
//
// One record: vertex_records.h. Faces that a format does not keep are divided by the rule of triangulate.h.
//
// Units    world units; numbers of OBJ are the shortest decimals that read back to the same bits. GLB and USD have
//          float32 about the centre of the bounds, which is a translation: a mesh far from the origin keeps its
//          precision. PLY and STL have float32, so vertices far from the origin may coincide
// Errors   kResourceExhausted above the 4 GiB of a GLB; kInvalidArgument for a face that cannot be divided;
//          kUnimplemented for Draco, which core/codec writes
// Threads  pure functions
#ifndef LATTICED_CORE_MESH_WRITE_WRITE_MESH_H_
#define LATTICED_CORE_MESH_WRITE_WRITE_MESH_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/mesh_units.h"
#include "core/mesh/polygon_mesh.h"

namespace latticed {

// What a file says besides the mesh.
struct FileExtras {
  MeshUnits units;
  // The file that the mesh was read from, or empty: its materials and pictures are kept. A GLB keeps those of a GLB,
  // an OBJ the mtllib lines of an OBJ. Otherwise materials have names alone, those of the groups.
  std::string_view source;
  MeshFormat source_format = MeshFormat::kObj;
};

[[nodiscard]] absl::StatusOr<std::string> WriteMesh(MeshFormat format, const PolygonMesh& mesh,
                                                    const FileExtras& extras = {});

// Whether files of this format have faces of more than three corners.
[[nodiscard]] bool KeepsPolygons(MeshFormat format);

// The same by one format. Those that have triangles alone take a mesh of triangles.
[[nodiscard]] std::string WriteObj(const PolygonMesh& mesh, const FileExtras& extras = {});
[[nodiscard]] std::string WritePly(const PolygonMesh& mesh, const FileExtras& extras = {});
[[nodiscard]] std::string WriteStl(const PolygonMesh& mesh, const FileExtras& extras = {});
[[nodiscard]] std::string WriteUsd(const PolygonMesh& mesh, const FileExtras& extras = {});
[[nodiscard]] absl::StatusOr<std::string> WriteGlb(const PolygonMesh& mesh,
                                                   const FileExtras& extras = {});

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_WRITE_WRITE_MESH_H_
