// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/engine/staged_backend.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "core/cpu/cpu_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

constexpr absl::Duration kLong = absl::Seconds(20);

void Mask(std::span<VertexDigest> digests, const VertexDigest& mask) {
  for (VertexDigest& digest : digests) {
    digest.low ^= mask.low;
    digest.high ^= mask.high;
  }
}

class StagedView : public DeformView {
 public:
  StagedView(std::unique_ptr<DeformView> inner, std::shared_ptr<StageGates> gates, size_t chunks,
             bool on_device)
      : inner_(std::move(inner)),
        gates_(std::move(gates)),
        chunks_(chunks),
        on_device_(on_device) {}

  ~StagedView() override {
    EXPECT_OK(gates_->Begin(Stage::kDestroyView));
    gates_->End(Stage::kDestroyView, chunks_);
  }

  const ViewSpec& spec() const override { return inner_->spec(); }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override {
    return EvaluateInParts(control_points, box, chunks, [](uint64_t) {});
  }
  absl::Status EvaluateInParts(std::span<const Vec3d> control_points, const QuantisationBox& box,
                               std::span<const uint32_t> chunks, Between between) override {
    absl::Status status = gates_->Begin(Stage::kEvaluate);
    absl::Status of_parts;
    if (status.ok()) {
      status = inner_->EvaluateInParts(control_points, box, chunks, [&](uint64_t points) {
        of_parts.Update(gates_->Begin(Stage::kEvaluatePart));
        gates_->End(Stage::kEvaluatePart, chunks_);
        between(points);
      });
    }
    status.Update(of_parts);
    gates_->End(Stage::kEvaluate, chunks_);
    return status;
  }
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override {
    return inner_->Read(chunk, out);
  }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding,
                                                  std::span<VertexDigest> digests) override {
    const absl::Status status = gates_->Begin(Stage::kEncode);
    const VertexDigest mask = gates_->digest_mask();
    Mask(digests, mask);
    auto encoded = status.ok() ? inner_->Encode(chunks, encoding, digests)
                               : absl::StatusOr<std::vector<SharedBytes>>(status);
    staging_bytes_ = gates_->staging_bytes();
    Mask(digests, mask);
    if (encoded.ok()) gates_->CountEncoded(*encoded);
    if (encoded.ok() && gates_->roomy_blocks()) PutIntoBlock(*encoded);
    if (encoded.ok()) PutBehindGate(*encoded);
    gates_->End(Stage::kEncode, chunks_);
    return encoded;
  }
  MemoryUse memory() const override {
    MemoryUse use = inner_->memory();
    if (on_device_) use["device_vertices"] = std::exchange(use["vertices"], 0);
    use["staging"] += staging_bytes_;
    return use;
  }

 private:
  static void PutIntoBlock(std::vector<SharedBytes>& chunks) {
    const auto block = std::make_shared<std::vector<uint8_t>>();
    for (const SharedBytes& chunk : chunks) {
      block->insert(block->end(), chunk.data, chunk.data + chunk.size);
    }
    size_t at = 0;
    for (SharedBytes& chunk : chunks) {
      if (chunk.data == nullptr) continue;
      chunk = {block, block->data() + at, chunk.size, block->size() * 7 / 2};
      at += chunk.size;
    }
  }
  // What frees a chunk passes it; chunks of one block stay so.
  void PutBehindGate(std::vector<SharedBytes>& chunks) {
    for (SharedBytes& chunk : chunks) {
      if (chunk.data == nullptr) continue;
      const void* owner = chunk.owner.get();
      chunk.owner = std::shared_ptr<const void>(
          owner, [kept = chunk.owner, gates = gates_, count = chunks_](const void*) {
            EXPECT_OK(gates->Begin(Stage::kFreeChunk));
            gates->End(Stage::kFreeChunk, count);
          });
    }
  }

  const std::unique_ptr<DeformView> inner_;
  const std::shared_ptr<StageGates> gates_;
  const size_t chunks_;  // of the plan
  const bool on_device_;
  uint64_t staging_bytes_ = 0;
};

class StagedTarget : public DeformTarget {
 public:
  StagedTarget(std::shared_ptr<DeformTarget> inner, std::shared_ptr<StageGates> gates,
               bool on_device)
      : inner_(std::move(inner)), gates_(std::move(gates)), on_device_(on_device) {}

  const DeformPlan& plan() const override { return inner_->plan(); }
  Pipeline pipeline() const override { return inner_->pipeline(); }
  bool evaluates_on_device() const override { return on_device_; }
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override {
    const absl::Status status = gates_->Begin(Stage::kCreateView);
    gates_->End(Stage::kCreateView, plan().chunk_count());
    if (!status.ok()) return status;
    auto view = inner_->CreateView(spec);
    if (!view.ok()) return view.status();
    return std::make_unique<StagedView>(*std::move(view), gates_, plan().chunk_count(), on_device_);
  }
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override {
    return inner_->ControlNets(control_points, first, last);
  }
  uint64_t EncoderBytes(const ViewSpec& spec) const override { return inner_->EncoderBytes(spec); }
  MemoryUse memory() const override { return inner_->memory(); }

