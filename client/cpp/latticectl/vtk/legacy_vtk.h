// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Legacy files of VTK: https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html, "Simple legacy formats".
// Numbers of binary files are big-endian.
//
// Errors   kInvalidArgument in one sentence, without the file's name
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_VTK_LEGACY_VTK_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_VTK_LEGACY_VTK_H_

#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/vtk/vtk_file.h"

namespace latticed::client {

struct LegacyVtk {
  std::vector<Vec3d> points;
  std::vector<VtkSplice> splices;
  bool is_text = true;
};

[[nodiscard]] absl::StatusOr<LegacyVtk> ParseLegacyVtk(std::string_view bytes);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_VTK_LEGACY_VTK_H_
