// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A scripted drag through a Deform stream, in a closed loop: each edit is sent when the surface
// with the one before it is here, complete.
//
// Units  milliseconds from sending an edit to the end of the update that holds it, as a client sees
// it
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_DRAG_RUN_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_DRAG_RUN_H_

#include <functional>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/latency_recorder.h"
#include "client/cpp/library/latticed_client.h"

namespace latticed::client {

struct DragResult {
  LatencyRecorder latencies;
  uint64_t bytes = 0;  // of chunk data in all updates
  uint64_t chunks = 0;

  double bytes_per_update() const;
};

// make_edit(step) for step = 0 … steps - 1.
[[nodiscard]] absl::StatusOr<DragResult> RunDrag(DeformStream& stream, int steps,
                                                 const std::function<v1::EditBatch(int)>& make_edit,
                                                 const Progress& progress);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_DRAG_RUN_H_
