// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// XML files of VTK: UnstructuredGrid, PolyData and StructuredGrid, of one piece or several.
//
// Errors   kInvalidArgument in one sentence, without the file's name
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_VTK_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_VTK_H_

#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/vtk/vtk_file.h"

namespace latticed::client {

struct XmlVtk {
  std::vector<Vec3d> points;
  std::vector<VtkSplice> splices;
};

[[nodiscard]] absl::StatusOr<XmlVtk> ParseXmlVtk(std::string_view bytes);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_VTK_XML_VTK_H_
