// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CPU backend behind gates: a test can hold up or fail what its views do, and what frees their
// memory, count it, and say that it is a device of its own.
#ifndef LATTICED_TESTS_SERVER_ENGINE_STAGED_BACKEND_H_
#define LATTICED_TESTS_SERVER_ENGINE_STAGED_BACKEND_H_

#include <array>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/backend.h"
#include "core/base/mutex.h"

namespace latticed::testing {

// kEvaluatePart is within kEvaluate: a part of it, before others are let ahead.
enum class Stage {
  kPrepare,
  kCreateView,
  kEvaluatePart,
  kEvaluate,
  kEncode,
  kDestroyView,
  kFreeChunk
};
inline constexpr size_t kStages = 7;

// A call that has ended, by the chunks of its plan, and where it ran.
struct StagedCall {
  Stage stage = Stage::kPrepare;
  size_t chunks = 0;
  std::thread::id thread;
};

// Where every call of a stage passes. Threads: safe.
class StageGates {
 public:
  void Close(Stage stage);
  void Open(Stage stage);
  void OpenAll();
  // The next call alone waits until the gate is opened; others pass it.
  void HoldNext(Stage stage);
  // The next calls that pass fail with `status` instead.
  void FailNext(Stage stage, absl::Status status, int calls = 1);
  // Every encoding takes so much longer.
  void SlowEncodings(absl::Duration delay);
  // From now on what is encoded in one call lies in one block, said to be 7/2 times as large.
  void UseRoomyBlocks();
  // From now on a view has so much staged on the host once something of it was encoded.
  void SetStaging(uint64_t bytes);
  // From here on digests are those of another writer, as a device's are not the host's.
  void ChangeDigests();
  // Since the backend was made. A call begins before the gate and ends behind it.
  int begun(Stage stage);
  int ended(Stage stage);
  // By the chunks of their plans, those that have ended, in order.
  std::vector<size_t> order(Stage stage);
  // The same of all stages together.
  std::vector<StagedCall> history();
  // False when it takes longer than twenty seconds.
  bool WaitForBegun(Stage stage, int count);
  bool WaitForEnded(Stage stage, int count);

  // Chunks that were encoded, of those that encodings were asked for.
  int encoded_chunks();
  bool roomy_blocks();
  uint64_t staging_bytes();

  // For the backend.
  VertexDigest digest_mask();
  void CountEncoded(const std::vector<SharedBytes>& results);
  absl::Status Begin(Stage stage);
  void End(Stage stage, size_t chunks);

 private:
  struct Gate {
    bool open = true;
    bool hold_next = false, holds_one = false;
    absl::Status failure;
    int failures = 0;  // to come
    int begun = 0;
    int ended = 0;
    void Open() {
      open = true;
      hold_next = holds_one = false;
    }
  };
  Mutex mutex_;
  std::array<Gate, kStages> gates_ ABSL_GUARDED_BY(mutex_);
  std::vector<StagedCall> history_ ABSL_GUARDED_BY(mutex_);
  absl::Duration delay_ ABSL_GUARDED_BY(mutex_);
  VertexDigest digest_mask_ ABSL_GUARDED_BY(mutex_);
  int encoded_chunks_ ABSL_GUARDED_BY(mutex_) = 0;
  bool roomy_blocks_ ABSL_GUARDED_BY(mutex_) = false;
  uint64_t staging_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

class StagedBackend : public Backend {
 public:
  explicit StagedBackend(bool on_device);
  std::string_view name() const override { return inner_->name(); }
  std::string description() const override { return inner_->description(); }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override;
  StageGates& gates() { return *gates_; }

 private:
  const bool on_device_;
  const std::unique_ptr<Backend> inner_;
  const std::shared_ptr<StageGates> gates_ = std::make_shared<StageGates>();
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_ENGINE_STAGED_BACKEND_H_
