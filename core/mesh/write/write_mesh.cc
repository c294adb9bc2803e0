// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/mesh/write/write_mesh.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/mesh/triangulated.h"

namespace latticed {

bool KeepsPolygons(MeshFormat format) {
  return format == MeshFormat::kObj || format == MeshFormat::kPly || format == MeshFormat::kUsd;
}

absl::StatusOr<std::string> WriteMesh(MeshFormat format, const PolygonMesh& mesh,
                                      const FileExtras& extras) {
  if (!KeepsPolygons(format) && !IsTriangular(mesh)) {
    LATTICED_ASSIGN_OR_RETURN(const auto triangles, Triangulated(mesh));
    return WriteMesh(format, triangles, extras);
  }
  switch (format) {
    case MeshFormat::kObj:
      return WriteObj(mesh, extras);
    case MeshFormat::kPly:
      return WritePly(mesh, extras);
    case MeshFormat::kStl:
      return WriteStl(mesh, extras);
    case MeshFormat::kGlb:
      return WriteGlb(mesh, extras);
    case MeshFormat::kUsd:
      return WriteUsd(mesh, extras);
    case MeshFormat::kDraco:
      break;
  }
  return error::Unimplemented("writing Draco without the codec");
}

}  // namespace latticed
