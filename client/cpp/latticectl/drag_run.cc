// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/drag_run.h"

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/base/status_macros.h"

namespace latticed::client {

double DragResult::bytes_per_update() const {
  const size_t updates = latencies.count();
  return updates == 0 ? 0.0 : static_cast<double>(bytes) / static_cast<double>(updates);
}

absl::StatusOr<DragResult> RunDrag(DeformStream& stream, int steps,
                                   const std::function<v1::EditBatch(int)>& make_edit,
                                   const Progress& progress) {
  DragResult result;
  for (int step = 0; step < steps; ++step) {
    const absl::Time begin = absl::Now();
    LATTICED_ASSIGN_OR_RETURN(const auto sequence, stream.Send(make_edit(step)));
    LATTICED_ASSIGN_OR_RETURN(const auto update, stream.WaitFor(sequence));
    result.latencies.Add(absl::Now() - begin);
    result.bytes += update.bytes;
    result.chunks += update.chunk_count;
    progress(static_cast<uint64_t>(step) + 1, static_cast<uint64_t>(steps));
  }
  return result;
}

}  // namespace latticed::client
