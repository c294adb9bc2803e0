// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Finds out that housekeeping or quick calls do not move any more. Long work is not watched. The watchdog counts its
// checks, one a second, and not the time: a process that was stopped for a while, and goes on, is not stuck.
//
// Threads  one
#ifndef LATTICED_SERVER_BASE_WATCHDOG_H_
#define LATTICED_SERVER_BASE_WATCHDOG_H_

#include <cstdint>

namespace latticed {

// What shows that a server moves.
struct Pulse {
  uint64_t engine_ticks =
      0;  // housekeeping, which takes the locks of the registry and of every scene
  uint64_t quick_calls = 0;       // quick calls that workers have run
  bool quick_calls_wait = false;  // for a worker
};

class Watchdog {
 public:
  static constexpr int kPatience = 30;

  // Returns whether the engine has not ticked, or no waiting call was run, in kPatience checks.
  [[nodiscard]] bool IsStuck(const Pulse& pulse) {
    engine_still_ = pulse.engine_ticks == last_.engine_ticks ? engine_still_ + 1 : 0;
    const bool calls_wait = pulse.quick_calls_wait && pulse.quick_calls == last_.quick_calls;
    calls_still_ = calls_wait ? calls_still_ + 1 : 0;
    last_ = pulse;
    return engine_still_ >= kPatience || calls_still_ >= kPatience;
  }

 private:
  Pulse last_;
  int engine_still_ = 0, calls_still_ = 0;  // checks
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_WATCHDOG_H_
