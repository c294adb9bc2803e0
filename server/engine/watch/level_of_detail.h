// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How much detail a watcher is sent: all that it asks for, or, while edits come faster than that
// can be sent, as many segments as keep to its limits.
//
//   bits                   the view's own; while a gesture is open those that it asks for then
//   an update fits where   points <= max_points
//                          bytes  <= max_bytes_per_second / kUpdatesPerSecond
//   edits come             until SceneState::busy_until
//   full detail            while none come, and where the update to come fits whole
//   else                   the most segments with which all patches fit, at least 1; during a
//                          drag they only fall, since another pattern sends everything anew
//
// With a tolerance, segments are the most points that a view may have (core/backend.h). Fewer of them double the tolerance.
// Such a view is expected to have as many points as the newest snapshot of at least its segments, if they allow these.
//
// Bytes follow from those of the newest snapshots; a pattern not seen yet is taken for one whose
// neighbours are farther apart: a bit more a component for every halving of the segments.
//
// Threads  one at a time
#ifndef LATTICED_SERVER_ENGINE_WATCH_LEVEL_OF_DETAIL_H_
#define LATTICED_SERVER_ENGINE_WATCH_LEVEL_OF_DETAIL_H_

#include <cstdint>
#include <map>
#include <optional>

#include "absl/time/time.h"
#include "server/engine/scene/scene_state.h"
#include "server/engine/watch/watch_view.h"

namespace latticed {

class LevelOfDetail {
 public:
  // A drag looks smooth at 20 updates a second; a quarter more is for bytes that the limits do not count.
  static constexpr double kUpdatesPerSecond = 25;

  explicit LevelOfDetail(const WatchView& asked) : asked_(asked) {}

  // Chooses the view of the next update. `had`: the view of which the watcher has all chunks, under the
  // state's structure and box; null if none.
  ViewKey Choose(const SceneState& state, const ViewKey* had, absl::Time now);
  // When Choose may return something else without a new state.
  static absl::Time ChangesAt(const SceneState& state) { return state.busy_until; }
  // Whether an update in full detail with `bytes` left to send must give way to one of less detail, which
  // Choose then returns.
  bool GivesWay(const SceneState& state, uint64_t bytes, absl::Time now);
  // Expects the next snapshots with this key to take as many bytes as this one.
  void Learn(const Snapshot& snapshot);

 private:
  bool limited() const { return asked_.max_points > 0 || asked_.max_bytes_per_second > 0; }
  double UpdateBytes() const;
  double BytesPerPointOf(const ViewSpec& spec) const;
  double PointsPerPatchOf(const ViewSpec& spec) const;
  bool Fits(uint64_t patches, const ViewSpec& spec) const;

  WatchView asked_;
  std::optional<int> reduced_;              // segments, during a drag
  std::map<int, double> bytes_per_point_;   // measured, by segments
  std::map<int, double> points_per_patch_;  // of views with a tolerance, measured, by segments
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_WATCH_LEVEL_OF_DETAIL_H_
