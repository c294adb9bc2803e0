// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/support/scripted_backend.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/cpu/cpu_backend.h"
#include "core/ffd/tessellation_pattern.h"
#include "core/points/host_points.h"
#include "fmt/format.h"
#include "tests/support/status_matchers.h"

namespace latticed::testing {

class FakeDevice {
 public:
  FakeDevice(uint64_t bytes, int number) : bytes_(bytes), number_(number) {}

  int number() const { return number_; }
  absl::Status Take(const std::string& purpose, uint64_t bytes) {
    const MutexLock lock(&mutex_);
    const uint64_t free = bytes_ - HostBytes(use_);
    if (bytes > free) return error::OutOfDeviceMemory(purpose, number_, bytes, free);
    use_[purpose] += bytes;
    return absl::OkStatus();
  }
  void Give(const std::string& purpose, uint64_t bytes) {
    const MutexLock lock(&mutex_);
    use_[purpose] -= bytes;
  }
  DeviceState State() {
    const MutexLock lock(&mutex_);
    return {.number = number_,
            .name = fmt::format("fake {}", number_),
            .memory_bytes = 2 * bytes_,
            .budget_bytes = bytes_,
            .free_bytes = bytes_ - HostBytes(use_),
            .use = use_};
  }

 private:
  const uint64_t bytes_;
  const int number_;
  Mutex mutex_;
  MemoryUse use_ ABSL_GUARDED_BY(mutex_);
};

namespace {

// Holds bytes of the device until it is destroyed.
class FakeMemory {
 public:
  FakeMemory(std::shared_ptr<FakeDevice> device, std::string purpose, uint64_t bytes)
      : device_(std::move(device)), purpose_(std::move(purpose)), bytes_(bytes) {}
  ~FakeMemory() { device_->Give(purpose_, bytes_); }
  FakeMemory(const FakeMemory&) = delete;  // frees its bytes once
  FakeMemory& operator=(const FakeMemory&) = delete;

  uint64_t bytes() const { return bytes_; }

 private:
  const std::shared_ptr<FakeDevice> device_;
  const std::string purpose_;
  const uint64_t bytes_;
};

// Null without a device.
absl::StatusOr<std::unique_ptr<FakeMemory>> Take(const std::shared_ptr<FakeDevice>& device,
                                                 const std::string& purpose, uint64_t bytes) {
  if (device == nullptr) return nullptr;
  LATTICED_RETURN_IF_ERROR(device->Take(purpose, bytes));
  return std::make_unique<FakeMemory>(device, purpose, bytes);
}

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
  ScriptedView(std::unique_ptr<DeformView> inner, std::shared_ptr<Script> script,
               std::unique_ptr<FakeMemory> memory)
      : inner_(std::move(inner)), script_(std::move(script)), memory_(std::move(memory)) {}
  ~ScriptedView() override { EXPECT_OK(script_->Pass(Step::kDestroyView)); }

  const ViewSpec& spec() const override { return inner_->spec(); }
  std::span<const uint32_t> also_changed() const override { return inner_->also_changed(); }
  PatternCodes Patterns() const override { return inner_->Patterns(); }
  double certified_error() const override { return inner_->certified_error(); }
  double curvature_tolerance() const override { return inner_->curvature_tolerance(); }
  ToleranceSlice* tolerance_slice() override { return inner_->tolerance_slice(); }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kEvaluate));
    return inner_->Evaluate(control_points, box, chunks);
  }
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kRead));
    return inner_->Read(chunk, out);
  }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding,
                                                  std::span<VertexDigest> digests,
                                                  TakeEarly /*early*/) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kEncode));
    Mask(digests, script_->digest_mask());
    LATTICED_ASSIGN_OR_RETURN(auto encoded, inner_->Encode(chunks, encoding, digests));
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kEncoded));
    Mask(digests, script_->digest_mask());
    script_->CountEncoded(static_cast<int>(
        std::ranges::count_if(encoded, [](const SharedBytes& c) { return c.data != nullptr; })));
    if (script_->roomy_blocks()) PutIntoBlock(encoded);
    PutBehindScript(encoded);
    return encoded;
  }
  MemoryUse memory() const override {
    if (memory_ == nullptr) return inner_->memory();
    return {{"device_vertices", memory_->bytes()}};
  }

 private:
  // Freeing a chunk then goes through the script. Chunks of one block still have the same owner.
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
  const std::unique_ptr<FakeMemory> memory_;
};

class ScriptedTarget : public DeformTarget {
 public:
  ScriptedTarget(std::shared_ptr<DeformTarget> inner, std::shared_ptr<Script> script,
                 std::shared_ptr<FakeDevice> device, std::unique_ptr<FakeMemory> memory)
      : inner_(std::move(inner)),
        script_(std::move(script)),
        device_(std::move(device)),
        memory_(std::move(memory)) {}

  const DeformPlan& plan() const override { return inner_->plan(); }
  Pipeline pipeline() const override { return inner_->pipeline(); }
  ViewTraits Traits(const ViewSpec& spec) const override {
    ViewTraits traits = inner_->Traits(spec);
    if (device_ == nullptr) return traits;
    traits.on_device = true;
    traits.host_bytes = traits.encoder_bytes = 0;
    return traits;
  }
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kCreateView));
    const uint64_t points =
        plan().patches.size() * static_cast<uint64_t>(PointsPerPatch(spec.segments));
    LATTICED_ASSIGN_OR_RETURN(auto memory, Take(device_, "vertices", points * BytesPerPoint(spec)));
    LATTICED_ASSIGN_OR_RETURN(auto view, inner_->CreateView(spec));
    return std::make_unique<ScriptedView>(std::move(view), script_, std::move(memory));
  }
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kControlNets));
    return inner_->ControlNets(control_points, first, last);
  }
  MemoryUse memory() const override {
    if (memory_ == nullptr) return inner_->memory();
    return {{"plan", plan().MemoryBytes()}, {"device_plan", memory_->bytes()}};
  }
  DeviceUse device_use() const override {
    if (memory_ == nullptr) return {};
    return {{device_->number(), memory_->bytes()}};
  }

 private:
  const std::shared_ptr<DeformTarget> inner_;
  const std::shared_ptr<Script> script_;
  const std::shared_ptr<FakeDevice> device_;
  const std::unique_ptr<FakeMemory> memory_;
};

