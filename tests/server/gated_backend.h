// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A backend that a test can hold up in the middle of making a scene or its new plan.
#ifndef LATTICED_TESTS_SERVER_GATED_BACKEND_H_
#define LATTICED_TESTS_SERVER_GATED_BACKEND_H_

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/mutex.h"
#include "core/cpu/cpu_backend.h"

namespace latticed::testing {

inline constexpr auto kLong = std::chrono::seconds(20);

// The CPU backend, whose Prepare waits at a gate where the test closes it.
class GatedBackend : public Backend {
 public:
  std::string_view name() const override { return inner_->name(); }
  std::string description() const override { return inner_->description(); }
  std::vector<DeviceState> devices() const override { return inner_->devices(); }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override {
    absl::Status answer;
    {
      const MutexLock lock(&mutex_);
      ++entered_;
    }
    {
      const MutexLock lock(&mutex_);
      mutex_.Await([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return open_; });
      answer = answer_;
    }
    if (!answer.ok()) return answer;
    return inner_->Prepare(std::move(plan), pipeline);
  }

  void Close() {
    const MutexLock lock(&mutex_);
    open_ = false;
    entered_ = 0;
  }
  // Whoever waits goes on, with an error where one is given.
  void Open(absl::Status answer = absl::OkStatus()) {
    const MutexLock lock(&mutex_);
    open_ = true;
    answer_ = std::move(answer);
  }
  // How often Prepare was called since Close.
  int entries() {
    const MutexLock lock(&mutex_);
    return entered_;
  }
  bool WaitForEntries(int count) {
    const MutexLock lock(&mutex_);
    return mutex_.AwaitFor([this, count]()
                               ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return entered_ >= count; },
                           absl::FromChrono(kLong));
  }

 private:
  const std::unique_ptr<Backend> inner_ = MakeCpuBackend({.threads = 1});
  Mutex mutex_;
  bool open_ ABSL_GUARDED_BY(mutex_) = true;
  int entered_ ABSL_GUARDED_BY(mutex_) = 0;
  absl::Status answer_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_GATED_BACKEND_H_
