// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The history of a scene in a copy, which anybody may have written. What EditHistory::FromImage leaves to its own
// writer is checked here: numbers that must not be near their end, ids that a later edit would give again, and times that
// clocks can be counted from.
//
// Errors   kDataLoss naming what cannot be
// Threads  pure functions
#ifndef LATTICED_SERVER_ENGINE_SCENE_COPIED_HISTORY_H_
#define LATTICED_SERVER_ENGINE_SCENE_COPIED_HISTORY_H_

#include "absl/status/status.h"
#include "server/store/store.h"

namespace latticed {

// Whether a scene may begin with the log, which has no records. Takes some 24 times the bytes of the log for a moment.
[[nodiscard]] absl::Status CheckCopied(const SceneLog& log);

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_SCENE_COPIED_HISTORY_H_
