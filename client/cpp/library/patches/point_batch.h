// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Collects points in the order of a surface, and evaluates those of one box together.
//
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LIBRARY_PATCHES_POINT_BATCH_H_
#define LATTICED_CLIENT_CPP_LIBRARY_PATCHES_POINT_BATCH_H_

#include <array>
#include <cstdint>
#include <vector>

#include "client/cpp/library/patches/box_polynomials.h"
#include "client/cpp/library/patches/point_block.h"
#include "core/base/vec.h"

namespace latticed::client {

using LocalPoint = std::array<float, 3>;

// Of a point of a weighted plan: 0 to 1, and its gradient.
struct PointWeight {
  float value = 0;
  Vec3f slope;
};

class PointBatch {
 public:
  // Writes to positions[0], positions[1], … and to normals, unless that is null.
  PointBatch(const BoxPolynomials& polynomials, Vec3f* positions, Vec3f* normals)
      : polynomials_(polynomials), positions_(positions), normals_(normals) {}

  // The next point.
  void Add(uint32_t box, const LocalPoint& local, Vec3f rest_normal, const PointWeight& weight) {
    if (filled_ == kBlockPoints || box != box_) Flush();
    box_ = box;
    for (size_t a = 0; a < 3; ++a) block_.local[a][filled_] = local[a];
    block_.rest[0][filled_] = rest_normal.x;
    block_.rest[1][filled_] = rest_normal.y;
    block_.rest[2][filled_] = rest_normal.z;
    block_.weight[filled_] = weight.value;
    block_.slope[0][filled_] = weight.slope.x;
    block_.slope[1][filled_] = weight.slope.y;
    block_.slope[2][filled_] = weight.slope.z;
    ++filled_;
  }
  // The last point has its position, but not its normal, in another box.
  void MoveLast(uint32_t box, const LocalPoint& local) {
    moved_.push_back({written_ + filled_ - 1, box, local, block_.weight[filled_ - 1]});
  }
  // Evaluates what has been added. Call it at the end.
  void Flush();

 private:
  struct Moved {
    size_t point;
    uint32_t box;
    LocalPoint local;
    float weight;
  };

  const BoxPolynomials& polynomials_;
  Vec3f* const positions_;
  Vec3f* const normals_;
  PointBlock<kBlockPoints> block_{};
  uint32_t box_ = 0;
  size_t filled_ = 0, written_ = 0;
  std::vector<Moved> moved_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_PATCHES_POINT_BATCH_H_
