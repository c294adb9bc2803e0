// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/watch/level_of_detail.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/limits.h"
#include "core/ffd/tessellation_pattern.h"

namespace latticed {
namespace {

// Draco streams usually have at most a quarter of the bytes of the integers that they encode.
constexpr double kIntegersPerDraco = 4;

}  // namespace

ViewKey LevelOfDetail::Choose(const SceneState& state, const ViewKey* had, absl::Time now) {
  ViewKey key = asked_.key;
  ViewSpec& spec = key.spec;
  if (state.gesture_open) {
    if (asked_.drag_position_bits > 0) spec.position_bits = asked_.drag_position_bits;
    if (asked_.drag_normal_bits > 0) spec.normal_bits = asked_.drag_normal_bits;
  }
  if (!limited() || now >= state.busy_until) {
    reduced_.reset();
    return key;
  }
  const uint64_t patches = state.plan->patches.size();
  if (!reduced_.has_value()) {
    const bool whole = had == nullptr || *had != key;
    if (Fits(whole ? patches : state.patches_touched, spec)) return key;
    reduced_ = spec.segments;
  }
  spec.segments = *reduced_;
  while (spec.segments > limits::kMinSegments && !Fits(patches, spec)) --spec.segments;
  reduced_ = spec.segments;
  return key;
}

bool LevelOfDetail::GivesWay(const SceneState& state, uint64_t bytes, absl::Time now) {
  const int segments = asked_.key.spec.segments;
  if (now >= state.busy_until || segments == limits::kMinSegments) return false;
  if (static_cast<double>(bytes) <= UpdateBytes()) return false;
  reduced_ = segments - 1;
  return true;
}

void LevelOfDetail::Learn(const Snapshot& snapshot) {
  if (!limited()) return;
  uint64_t bytes = 0;
  for (size_t c = 0; c < snapshot.chunks.size(); ++c) bytes += snapshot.chunks[c].data.size();
  uint64_t points = PatternPoints(snapshot.patterns.codes);
  const int segments = snapshot.view.spec.segments;
  const size_t patches = snapshot.plan->patches.size();
  if (points > 0) {
    points_per_patch_[segments] = static_cast<double>(points) / static_cast<double>(patches);
  } else {
    points = patches * static_cast<size_t>(PointsPerPatch(segments));
  }
  bytes_per_point_[segments] = static_cast<double>(bytes) / static_cast<double>(points);
}

double LevelOfDetail::UpdateBytes() const {
  if (asked_.max_bytes_per_second == 0) return std::numeric_limits<double>::infinity();
  return static_cast<double>(asked_.max_bytes_per_second) / kUpdatesPerSecond;
}

double LevelOfDetail::BytesPerPointOf(const ViewSpec& spec) const {
  const auto integers = static_cast<double>(BytesPerPoint(spec));
  if (!IsCompressed(asked_.key.encoding)) return integers;
  const auto measured = bytes_per_point_.lower_bound(spec.segments);
  const bool known = measured != bytes_per_point_.end();
  const double bytes = known ? measured->second : integers / kIntegersPerDraco;
  const int from = known ? measured->first : asked_.key.spec.segments;
  const int components = spec.normals == NormalMode::kNone ? 3 : 5;
  return bytes + components / 8.0 * std::log2(static_cast<double>(from) / spec.segments);
}

double LevelOfDetail::PointsPerPatchOf(const ViewSpec& spec) const {
  const double most = PointsPerPatch(spec.segments);
  const auto measured = points_per_patch_.lower_bound(spec.segments);
  if (!(spec.tolerance > 0) || measured == points_per_patch_.end()) return most;
  return std::min(most, measured->second);
}

bool LevelOfDetail::Fits(uint64_t patches, const ViewSpec& spec) const {
  const double points = static_cast<double>(patches) * PointsPerPatchOf(spec);
  if (asked_.max_points > 0 && points > static_cast<double>(asked_.max_points)) return false;
  return points * BytesPerPointOf(spec) <= UpdateBytes();
}

}  // namespace latticed
