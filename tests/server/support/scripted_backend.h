// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CPU backend as a test wants it: calls that fail, that wait, or inside of which something happens; and
// on request a device for machines without one, whose plans and vertices are said to lie in its memory:
//
//   "device_plan"      kPlanBytes a patch, of each target
//   "device_vertices"  points times BytesPerPoint, of each view
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
  kEncode,
  kControlNets,
  kDestroyView,
  kFreeChunk
};

// Every call of a step passes here. Threads: safe.
class Script {
 public:
  // The next calls fail with `status`.
  void FailNext(Step step, absl::Status status, int calls = 1);
  // Runs once, inside of the next call.
  void DuringNext(Step step, std::function<void()> action);
  // The next calls wait until Release, a minute at most.
  void HoldNext(Step step, int calls = 1);
  void Release();
  // Whether so many calls have come to wait since HoldNext.
  bool WaitForHeld(int count = 1);
  int held();
  int calls(Step step);

  // From here on whatever asks the device is kUnavailable, as after a sticky CUDA error.
  void LoseDevice() { lost_ = true; }
  // What was asked of the device since then.
  int calls_after_loss() const { return calls_after_loss_; }

  // What is encoded in one call lies in one block, said to be 7/2 times as large.
  void UseRoomyBlocks() { roomy_blocks_ = true; }
  bool roomy_blocks() const { return roomy_blocks_; }
  // From here on digests are those of another writer, as a device's are not the host's.
  void ChangeDigests() { ++digest_mask_; }
  uint64_t digest_mask() const { return digest_mask_; }
  // Chunks of which Encode made bytes.
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
  std::array<Entry, 8> entries_ ABSL_GUARDED_BY(mutex_);
  int held_ ABSL_GUARDED_BY(mutex_) = 0;
  bool released_ ABSL_GUARDED_BY(mutex_) = true;
  std::atomic<bool> lost_ = false;
  std::atomic<int> calls_after_loss_ = 0;
  std::atomic<bool> roomy_blocks_ = false;
  std::atomic<uint64_t> digest_mask_ = 0;
  std::atomic<int> encoded_chunks_ = 0;
};

class FakeDevice;  // its memory, shared by all that is in it

class ScriptedBackend : public Backend {
 public:
  static constexpr uint64_t kPlanBytes = 64;

  ScriptedBackend();
  // On a device with so many bytes.
  explicit ScriptedBackend(uint64_t device_bytes, int number = 0);
  ~ScriptedBackend() override;
  std::string_view name() const override;
  std::string description() const override { return inner_->description(); }
  std::vector<DeviceState> devices() const override;
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override;
  Script& script() { return *script_; }
  // Of the device.
  uint64_t used_bytes() const;
  // Targets made so far.
  int prepared() const { return prepared_; }

 private:
  const std::unique_ptr<Backend> inner_;
  const std::shared_ptr<Script> script_ = std::make_shared<Script>();
  const std::shared_ptr<FakeDevice> device_;  // null: the host's own cores
  std::atomic<int> prepared_ = 0;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_SCRIPTED_BACKEND_H_
