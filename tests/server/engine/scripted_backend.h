// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The CPU backend as a test wants it: calls that fail, or inside of which something happens, memory that
// is said to be a device's, and counts.
#ifndef LATTICED_TESTS_SERVER_ENGINE_SCRIPTED_BACKEND_H_
#define LATTICED_TESTS_SERVER_ENGINE_SCRIPTED_BACKEND_H_

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "core/backend.h"
#include "core/base/mutex.h"

namespace latticed::testing {

enum class Step { kPrepare, kCreateView, kEvaluate, kEncode, kDestroyView, kFreeChunk };

// Every call of a step passes here. Threads: safe.
class Script {
 public:
  // The next calls fail with `status`.
  void FailNext(Step step, absl::Status status, int calls = 1);
  // Runs once, inside of the next call.
  void DuringNext(Step step, std::function<void()> action);
  int calls(Step step);

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
    int calls = 0, failures = 0;
    absl::Status failure;
    std::function<void()> action;
  };
  Entry& At(Step step) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return entries_[static_cast<size_t>(step)];
  }

  Mutex mutex_;
  std::array<Entry, 6> entries_ ABSL_GUARDED_BY(mutex_);
  std::atomic<bool> roomy_blocks_ = false;
  std::atomic<uint64_t> digest_mask_ = 0;
  std::atomic<int> encoded_chunks_ = 0;
};

class ScriptedBackend : public Backend {
 public:
  explicit ScriptedBackend(bool on_device = false);
  std::string_view name() const override { return inner_->name(); }
  std::string description() const override { return inner_->description(); }
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override;
  Script& script() { return *script_; }

 private:
  const bool on_device_;
  const std::unique_ptr<Backend> inner_;
  const std::shared_ptr<Script> script_ = std::make_shared<Script>();
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_ENGINE_SCRIPTED_BACKEND_H_
