// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Tells an address with wrong tokens to wait. After kFree of them, each further one makes it wait twice as long, up to
// kLongest; a wrong token that comes earlier is answered with the wait. A right token always passes, so that
// nobody can lock out others of the same address: what makes guessing hopeless is the length of tokens. Time
// is an argument.
//
// Threads  safe
#ifndef LATTICED_SERVER_BASE_AUTH_TOKEN_THROTTLE_H_
#define LATTICED_SERVER_BASE_AUTH_TOKEN_THROTTLE_H_

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include "absl/base/thread_annotations.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace latticed {

class TokenThrottle {
 public:
  static constexpr int kFree = 5;
  static constexpr absl::Duration kFirst = absl::Milliseconds(100), kLongest = absl::Minutes(1);
  static constexpr absl::Duration kForgotten = absl::Minutes(10);  // after the last wrong token
  static constexpr size_t kMostAddresses = 10'000;  // further ones count as one, "others"

  // A wrong token came from `address`, which has no port. Returns how long the address must wait; zero: the
  // token is answered.
  [[nodiscard]] absl::Duration NoteWrong(std::string_view address, absl::Time now)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Forgets old addresses. Called once a second.
  void Forget(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Entry {
    int wrong = 0;
    absl::Time last, open;  // when a token is looked at again
  };
  Mutex mutex_;
  std::map<std::string, Entry, std::less<>> entries_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUTH_TOKEN_THROTTLE_H_
