// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How many updates were compared with the definition, at how many points, and how far off the worst
// of them were.
#ifndef LATTICED_CLIENT_CPP_LOAD_VERIFIED_POINTS_H_
#define LATTICED_CLIENT_CPP_LOAD_VERIFIED_POINTS_H_

#include <algorithm>
#include <cstdint>

namespace latticed::client {

struct VerifiedPoints {
  uint64_t updates = 0, positions = 0, normals = 0;
  double worst_position = 0, worst_normal = 0;  // of what is allowed

  void Add(const VerifiedPoints& other) {
    updates += other.updates;
    positions += other.positions;
    normals += other.normals;
    worst_position = std::max(worst_position, other.worst_position);
    worst_normal = std::max(worst_normal, other.worst_normal);
  }
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_VERIFIED_POINTS_H_
