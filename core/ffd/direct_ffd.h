// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The definition of the deformation, in double. Every backend and pipeline is measured against it, and requests for
// single points are answered by it.
//
//   inside the domain   x -> R(u(x)),  J = dR/du * du/dx         formula (1)
//   outside             x -> x,        J = I
//   turned lattices     add what they move x, and its derivatives (turned/turned_lattice.h), inside and outside
//   with weights        x -> x + w (F(x) - x), and the J of weights/vertex_weights.h, where F and J are those above
//   facet normal        cof(J) (e1 x e2) / |…|
//   smooth normal       cof(J) N / |…|,  N the interpolated vertex normal of the source triangle
//   kappa               of carried_normal.h, which also says when a normal is replaced
//
// e1 and e2 are edges of the source triangle, because the normal of a sliver patch is lost in its corners' rounding.
//
// Points of an attached seam need no rule here: R differs from the identity there only in the last bits of a double.
//
// Units    world units; Jacobians are columns d(deformed)/d(x, y, z)
// Errors   none: plans and control points are validated where they are made
// Threads  pure; a DirectFfd may be shared. It keeps references to the plan and the control points
#ifndef LATTICED_CORE_FFD_DIRECT_FFD_H_
#define LATTICED_CORE_FFD_DIRECT_FFD_H_

#include <array>
#include <optional>
#include <span>

#include "core/base/vec.h"
#include "core/ffd/box/volume_point.h"
#include "core/ffd/carried_normal.h"
#include "core/ffd/lattice.h"
#include "core/ffd/plan/deform_plan.h"
#include "core/ffd/turned/turned_lattice.h"

namespace latticed {

// Evaluates the polynomial of the knot box with the given spans; `parameter` may lie outside the box.
[[nodiscard]] VolumePoint EvaluateVolume(const LatticeStructure& structure,
                                         std::span<const Vec3d> control_points,
                                         const std::array<int, 3>& span, Vec3d parameter);
// The same without derivatives.
[[nodiscard]] Vec3d EvaluateVolumePosition(const LatticeStructure& structure,
                                           std::span<const Vec3d> control_points,
                                           const std::array<int, 3>& span, Vec3d parameter);

// The columns d(u, v, w) / d(x, y, z).
[[nodiscard]] std::array<Vec3d, 3> ParameterByWorld(const LatticeStructure& structure);

// Where a point of the rest world lies in the volume.
struct VolumePlace {
  Vec3d parameter;
  std::array<int, 3> span{};  // of the lower box on a knot plane
};
// nullopt outside the domain. A point within kPlaneSnap of a face of the domain is on it, like a vertex of the mesh.
[[nodiscard]] std::optional<VolumePlace> FindVolumePlace(const LatticeStructure& structure,
                                                         Vec3d world);
// The same for many points: `map` is the structure's.
[[nodiscard]] std::optional<VolumePlace> FindVolumePlace(const LatticeStructure& structure,
                                                         const FrameMap& map, Vec3d world);

struct DeformedPoint {
  Vec3d position;
  std::array<Vec3d, 3> jacobian{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};  // columns
  bool inside = false;  // of the lattice's domain, faces included
};

// Deforms any point of the world. On a knot plane, the Jacobian is that of the lower box.
[[nodiscard]] DeformedPoint EvaluateWorld(const LatticeStructure& structure,
                                          std::span<const Vec3d> control_points, Vec3d world);

// The same under all lattices of a plan, without weights: a point of the world has none.
[[nodiscard]] DeformedPoint EvaluateWorld(const DeformPlan& plan,
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

  // The point of a patch at barycentrics that sum to 1.
  [[nodiscard]] SurfacePoint Evaluate(size_t patch, std::array<double, 3> barycentrics,
                                      Normal normal) const;
  [[nodiscard]] DeformedPoint EvaluatePosition(size_t patch,
                                               std::array<double, 3> barycentrics) const;
  // At the place t from vertex ends[0] to vertex ends[1], which are equal or joined by an edge, where the plan's own lattice has
  // the polynomial of `box`. The outside box: its own lattice does not move it.
  [[nodiscard]] Vec3d OnEdge(uint32_t box, const std::array<uint32_t, 2>& ends, double t) const;
  // Unit normal of the patch's source triangle at rest; of the patch, if the source has no area; +z if neither has.
  [[nodiscard]] Vec3d RestFacetNormal(size_t patch) const;
  // The interpolated vertex normal, not normalised.
  [[nodiscard]] Vec3d RestSmoothNormal(size_t patch, std::array<double, 3> barycentrics) const;
  // The replacement for an ill-conditioned normal: the centroid's, or the rest normal there if that is no better.
  [[nodiscard]] Vec3d SubstituteNormal(size_t patch, Normal normal) const;

 private:
  Vec3d RestNormal(size_t patch, std::array<double, 3> barycentrics, Normal normal) const;

  const DeformPlan& plan_;
  std::span<const Vec3d> control_points_;
  std::array<Vec3d, 3> parameter_by_world_;
  TurnedMoves turned_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_DIRECT_FFD_H_
