// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What a load is: who edits and who watches each scene, and when the next edit is due.
//
//   closed    when the update that holds the last edit is here (and decoded, where it is)
//   open      every period, whatever the server does
//   interval  every period, but one batch is on its way at a time, and while it is the newest edit
//             replaces those that wait: what a browser's drag does
//
// Edits of a period are counted from the time they were due, not from when they could be sent.
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_PLAN_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_PLAN_H_

#include <cstdint>
#include <string>

#include "absl/time/time.h"
#include "latticed/v1/edit.pb.h"
#include "latticed/v1/lattice.pb.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

enum class LoadMode { kClosed, kOpen, kInterval };

// Whose updates are decoded, in the thread that reads them.
enum class Decoding {
  kFirst,  // of each scene's first editor
  kAll,    // of all editors and of the watchers that keep up
  kNone,
};

struct LoadPlan {
  int scenes = 1;
  int editors = 1;         // of each scene, as all counts; they watch too
  int watchers = 0;        // that read as fast as they can
  int slow = 0;            // that read so many bytes a second
  int stalled = 0;         // that read one update and then nothing
  double slow_rate = 1e6;  // bytes a second
  LoadMode mode = LoadMode::kClosed;
  absl::Duration period;                               // open and interval
  uint64_t edits = 100;                                // of each editor
  absl::Duration duration = absl::InfiniteDuration();  // ends earlier
  // Moved by an edit: every second control point, so that all chunks change, or one after the other.
  bool all_points = true;
  Decoding decoding = Decoding::kFirst;
  v1::ViewOptions view;
};

// "open loop, 30 edits/s": how a plan's edits come.
[[nodiscard]] std::string LoadModeText(const LoadPlan& plan);

// Edit number `step`: moves control points by a tenth of the lattice's first edge, there and back,
// so that a long run does not drift.
[[nodiscard]] v1::EditBatch MakeLoadEdit(const v1::LatticeState& lattice, bool all_points,
                                         uint64_t step);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_PLAN_H_