class ScriptedPoints : public PointEvaluator {
 public:
  ScriptedPoints(std::shared_ptr<const SortedPoints> points, std::shared_ptr<Script> script,
                 std::unique_ptr<FakeMemory> memory)
      : inner_(std::move(points), &arena_),
        script_(std::move(script)),
        memory_(std::move(memory)) {}

  const SortedPoints& points() const override { return inner_.points(); }
  absl::Status Deform(std::span<const Vec3d> control_points, PointNormals normals, StopCheck stop,
                      std::span<Vec3d> out) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kPointCall));
    return inner_.Deform(control_points, normals, stop, out);
  }
  absl::Status ApplyJacobian(std::span<const Vec3d> control_points, std::span<const Vec3d> tangents,
                             PointNormals normals, StopCheck stop, std::span<Vec3d> out) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kPointCall));
    return inner_.ApplyJacobian(control_points, tangents, normals, stop, out);
  }
  absl::Status ApplyJacobianTranspose(std::span<const Vec3d> control_points,
                                      std::span<const Vec3d> cotangents, PointNormals normals,
                                      StopCheck stop, std::span<Vec3d> gradients) override {
    LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kPointCall));
    return inner_.ApplyJacobianTranspose(control_points, cotangents, normals, stop, gradients);
  }
  uint64_t TransposeBytes(size_t directions, PointNormals normals) const override {
    return inner_.TransposeBytes(directions, normals);
  }
  uint64_t device_bytes() const override { return memory_->bytes(); }

 private:
  CpuArena arena_{1};
  HostPoints inner_;
  const std::shared_ptr<Script> script_;
  const std::unique_ptr<FakeMemory> memory_;
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

void Script::HoldNext(Step step, int calls) {
  const MutexLock lock(&mutex_);
  At(step).holds = calls;
  held_ = 0;
  released_ = false;
}

void Script::Release() {
  const MutexLock lock(&mutex_);
  for (Entry& entry : entries_) entry.holds = 0;
  released_ = true;
}

bool Script::WaitForHeld(int count) {
  const MutexLock lock(&mutex_);
  return mutex_.AwaitFor([this, count]()
                             ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return held_ >= count; },
                         absl::Seconds(20));
}

int Script::held() {
  const MutexLock lock(&mutex_);
  return held_;
}

int Script::calls(Step step) {
  const MutexLock lock(&mutex_);
  return At(step).calls;
}

absl::Status Script::Pass(Step step) {
  std::function<void()> action;
  bool hold = false;
  {
    const MutexLock lock(&mutex_);
    Entry& entry = At(step);
    ++entry.calls;
    action = std::exchange(entry.action, nullptr);
    hold = entry.holds > 0;
    entry.holds -= hold ? 1 : 0;
    held_ += hold ? 1 : 0;
  }
  if (action != nullptr) action();
  if (lost_ && step != Step::kDestroyView && step != Step::kFreeChunk) {
    ++calls_after_loss_;
    return error::Unavailable("DEVICE_LOST", "an illegal memory access was encountered", 1'000);
  }
  const MutexLock lock(&mutex_);
  if (hold) {
    mutex_.AwaitFor([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return released_; },
                    absl::Minutes(1));
  }
  Entry& entry = At(step);
  if (entry.failures == 0) return absl::OkStatus();
  --entry.failures;
  return entry.failure;
}

ScriptedBackend::ScriptedBackend() : inner_(MakeCpuBackend({.threads = 1})) {}
ScriptedBackend::ScriptedBackend(uint64_t device_bytes, int number)
    : inner_(MakeCpuBackend({.threads = 1})),
      device_(std::make_shared<FakeDevice>(device_bytes, number)) {}
ScriptedBackend::~ScriptedBackend() = default;

std::string_view ScriptedBackend::name() const {
  return device_ == nullptr ? inner_->name() : "fake";
}

std::vector<DeviceState> ScriptedBackend::devices() const {
  if (device_ == nullptr) return inner_->devices();
  return {device_->State()};
}

uint64_t ScriptedBackend::used_bytes() const { return HostBytes(device_->State().use); }

absl::StatusOr<std::shared_ptr<DeformTarget>> ScriptedBackend::Prepare(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline) {
  LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kPrepare));
  LATTICED_ASSIGN_OR_RETURN(auto memory, Take(device_, "plan", plan->patches.size() * kPlanBytes));
  LATTICED_ASSIGN_OR_RETURN(auto target, inner_->Prepare(std::move(plan), pipeline));
  ++prepared_;
  return std::make_shared<ScriptedTarget>(std::move(target), script_, device_, std::move(memory));
}

absl::StatusOr<std::shared_ptr<PointEvaluator>> ScriptedBackend::PreparePoints(
    std::shared_ptr<const SortedPoints> points) {
  if (device_ == nullptr) return nullptr;
  LATTICED_RETURN_IF_ERROR(script_->Pass(Step::kPreparePoints));
  LATTICED_ASSIGN_OR_RETURN(auto memory, Take(device_, "points", points->size() * kPointBytes));
  return std::make_shared<ScriptedPoints>(std::move(points), script_, std::move(memory));
}

}  // namespace latticed::testing
