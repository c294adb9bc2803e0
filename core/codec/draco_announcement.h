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
  bool is_edgebreaker = false;
  bool is_kd_tree = false;  // whose attributes announce sizes of their own
  uint64_t points = 0;      // encoded vertices for edgebreaker
  uint64_t faces = 0;
  uint64_t corner_tables =
      0;  // edgebreaker: for attributes that differ between the corners of a vertex
  uint64_t metadata_bytes = 0;  // in the stream
};

// Reads streams of version 1.3 (libdraco's oldest) and later, by any method. Metadata is skipped, and refused if it
// announces more than its bytes can hold: libdraco would allocate for that.
[[nodiscard]] absl::StatusOr<DracoAnnouncement> ReadDracoAnnouncement(
    std::span<const uint8_t> bytes);

// Refuses what the bytes cannot hold, or what is over limits.h.
[[nodiscard]] absl::Status CheckDracoSize(const DracoAnnouncement& announcement, size_t byte_count);

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_DRACO_ANNOUNCEMENT_H_