 private:
  const std::shared_ptr<DeformTarget> inner_;
  const std::shared_ptr<StageGates> gates_;
  const bool on_device_;
};

}  // namespace

void StageGates::Close(Stage stage) {
  const MutexLock lock(&mutex_);
  gates_[static_cast<size_t>(stage)].open = false;
}

void StageGates::Open(Stage stage) {
  const MutexLock lock(&mutex_);
  gates_[static_cast<size_t>(stage)].Open();
}

void StageGates::OpenAll() {
  const MutexLock lock(&mutex_);
  for (Gate& gate : gates_) gate.Open();
}

void StageGates::HoldNext(Stage stage) {
  const MutexLock lock(&mutex_);
  gates_[static_cast<size_t>(stage)].hold_next = true;
}

void StageGates::FailNext(Stage stage, absl::Status status, int calls) {
  const MutexLock lock(&mutex_);
  Gate& gate = gates_[static_cast<size_t>(stage)];
  gate.failure = std::move(status);
  gate.failures = calls;
}

void StageGates::SlowEncodings(absl::Duration delay) {
  const MutexLock lock(&mutex_);
  delay_ = delay;
}

void StageGates::UseRoomyBlocks() {
  const MutexLock lock(&mutex_);
  roomy_blocks_ = true;
}

void StageGates::SetStaging(uint64_t bytes) {
  const MutexLock lock(&mutex_);
  staging_bytes_ = bytes;
}

uint64_t StageGates::staging_bytes() {
  const MutexLock lock(&mutex_);
  return staging_bytes_;
}

bool StageGates::roomy_blocks() {
  const MutexLock lock(&mutex_);
  return roomy_blocks_;
}

void StageGates::ChangeDigests() {
  const MutexLock lock(&mutex_);
  ++digest_mask_.low;
}

VertexDigest StageGates::digest_mask() {
  const MutexLock lock(&mutex_);
  return digest_mask_;
}

int StageGates::begun(Stage stage) {
  const MutexLock lock(&mutex_);
  return gates_[static_cast<size_t>(stage)].begun;
}

int StageGates::ended(Stage stage) {
  const MutexLock lock(&mutex_);
  return gates_[static_cast<size_t>(stage)].ended;
}

std::vector<size_t> StageGates::order(Stage stage) {
  std::vector<size_t> order;
  for (const StagedCall& call : history()) {
    if (call.stage == stage) order.push_back(call.chunks);
  }
  return order;
}

std::vector<StagedCall> StageGates::history() {
  const MutexLock lock(&mutex_);
  return history_;
}

int StageGates::encoded_chunks() {
  const MutexLock lock(&mutex_);
  return encoded_chunks_;
}

void StageGates::CountEncoded(const std::vector<SharedBytes>& results) {
  const MutexLock lock(&mutex_);
  encoded_chunks_ += static_cast<int>(
      std::ranges::count_if(results, [](const SharedBytes& r) { return r.data != nullptr; }));
}

bool StageGates::WaitForBegun(Stage stage, int count) {
  const MutexLock lock(&mutex_);
  const Gate& gate = gates_[static_cast<size_t>(stage)];
  return mutex_.AwaitFor([&gate, count] { return gate.begun >= count; }, kLong);
}

bool StageGates::WaitForEnded(Stage stage, int count) {
  const MutexLock lock(&mutex_);
  const Gate& gate = gates_[static_cast<size_t>(stage)];
  return mutex_.AwaitFor([&gate, count] { return gate.ended >= count; }, kLong);
}

absl::Status StageGates::Begin(Stage stage) {
  absl::Duration delay;
  absl::Status status;
  bool held = false;
  {
    const MutexLock lock(&mutex_);
    Gate& gate = gates_[static_cast<size_t>(stage)];
    ++gate.begun;
    held = std::exchange(gate.hold_next, false);
    gate.holds_one = gate.holds_one || held;
    if (stage == Stage::kEncode) delay = delay_;
  }
  {
    const MutexLock lock(&mutex_);
    Gate& gate = gates_[static_cast<size_t>(stage)];
    mutex_.Await([&gate, held] { return gate.open && !(held && gate.holds_one); });
    if (gate.failures > 0) {
      --gate.failures;
      status = gate.failure;
    }
  }
  absl::SleepFor(delay);
  return status;
}

void StageGates::End(Stage stage, size_t chunks) {
  const MutexLock lock(&mutex_);
  ++gates_[static_cast<size_t>(stage)].ended;
  history_.push_back({stage, chunks, std::this_thread::get_id()});
}

StagedBackend::StagedBackend(bool on_device)
    : on_device_(on_device), inner_(MakeCpuBackend({.threads = 1})) {}

absl::StatusOr<std::shared_ptr<DeformTarget>> StagedBackend::Prepare(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline) {
  const absl::Status status = gates_->Begin(Stage::kPrepare);
  gates_->End(Stage::kPrepare, plan->chunk_count());
  if (!status.ok()) return status;
  auto target = inner_->Prepare(std::move(plan), pipeline);
  if (!target.ok()) return target.status();
  return std::make_shared<StagedTarget>(*std::move(target), gates_, on_device_);
}

}  // namespace latticed::testing
