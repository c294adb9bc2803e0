// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/codec/row_order.h"

#include <cstring>

#include "core/ffd/tessellation_pattern.h"

namespace latticed::bench {

std::vector<uint8_t> RowByRow(std::span<const uint8_t> integers, const ViewSpec& spec) {
  const int segments = spec.segments;
  std::vector<size_t> from;  // of the points of a patch
  for (int row = 0; row <= segments; ++row) {
    for (int column = 0; column <= segments - row; ++column) {
      from.push_back(static_cast<size_t>(PointIndex(segments, row, column)));
    }
  }
  const size_t points = integers.size() / BytesPerPoint(spec);
  std::vector<uint8_t> rows(integers.size());
  size_t begin = 0;
  const auto copy_plane = [&](size_t width) {
    for (size_t i = 0; i < points; ++i) {
      const size_t in_patch = i % from.size();
      std::memcpy(&rows[begin + width * i],
                  &integers[begin + width * (i - in_patch + from[in_patch])], width);
    }
    begin += width * points;
  };
  for (int axis = 0; axis < 3; ++axis) copy_plane(2);
  for (int component = 0; component < 2 && spec.normals != NormalMode::kNone; ++component) {
    copy_plane(spec.normal_bits <= 8 ? 1 : 2);
  }
  return rows;
}

}  // namespace latticed::bench
