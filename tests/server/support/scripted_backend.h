// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CPU backend under a test's control: a call fails, waits, or runs an action of the test. On request it
// acts as a device, for machines without one. Plans and vertices are then counted in the device's memory:
//
//   "device_plan"      kPlanBytes per patch, for each target
//   "device_vertices"  points times BytesPerPoint, for each view
//   "device_points"    kPointBytes per point, for each point set
#ifndef LATTICED_TESTS_SERVER_SUPPORT_SCRIPTED_BACKEND_H_
#define LATTICED_TESTS_SERVER_SUPPORT_SCRIPTED_BACKEND_H_

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "core/backend.h"
#include "core/base/mutex.h"

namespace latticed::testing {

enum class Step {
  kPrepare,
  kCreateView,
  kEvaluate,
  kRead,
  kEncode,   // before it, …
  kEncoded,  // … and after it, with other digests
  kControlNets,
  kPreparePoints,
  kPointCall,
  kDestroyView,
  kFreeChunk
};

// Every call of a step goes through Pass. Threads: safe.
class Script {
 public:
  // The next calls fail with `status`.
  void FailNext(Step step, absl::Status status, int calls = 1);
  // Runs `action` once, inside the next call.
  void DuringNext(Step step, std::function<void()> action);
  // The next calls wait until Release, at most a minute.
  void HoldNext(Step step, int calls = 1);
  void Release();
  // Waits up to 20 seconds until `count` calls are held since HoldNext. False when fewer came.
  bool WaitForHeld(int count = 1);
  int held();
  int calls(Step step);

  // From now on every call that uses the device is kUnavailable, as after a sticky CUDA error.
  void LoseDevice() { lost_ = true; }
  // How many calls used the device since then.
  int calls_after_loss() const { return calls_after_loss_; }

  // The chunks of one Encode call share a block, which claims 3.5 times their bytes.
  void UseRoomyBlocks() { roomy_blocks_ = true; }
  bool roomy_blocks() const { return roomy_blocks_; }
  // From now on digests have other values, as if another backend had computed them.
  void ChangeDigests() { ++digest_mask_; }
  uint64_t digest_mask() const { return digest_mask_; }
  // How many chunks Encode has made bytes for.
  int encoded_chunks() const { return encoded_chunks_; }

  absl::Status Pass(Step step);
  void CountEncoded(int chunks) { encoded_chunks_ += chunks; }

 private:
  struct Entry {
    int calls = 0, failures = 0, holds = 0;
    absl::Status failure;
    std::function<void()> action;
  };
  Entry& At(Step step) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return entries_[static_cast<size_t>(step)];
  }

  Mutex mutex_;
  std::array<Entry, 11> entries_ ABSL_GUARDED_BY(mutex_);
  int held_ ABSL_GUARDED_BY(mutex_) = 0;
  bool released_ ABSL_GUARDED_BY(mutex_) = true;
  std::atomic<bool> lost_ = false;
  std::atomic<int> calls_after_loss_ = 0;
  std::atomic<bool> roomy_blocks_ = false;
  std::atomic<uint64_t> digest_mask_ = 0;
  std::atomic<int> encoded_chunks_ = 0;
};

class FakeDevice;  // the memory, shared by everything allocated in it

class ScriptedBackend : public Backend {
 public:
  static constexpr uint64_t kPlanBytes = 64, kPointBytes = 28;

  ScriptedBackend();
  // On a fake device with a budget of `device_bytes`.
  explicit ScriptedBackend(uint64_t device_bytes, int number = 0);
  ~ScriptedBackend() override;
  std::string_view name() const override;
  std::string description() const override { return inner_->description(); }
  std::vector<DeviceState> devices() const override;
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override;
  // Null without a device.
  absl::StatusOr<std::shared_ptr<PointEvaluator>> PreparePoints(
      std::shared_ptr<const SortedPoints> points) override;
  Script& script() { return *script_; }
  // Bytes in use on the device. Call it only with a device.
  uint64_t used_bytes() const;
  // How many targets were made so far.
  int prepared() const { return prepared_; }

 private:
  const std::unique_ptr<Backend> inner_;
  const std::shared_ptr<Script> script_ = std::make_shared<Script>();
  const std::shared_ptr<FakeDevice> device_;  // null: the host's cores
  std::atomic<int> prepared_ = 0;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_SCRIPTED_BACKEND_H_
