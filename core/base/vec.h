// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Three-vectors in double (world and parameter space) and the float pairs and triples of meshes.
#ifndef LATTICED_CORE_BASE_VEC_H_
#define LATTICED_CORE_BASE_VEC_H_

#include <cmath>

#include "core/base/host_device.h"

namespace latticed {

struct Vec2f {
  float x = 0, y = 0;
  friend bool operator==(const Vec2f&, const Vec2f&) = default;
};

struct Vec3f {
  float x = 0, y = 0, z = 0;
  friend bool operator==(const Vec3f&, const Vec3f&) = default;
};

struct Vec3d {
  double x = 0, y = 0, z = 0;

  // Component by axis: 0 = x, 1 = y, 2 = z (or u, v, w for parameters).
  constexpr double operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
  constexpr double& operator[](int axis) { return axis == 0 ? x : axis == 1 ? y : z; }

  friend constexpr bool operator==(const Vec3d&, const Vec3d&) = default;
  friend constexpr auto operator<=>(const Vec3d&, const Vec3d&) = default;
  friend constexpr Vec3d operator+(Vec3d a, Vec3d b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3d operator-(Vec3d a, Vec3d b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3d operator-(Vec3d a) { return {-a.x, -a.y, -a.z}; }
  friend constexpr Vec3d operator*(double s, Vec3d a) { return {s * a.x, s * a.y, s * a.z}; }
  friend constexpr Vec3d operator*(Vec3d a, double s) { return s * a; }
  friend constexpr Vec3d operator/(Vec3d a, double s) { return {a.x / s, a.y / s, a.z / s}; }
  constexpr Vec3d& operator+=(Vec3d b) { return *this = *this + b; }
  constexpr Vec3d& operator-=(Vec3d b) { return *this = *this - b; }
};

constexpr double Dot(Vec3d a, Vec3d b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3d Cross(Vec3d a, Vec3d b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
LATTICED_HD inline double Norm(Vec3d a) { return std::sqrt(Dot(a, a)); }
LATTICED_HD inline bool IsFinite(Vec3d a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
constexpr Vec3d ToDouble(Vec3f a) { return {double{a.x}, double{a.y}, double{a.z}}; }
constexpr Vec3f ToFloat(Vec3d a) {
  return {static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z)};
}
constexpr Vec3d Min(Vec3d a, Vec3d b) {
  return {a.x < b.x ? a.x : b.x, a.y < b.y ? a.y : b.y, a.z < b.z ? a.z : b.z};
}
constexpr Vec3d Max(Vec3d a, Vec3d b) {
  return {a.x > b.x ? a.x : b.x, a.y > b.y ? a.y : b.y, a.z > b.z ? a.z : b.z};
}

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_VEC_H_
