// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The definition of the deformation, in double: what every backend and pipeline is measured
// against, and what answers single points.
//
//   inside the domain   x -> R(u(x)),  J = dR/du * du/dx         formula (1)
//   outside             x -> x,        J = I
//   facet normal        cof(J) (e1 x e2) / |…|
//   smooth normal       cof(J) N / |…|,  N the interpolated vertex normal of the source triangle
//   kappa               of carried_normal.h, which also says when a normal is replaced
//
// e1 x e2 is the normal of the source triangle: that of a sliver drowns in its corners' rounding.
//
// Points of an attached seam need no rule here: R is the identity on it to the last bits of a
// double.
//
// Units    world units; Jacobians are columns d(deformed)/d(x, y, z)
// Errors   none: plans and control points are validated where they are made
// Threads  pure; a DirectFfd may be shared, it refers to the plan and the control points it was
// given
#ifndef LATTICED_CORE_FFD_DIRECT_FFD_H_
#define LATTICED_CORE_FFD_DIRECT_FFD_H_

#include <array>
#include <optional>
#include <span>

#include "core/base/vec.h"
#include "core/ffd/carried_normal.h"
#include "core/ffd/deform_plan.h"
#include "core/ffd/lattice.h"
#include "core/ffd/volume_point.h"

namespace latticed {

// On the knot box with the given spans; `parameter` may leave it, the box's polynomial goes on.
[[nodiscard]] VolumePoint EvaluateVolume(const LatticeStructure& structure,
                                         std::span<const Vec3d> control_points,
                                         const std::array<int, 3>& span, Vec3d parameter);

// The place of a point of the rest world in the volume.
struct VolumePlace {
  Vec3d parameter;
  std::array<int, 3> span{};  // of the lower box on a knot plane
};
// nullopt outside the domain. A point within kPlaneSnap of a face of the domain is on it, as a
// vertex of the mesh would be.
[[nodiscard]] std::optional<VolumePlace> FindVolumePlace(const LatticeStructure& structure,
                                                         Vec3d world);

struct DeformedPoint {
  Vec3d position;
  std::array<Vec3d, 3> jacobian{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};  // columns
  bool inside = false;  // of the lattice's domain, faces included
};

// Any point of the world: the lower box of a knot plane decides its Jacobian.
[[nodiscard]] DeformedPoint EvaluateWorld(const LatticeStructure& structure,
                                          std::span<const Vec3d> control_points, Vec3d world);

[[nodiscard]] inline Vec3d ApplyCofactor(const std::array<Vec3d, 3>& jacobian, Vec3d n) {
  return ApplyCofactor(jacobian.data(), n);
}
[[nodiscard]] inline double CofactorNorm(const std::array<Vec3d, 3>& jacobian) {
  return CofactorNorm(jacobian.data());
}

class DirectFfd {
 public:
  enum class Normal { kFacet, kSmooth };
  struct SurfacePoint {
    Vec3d position;
    Vec3d normal;
    double kappa = 1;          // at the point itself; infinity where the normal vanishes
    bool substituted = false;  // the normal is the centroid's or the rest's
  };

  DirectFfd(const DeformPlan& plan, std::span<const Vec3d> control_points);

  // Point of a patch at barycentrics that sum to 1.
  [[nodiscard]] SurfacePoint Evaluate(size_t patch, std::array<double, 3> barycentrics,
                                      Normal normal) const;
  [[nodiscard]] DeformedPoint EvaluatePosition(size_t patch,
                                               std::array<double, 3> barycentrics) const;
  // Unit normal of the undeformed patch's source triangle; of the patch where that has no area, and
  // +z where neither has.
  [[nodiscard]] Vec3d RestFacetNormal(size_t patch) const;
  // The interpolated vertex normal, not normalised.
  [[nodiscard]] Vec3d RestSmoothNormal(size_t patch, std::array<double, 3> barycentrics) const;
  // The normal that points of ill condition get: the centroid's, else the rest normal there.
  [[nodiscard]] Vec3d SubstituteNormal(size_t patch, Normal normal) const;

 private:
  Vec3d RestNormal(size_t patch, std::array<double, 3> barycentrics, Normal normal) const;

  const DeformPlan& plan_;
  std::span<const Vec3d> control_points_;
  std::array<Vec3d, 3> parameter_by_world_;  // d(u,v,w) / d(x, y, z), columns
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_DIRECT_FFD_H_
