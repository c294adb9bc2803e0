// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What goes on outside a lattice's frame, as a flag says it:
//
//   fixed                points outside stay
//   falloff:0.3          fades out at 0.3 of the frame's edge, smoothly; falloff:0.3:c0 without overshoot
//   falloff:0,1,0,0,0,0  a width for the beginning and end of u, of v, of w; 0: points beyond this face stay
//   linear               goes on along straight lines, as far as the mesh reaches; linear:2, as far as this
//
// Errors   kInvalidArgument
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_OUTSIDE_TEXT_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_OUTSIDE_TEXT_H_

#include <string>

#include "absl/status/statusor.h"
#include "latticed/v1/lattice.pb.h"

namespace latticed::client {

inline constexpr char kOutsideHelp[] =
    "What goes on outside: fixed, linear, linear:WIDTH, falloff:WIDTH or falloff:WIDTH:c0 (without "
    "overshoot). WIDTH is a part of the box's edges: one number, or six for the beginning and end "
    "of u, of v, of w, as in falloff:0,0,0,0,0,0.5; 0: points beyond that face stay";

[[nodiscard]] absl::StatusOr<v1::LatticeOutside> ParseOutside(const std::string& text);
// A check for CLI11: returns an error text unless ParseOutside takes it.
[[nodiscard]] std::string CheckOutside(const std::string& text);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_GEOMETRY_OUTSIDE_TEXT_H_
