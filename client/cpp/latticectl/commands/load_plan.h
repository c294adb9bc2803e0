// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A load: the editors and watchers of each scene, and when the next edit is due.
//
//   closed    when the update with the last edit is complete, and decoded if the plan says so
//   open      every period, whatever the server does
//   interval  every period, but an editor has only one unanswered batch at a time; meanwhile the
//             newest edit replaces those that wait, as in a browser's drag
//
// The latency of an edit with a period counts from the time it was due, not from when it was sent.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_LOAD_PLAN_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_LOAD_PLAN_H_

#include <cstdint>

#include "absl/time/time.h"
#include "client/cpp/latticectl/command_line/tolerance_flag.h"
#include "latticed/v1/view.pb.h"

namespace latticed::client {

enum class LoadMode { kClosed, kOpen, kInterval };

// Which updates are decoded, in the thread that reads them.
enum class Decoding {
  kFirst,  // those of each scene's first editor
  kAll,    // those of all editors, and of the watchers that keep up
  kNone,
};

struct LoadPlan {
  int scenes = 1;
  int editors = 1;         // per scene, like the next three; editors also watch
  int watchers = 0;        // read as fast as they can
  int slow = 0;            // read slow_rate
  int stalled = 0;         // read one update and then nothing
  double slow_rate = 1e6;  // bytes per second
  LoadMode mode = LoadMode::kClosed;
  absl::Duration period;                               // of modes open and interval
  uint64_t edits = 100;                                // of each editor
  absl::Duration duration = absl::InfiniteDuration();  // no edit is due later than this
  // True: an edit moves every second control point, so all chunks change. False: it moves one point, and
  // the edits take the points in turn.
  bool all_points = true;
  Decoding decoding = Decoding::kFirst;
  v1::ViewOptions view;
  Tolerance tolerance;  // of the view, in each scene's units
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_LOAD_PLAN_H_
