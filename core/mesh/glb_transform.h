// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The affine transform of a glTF node: p -> M p + t, M by columns.
//
// A node gives a column-major 4 x 4 matrix, or translation, rotation (quaternion x y z w) and
// scale; empty lists are the identity, lists of another length too.
#ifndef LATTICED_CORE_MESH_GLB_TRANSFORM_H_
#define LATTICED_CORE_MESH_GLB_TRANSFORM_H_

#include <vector>

#include "core/base/vec.h"

namespace latticed {

struct GlbTransform {
  Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};  // columns of M
  Vec3d translation;

  [[nodiscard]] static GlbTransform OfNode(const std::vector<double>& matrix,
                                           const std::vector<double>& translation,
                                           const std::vector<double>& rotation,
                                           const std::vector<double>& scale);

  [[nodiscard]] bool Mirrors() const { return Dot(Cross(x, y), z) < 0; }
  [[nodiscard]] Vec3d Vector(Vec3d v) const { return v.x * x + v.y * y + v.z * z; }
  [[nodiscard]] Vec3d Point(Vec3d p) const { return Vector(p) + translation; }
  // By the inverse transpose of M, to unit length; a normal that M flattens to nothing stays zero.
  [[nodiscard]] Vec3d Normal(Vec3d n) const;

  friend GlbTransform operator*(const GlbTransform& a, const GlbTransform& b) {
    return {a.Vector(b.x), a.Vector(b.y), a.Vector(b.z), a.Point(b.translation)};
  }
};

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_GLB_TRANSFORM_H_
