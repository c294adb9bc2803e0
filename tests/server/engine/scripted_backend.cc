// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/engine/scripted_backend.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/status_macros.h"
#include "core/cpu/cpu_backend.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {
namespace {

void Mask(std::span<VertexDigest> digests, uint64_t mask) {
  for (VertexDigest& digest : digests) digest.low ^= mask;
}

void PutIntoBlock(std::vector<SharedBytes>& chunks) {
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

class ScriptedView : public DeformView {
 public:
  ScriptedView(std::unique_ptr<DeformView> inner, std::shared_ptr<Script> script, bool on_device)
      : inner_(std::move(inner)), script_(std::move(script)), on_device_(on_device) {}
  ~ScriptedView() override { EXPECT_OK(script_->Pass(Step::kDestroyView)); }

  const ViewSpec& spec() const override { return inner_->spec(); }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kEvaluate));
    return inner_->Evaluate(control_points, box, chunks);
  }
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override {
    return inner_->Read(chunk, out);
  }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding,
                                                  std::span<VertexDigest> digests) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kEncode));
    Mask(digests, script_->digest_mask());
    LATTICED_ASSIGN_OR_RETURN(auto encoded, inner_->Encode(chunks, encoding, digests));
    Mask(digests, script_->digest_mask());
    script_->CountEncoded(static_cast<int>(
        std::ranges::count_if(encoded, [](const SharedBytes& c) { return c.data != nullptr; })));
    if (script_->roomy_blocks()) PutIntoBlock(encoded);
    PutBehindScript(encoded);
    return encoded;
  }
  MemoryUse memory() const override {
    MemoryUse use = inner_->memory();
    if (on_device_) use["device_vertices"] = std::exchange(use["vertices"], 0);
    return use;
  }

 private:
  // What frees a chunk passes the script; chunks of one block stay so.
  void PutBehindScript(std::vector<SharedBytes>& chunks) {
    for (SharedBytes& chunk : chunks) {
      if (chunk.data == nullptr) continue;
      const void* owner = chunk.owner.get();
      chunk.owner =
          std::shared_ptr<const void>(owner, [kept = chunk.owner, script = script_](const void*) {
            EXPECT_OK(script->Pass(Step::kFreeChunk));
          });
    }
  }

  const std::unique_ptr<DeformView> inner_;
  const std::shared_ptr<Script> script_;
  const bool on_device_;
};

class ScriptedTarget : public DeformTarget {
 public:
  ScriptedTarget(std::shared_ptr<DeformTarget> inner, std::shared_ptr<Script> script,
                 bool on_device)
      : inner_(std::move(inner)), script_(std::move(script)), on_device_(on_device) {}

  const DeformPlan& plan() const override { return inner_->plan(); }
  Pipeline pipeline() const override { return inner_->pipeline(); }
  ViewTraits Traits(const ViewSpec& spec) const override {
    ViewTraits traits = inner_->Traits(spec);
    traits.on_device = on_device_;
    return traits;
  }
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kCreateView));
    LATTICED_ASSIGN_OR_RETURN(auto view, inner_->CreateView(spec));
    return std::make_unique<ScriptedView>(std::move(view), script_, on_device_);
  }
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override {
    return inner_->ControlNets(control_points, first, last);
  }
  MemoryUse memory() const override { return inner_->memory(); }

 private:
  const std::shared_ptr<DeformTarget> inner_;
  const std::shared_ptr<Script> script_;
  const bool on_device_;
};

}  // namespace

void Script::FailNext(Step step, absl::Status status, int calls) {
  const MutexLock lock(&mutex_);
  At(step).failure = std::move(status);
  At(step).failures = calls;
}

void Script::DuringNext(Step step, std::function<void()> action) {
  const MutexLock lock(&mutex_);
  At(step).action = std::move(action);
}

int Script::calls(Step step) {
  const MutexLock lock(&mutex_);
  return At(step).calls;
}

absl::Status Script::Pass(Step step) {
  std::function<void()> action;
  {
    const MutexLock lock(&mutex_);
    ++At(step).calls;
    action = std::exchange(At(step).action, nullptr);
  }
  if (action != nullptr) action();
  const MutexLock lock(&mutex_);
  Entry& entry = At(step);
  if (entry.failures == 0) return absl::OkStatus();
  --entry.failures;
  return entry.failure;
}

ScriptedBackend::ScriptedBackend(bool on_device)
    : on_device_(on_device), inner_(MakeCpuBackend({.threads = 1})) {}

absl::StatusOr<std::shared_ptr<DeformTarget>> ScriptedBackend::Prepare(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline) {
  LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kPrepare));
  LATTICED_ASSIGN_OR_RETURN(auto target, inner_->Prepare(std::move(plan), pipeline));
  return std::make_shared<ScriptedTarget>(std::move(target), script_, on_device_);
}

}  // namespace latticed::testing
