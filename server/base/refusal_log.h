// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Sums up refusals for the log: a caller who is refused a thousand times a second must not fill it. Of each
// kind (address, rpc, code) the first kFirst of a period are told one by one; the rest are counted, and told
// in one line when the period ends. Time is an argument.
//
// Threads  safe
#ifndef LATTICED_SERVER_BASE_REFUSAL_LOG_H_
#define LATTICED_SERVER_BASE_REFUSAL_LOG_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace latticed {

class RefusalLog {
 public:
  static constexpr uint64_t kFirst = 5;
  static constexpr absl::Duration kPeriod = absl::Seconds(10);
  static constexpr size_t kMostKinds = 1'000;  // further addresses count as one, "others"

  struct Sum {
    std::string address;
    std::string rpc;
    int code;
    uint64_t count;
    bool operator==(const Sum&) const = default;
  };

  // Whether the log tells this refusal by itself. `address` is without a port.
  [[nodiscard]] bool Note(std::string_view address, std::string_view rpc, int code, absl::Time now)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // The kinds whose period has ended with refusals that were only counted. Forgets all whose period has ended.
  [[nodiscard]] std::vector<Sum> TakeEnded(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  using Kind = std::tuple<std::string, std::string, int>;
  struct Period {
    absl::Time end;
    uint64_t refusals = 0;
  };

  Mutex mutex_;
  std::map<Kind, Period> periods_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_REFUSAL_LOG_H_
