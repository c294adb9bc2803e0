// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Times and durations as messages, to the nanosecond; those of timings, to the microsecond.
//
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_TIME_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_TIME_CONVERTERS_H_

#include <algorithm>
#include <cstdint>
#include <limits>

#include "absl/time/time.h"
#include "google/protobuf/duration.pb.h"
#include "google/protobuf/timestamp.pb.h"

namespace latticed {

inline void SetDuration(absl::Duration duration, google::protobuf::Duration& out) {
  const int64_t seconds = absl::ToInt64Seconds(duration);
  out.set_seconds(seconds);
  out.set_nanos(static_cast<int32_t>(absl::ToInt64Nanoseconds(duration - absl::Seconds(seconds))));
}

inline void SetTime(absl::Time time, google::protobuf::Timestamp& out) {
  const int64_t seconds = absl::ToUnixSeconds(time);
  out.set_seconds(seconds);
  out.set_nanos(
      static_cast<int32_t>(absl::ToInt64Nanoseconds(time - absl::FromUnixSeconds(seconds))));
}

// As timings have it: 0 for what is negative.
inline uint32_t Microseconds(absl::Duration duration) {
  return static_cast<uint32_t>(std::clamp<int64_t>(absl::ToInt64Microseconds(duration), 0,
                                                   std::numeric_limits<uint32_t>::max()));
}

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_TIME_CONVERTERS_H_
