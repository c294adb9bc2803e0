// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/patches/point_batch.h"

namespace latticed::client {

void PointBatch::Flush() {
  if (filled_ == 0) return;
  EvaluateBlock(polynomials_[box_], normals_ != nullptr, &block_);
  for (size_t i = 0; i < filled_; ++i) {
    positions_[written_ + i] = {block_.position[0][i], block_.position[1][i],
                                block_.position[2][i]};
    if (normals_ == nullptr) continue;
    normals_[written_ + i] = {block_.normal[0][i], block_.normal[1][i], block_.normal[2][i]};
  }
  for (const Moved& moved : moved_) {
    PointBlock<1> point{};
    for (size_t a = 0; a < 3; ++a) point.local[a][0] = moved.local[a];
    point.weight[0] = moved.weight;
    EvaluateBlock(polynomials_[moved.box], false, &point);
    positions_[moved.point] = {point.position[0][0], point.position[1][0], point.position[2][0]};
  }
  moved_.clear();
  written_ += filled_;
  filled_ = 0;
}

}  // namespace latticed::client
