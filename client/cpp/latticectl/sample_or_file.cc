// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/sample_or_file.h"

#include <algorithm>

#include "core/base/status_macros.h"
#include "core/mesh/obj_io.h"

namespace latticed::client {

absl::StatusOr<MeshFile> SampleOrFile(const std::string& name, int resolution) {
  const auto names = SampleMeshNames();
  if (std::find(names.begin(), names.end(), name) == names.end()) return ReadMeshFile(name);
  LATTICED_ASSIGN_OR_RETURN(const auto mesh, MakeSampleMesh(name, resolution));
  return MeshFile{name + ".obj", MeshFormat::kObj, WriteObj(mesh)};
}

}  // namespace latticed::client
