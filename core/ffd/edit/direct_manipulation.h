// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Direct manipulation: the smallest move of control points that takes points of the volume to their targets.
// Hu, Zhang, Tai & Sun, Direct manipulation of FFD, The Visual Computer 17 (2001)
//
//   N dC = dS      N: k x control points, the basis values at the k points; dS = targets - R
//   dC = N^+ dS    one point: dC = N' dS / sum N^2; else minimum_norm.h
//
// Under constraints (constraints/point_freedom.h) the columns of held control points are missing. With a mirror a pair of
// images i, j moves by d and its image. Across the mirror's plane they move against each other, along it together, so there
// are two systems with one column a pair: (N_i - N_j) / sqrt(2) and (N_i + N_j) / sqrt(2).
//
// A point with the weight w is at x + w (R - x) (weights/vertex_weights.h), so its row is w N. outside/outside_map.h, whose
// E continues the lattice and has the scene's strength as a factor, turns rows N into N E.
//
// A point outside the domain and what goes on beyond it, or of weight 0, has an empty row: no control point moves it, and its
// distance is left as residual.
//
// Units    world units
// Errors   none: callers check what clients send
// Threads  pure function
#ifndef LATTICED_CORE_FFD_EDIT_DIRECT_MANIPULATION_H_
#define LATTICED_CORE_FFD_EDIT_DIRECT_MANIPULATION_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/vec.h"
#include "core/ffd/constraints/point_freedom.h"
#include "core/ffd/lattice.h"

namespace latticed {

struct ControlPointMoves {
  std::vector<uint32_t>
      indices;  // free control points with a non-zero basis value, or whose image has one; ascending
  std::vector<Vec3d> offsets;
  double residual = 0;  // largest distance that is left between a point and its target
};

// The smallest moves that take `points` of the rest world from their deformed positions to their
// targets. Each point has one target. `freedom` may be null, and `weights` empty: then
// each weight is 1. `strength` is the scene's, above 0.
[[nodiscard]] ControlPointMoves DragToTargets(const Lattice& lattice, std::span<const Vec3d> points,
                                              std::span<const Vec3d> targets,
                                              const PointFreedom* freedom = nullptr,
                                              std::span<const double> weights = {},
                                              double strength = 1);

}  // namespace latticed

#endif  // LATTICED_CORE_FFD_EDIT_DIRECT_MANIPULATION_H_
