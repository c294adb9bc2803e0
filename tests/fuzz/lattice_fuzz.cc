// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reads a Lattice message from JSON, as `latticectl apply --lattice` does. An accepted lattice must be
// valid, and its plan for a tetrahedron, if there is one, must have patches.
#include <google/protobuf/util/json_util.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>

#include "core/ffd/plan/deform_plan.h"
#include "server/wire/converters.h"

namespace {

std::shared_ptr<const latticed::PolygonMesh> Tetrahedron() {
  auto mesh = std::make_shared<latticed::PolygonMesh>();
  mesh->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh->corner_vertices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  mesh->face_offsets = {0, 3, 6, 9, 12};
  return mesh;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const auto mesh = Tetrahedron();
  latticed::v1::Lattice message;
  const std::string json(reinterpret_cast<const char*>(data), size);
  if (!google::protobuf::util::JsonStringToMessage(json, &message).ok()) return 0;
  const auto lattice = latticed::FromProto(message, "lattice");
  if (!lattice.ok()) return 0;
  if (!latticed::Validate(*lattice).ok()) std::abort();
  const auto plan = latticed::MakePlan(mesh, lattice->structure);
  if (plan.ok() && (*plan)->patches.empty()) std::abort();
  return 0;
}
