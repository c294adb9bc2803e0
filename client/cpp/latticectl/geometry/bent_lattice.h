// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Twists a lattice about the longest edge of its frame, then bends that edge to an arc.
//                    Barr 1984, "Global and local deformations of solid primitives", doi:10.1145/800031.808573
//
//   a the axis of the longest edge (the first of equal ones), b and c the next two in turn, m the frame's centre,
//   L the edge's length, (x, y, z) a point minus m along a, b, c,  t = x / L in [-1/2, 1/2] in the frame
//
//   twist   (y, z) -> (y cos(T t) - z sin(T t), y sin(T t) + z cos(T t))            T the twist
//   bend    (x, z) -> ((R - z) sin(B t), R - (R - z) cos(B t)),  R = L / B          B the bend; 0: unchanged
//
// The control points move by these formulas. The B-spline approximates them: more control points come closer.
//
// Units    angles in radians; the ends of the edge differ by T and B. A bend above 0 lifts both ends towards +c
// Needs    a frame whose edges lie along x, y and z, as FitLattice makes it
// Threads  pure
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_BENT_LATTICE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_BENT_LATTICE_H_

#include "core/ffd/lattice.h"

namespace latticed::client {

void BendLattice(double twist, double bend, Lattice& lattice);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_BENT_LATTICE_H_
