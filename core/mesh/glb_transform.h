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

inline GlbTransform GlbTransform::OfNode(const std::vector<double>& matrix,
                                         const std::vector<double>& translation,
                                         const std::vector<double>& rotation,
                                         const std::vector<double>& scale) {
  GlbTransform result;
  if (matrix.size() == 16) {
    const auto column = [&](size_t c) {
      return Vec3d{matrix[4 * c], matrix[4 * c + 1], matrix[4 * c + 2]};
    };
    return {column(0), column(1), column(2), column(3)};
  }
  if (rotation.size() == 4) {
    const double i = rotation[0], j = rotation[1], k = rotation[2], r = rotation[3];
    result.x = {1 - 2 * (j * j + k * k), 2 * (i * j + k * r), 2 * (i * k - j * r)};
    result.y = {2 * (i * j - k * r), 1 - 2 * (i * i + k * k), 2 * (j * k + i * r)};
    result.z = {2 * (i * k + j * r), 2 * (j * k - i * r), 1 - 2 * (i * i + j * j)};
  }
  if (scale.size() == 3) {
    result.x = scale[0] * result.x;
    result.y = scale[1] * result.y;
    result.z = scale[2] * result.z;
  }
  if (translation.size() == 3)
    result.translation = {translation[0], translation[1], translation[2]};
  return result;
}

inline Vec3d GlbTransform::Normal(Vec3d n) const {
  // The cofactor matrix is det(M) times the inverse transpose: its columns are the cross products.
  const Vec3d carried = n.x * Cross(y, z) + n.y * Cross(z, x) + n.z * Cross(x, y);
  const double length = Norm(carried);
  if (length == 0) return {};
  return (Mirrors() ? -1.0 : 1.0) * (carried / length);
}

}  // namespace latticed

#endif  // LATTICED_CORE_MESH_GLB_TRANSFORM_H_
