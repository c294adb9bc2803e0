// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Turns a lattice about the centre of its frame: about the world's x axis, then y, then z.
//
//   x -> m + Rz Ry Rx (x - m)        m the frame's centre, R the right-handed rotations of column vectors
//
// This is the order of Blender's Euler XYZ and of USD's rotateXYZ. The frame turns, and the control points with it: a lattice
// at rest stays at rest, bit for bit the identity of its new frame.
//
// Units    degrees; multiples of 90 are exact
// Threads  pure
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_TURN_LATTICE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_TURN_LATTICE_H_

#include "core/ffd/lattice.h"

namespace latticed::client {

void TurnLattice(Vec3d degrees, Lattice& lattice);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_TURN_LATTICE_H_
