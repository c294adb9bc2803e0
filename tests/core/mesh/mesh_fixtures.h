// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Small meshes and file builders for the tests of the formats.
#ifndef LATTICED_TESTS_CORE_MESH_MESH_FIXTURES_H_
#define LATTICED_TESTS_CORE_MESH_MESH_FIXTURES_H_

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/polygon_mesh.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

// A reader's refusal: code, reason, and a message that contains `message`.
MATCHER_P(IsMalformed, message,
          "is INVALID_ARGUMENT, MALFORMED_FILE, with a message that holds '" +
              std::string(message) + "'") {
  const absl::Status& status = ToStatus(arg);
  *result_listener << status.ToString();
  return status.code() == absl::StatusCode::kInvalidArgument &&
         error::DetailsOf(status).reason == "MALFORMED_FILE" &&
         status.message().find(message) != std::string::npos;
}

// The number as raw bytes, little or big endian.
template <typename T>
std::string Raw(T value, bool big_endian = false) {
  std::string bytes(reinterpret_cast<const char*>(&value), sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

// A unit square of two triangles with normals, uvs and one group each. All numbers are exact as floats.
inline PolygonMesh SquareOfTwoGroups(Vec3d origin = {}) {
  PolygonMesh mesh;
  mesh.positions = {origin, origin + Vec3d{1, 0, 0}, origin + Vec3d{1, 1, 0.5},
                    origin + Vec3d{0, 1, 0}};
  mesh.normals = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, -1}};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 0.75f}, {0.25f, 1}};
  mesh.face_offsets = {0, 3, 6};
  mesh.corner_vertices = mesh.corner_normals = mesh.corner_uvs = {0, 1, 2, 0, 2, 3};
  mesh.group_names = {"red", "a \"quoted\" name"};
  mesh.face_groups = {0, 1};
  return mesh;
}

// The data per corner, which does not depend on the order of vertices.
inline std::vector<Vec3d> CornerPositions(const PolygonMesh& mesh) {
  std::vector<Vec3d> positions;
  for (uint32_t v : mesh.corner_vertices) positions.push_back(mesh.positions[v]);
  return positions;
}
inline std::vector<Vec3f> CornerNormals(const PolygonMesh& mesh) {
  std::vector<Vec3f> normals;
  for (uint32_t n : mesh.corner_normals) normals.push_back(mesh.normals[n]);
  return normals;
}
inline std::vector<Vec2f> CornerUvs(const PolygonMesh& mesh) {
  std::vector<Vec2f> uvs;
  for (uint32_t uv : mesh.corner_uvs) uvs.push_back(mesh.uvs[uv]);
  return uvs;
}
}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CORE_MESH_MESH_FIXTURES_H_
