// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Binary STL: a header of 80 bytes, the number of facets, and for each a normal, three positions and two spare bytes.
#include <cmath>

#include "core/mesh/little_endian.h"
#include "core/mesh/stl_layout.h"
#include "core/mesh/write/write_mesh.h"

namespace latticed {
namespace {

Vec3d FacetNormal(Vec3d a, Vec3d b, Vec3d c) {
  const Vec3d normal = Cross(b - a, c - a);
  const double length = Norm(normal);
  return length > 0 && std::isfinite(length) ? normal / length : Vec3d{};
}

}  // namespace

std::string WriteStl(const PolygonMesh& mesh, const FileExtras& extras) {
  std::string out = "binary STL, latticed";  // must not start with "solid"
  if (extras.units.known()) out += ", " + Describe(extras.units);
  out.resize(stl::kHeaderBytes, ' ');
  out.reserve(stl::kPreambleBytes + stl::kFacetBytes * mesh.face_count());
  AppendLittleEndian(static_cast<uint32_t>(mesh.face_count()), &out);
  for (size_t c = 0; c < mesh.corner_count(); c += 3) {
    Vec3d corners[3];
    for (size_t i = 0; i < 3; ++i) corners[i] = mesh.positions[mesh.corner_vertices[c + i]];
    AppendLittleEndian(ToFloat(FacetNormal(corners[0], corners[1], corners[2])), &out);
    for (const Vec3d corner : corners) AppendLittleEndian(ToFloat(corner), &out);
    AppendLittleEndian(uint16_t{0}, &out);
  }
  return out;
}

}  // namespace latticed
