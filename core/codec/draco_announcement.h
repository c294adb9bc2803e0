// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The sizes that a Draco stream announces. They are checked before libdraco allocates memory for
// them: a stream of 30 bytes can announce two thousand million points.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE
// Threads  pure functions
#ifndef LATTICED_CORE_CODEC_DRACO_ANNOUNCEMENT_H_
#define LATTICED_CORE_CODEC_DRACO_ANNOUNCEMENT_H_

#include <cstdint>
#include <span>

#include "absl/status/statusor.h"

namespace latticed {

struct DracoAnnouncement {
  bool is_mesh = false;
  bool is_kd_tree = false;  // whose attributes announce sizes of their own
  uint64_t points = 0;      // encoded vertices for edgebreaker
  uint64_t faces = 0;
};

// Reads streams of version 1.3 (libdraco's oldest) and later, by any method. Metadata is skipped.
[[nodiscard]] absl::StatusOr<DracoAnnouncement> ReadDracoAnnouncement(
    std::span<const uint8_t> bytes);

// Refuses what the bytes cannot hold, or what is over limits.h.
[[nodiscard]] absl::Status CheckDracoSize(const DracoAnnouncement& announcement, size_t byte_count);

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_ANNOUNCEMENT_H_
