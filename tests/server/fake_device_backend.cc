// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/fake_device_backend.h"

#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/cpu/cpu_backend.h"
#include "core/ffd/tessellation_pattern.h"
#include "fmt/format.h"

namespace latticed::testing {

class FakeDevice {
 public:
  FakeDevice(uint64_t bytes, int number) : bytes_(bytes), number_(number) {}

  int number() const { return number_; }

  absl::Status Take(const std::string& purpose, uint64_t bytes) {
    const std::scoped_lock lock(mutex_);
    const uint64_t free = bytes_ - HostBytes(use_);
    if (bytes > free) return error::OutOfDeviceMemory(purpose, number_, bytes, free);
    use_[purpose] += bytes;
    return absl::OkStatus();
  }
  void Give(const std::string& purpose, uint64_t bytes) {
    const std::scoped_lock lock(mutex_);
    use_[purpose] -= bytes;
  }
  DeviceState State() const {
    const std::scoped_lock lock(mutex_);
    return {.number = number_,
            .name = fmt::format("fake {}", number_),
            .memory_bytes = 2 * bytes_,
            .budget_bytes = bytes_,
            .free_bytes = bytes_ - HostBytes(use_),
            .use = use_};
  }
  // kUnavailable once it is lost.
  absl::Status Check() {
    const std::scoped_lock lock(mutex_);
    if (!lost_) return absl::OkStatus();
    ++calls_after_loss_;
    return error::Unavailable("DEVICE_LOST", "an illegal memory access was encountered", 1'000);
  }
  void Lose() {
    const std::scoped_lock lock(mutex_);
    lost_ = true;
  }
  void CountPrepare() {
    const std::scoped_lock lock(mutex_);
    ++prepares_;
  }
  int prepares() const {
    const std::scoped_lock lock(mutex_);
    return prepares_;
  }
  int calls_after_loss() const {
    const std::scoped_lock lock(mutex_);
    return calls_after_loss_;
  }

 private:
  const uint64_t bytes_;
  const int number_;
  mutable std::mutex mutex_;
  MemoryUse use_;  // these guarded by mutex_
  bool lost_ = false;
  int calls_after_loss_ = 0;
  int prepares_ = 0;
};

namespace {

// Bytes of the device, until it goes.
class FakeMemory {
 public:
  FakeMemory(std::shared_ptr<FakeDevice> device, std::string purpose, uint64_t bytes)
      : device_(std::move(device)), purpose_(std::move(purpose)), bytes_(bytes) {}
  ~FakeMemory() { device_->Give(purpose_, bytes_); }
  FakeMemory(const FakeMemory&) = delete;  // gives back once
  FakeMemory& operator=(const FakeMemory&) = delete;

  uint64_t bytes() const { return bytes_; }
  FakeDevice& device() const { return *device_; }

 private:
  const std::shared_ptr<FakeDevice> device_;
  const std::string purpose_;
  const uint64_t bytes_;
};

absl::StatusOr<std::unique_ptr<FakeMemory>> Take(const std::shared_ptr<FakeDevice>& device,
                                                 const std::string& purpose, uint64_t bytes) {
  if (auto s = device->Check(); !s.ok()) return s;
  if (auto s = device->Take(purpose, bytes); !s.ok()) return s;
  return std::make_unique<FakeMemory>(device, purpose, bytes);
}

class FakeView : public DeformView {
 public:
  FakeView(std::unique_ptr<DeformView> inner, std::unique_ptr<FakeMemory> memory)
      : inner_(std::move(inner)), memory_(std::move(memory)) {}

  const ViewSpec& spec() const override { return inner_->spec(); }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override {
    if (auto s = memory_->device().Check(); !s.ok()) return s;
    return inner_->Evaluate(control_points, box, chunks);
  }
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override {
    if (auto s = memory_->device().Check(); !s.ok()) return s;
    return inner_->Read(chunk, out);
  }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding,
                                                  std::span<VertexDigest> digests) override {
    if (auto s = memory_->device().Check(); !s.ok()) return s;
    return inner_->Encode(chunks, encoding, digests);
  }
  MemoryUse memory() const override { return {{"device_vertices", memory_->bytes()}}; }

 private:
  const std::unique_ptr<DeformView> inner_;
  const std::unique_ptr<FakeMemory> memory_;
};

class FakeTarget : public DeformTarget {
 public:
  FakeTarget(std::shared_ptr<FakeDevice> device, std::shared_ptr<DeformTarget> inner,
             std::unique_ptr<FakeMemory> memory)
      : device_(std::move(device)), inner_(std::move(inner)), memory_(std::move(memory)) {}

  const DeformPlan& plan() const override { return inner_->plan(); }
  Pipeline pipeline() const override { return inner_->pipeline(); }
  ViewTraits Traits(const ViewSpec& spec) const override {
    ViewTraits traits = inner_->Traits(spec);
    traits.on_device = true;
    traits.host_bytes = traits.encoder_bytes = 0;
    return traits;
  }
  absl::StatusOr<std::unique_ptr<DeformView>> CreateView(const ViewSpec& spec) override {
    const uint64_t points =
        plan().patches.size() * static_cast<uint64_t>(PointsPerPatch(spec.segments));
    auto memory = Take(device_, "vertices", points * BytesPerPoint(spec));
    if (!memory.ok()) return memory.status();
    auto view = inner_->CreateView(spec);
    if (!view.ok()) return view.status();
    return std::make_unique<FakeView>(*std::move(view), *std::move(memory));
  }
  absl::StatusOr<std::vector<double>> ControlNets(std::span<const Vec3d> control_points,
                                                  size_t first, size_t last) override {
    if (auto s = device_->Check(); !s.ok()) return s;
    return inner_->ControlNets(control_points, first, last);
  }
  MemoryUse memory() const override {
    return {{"plan", plan().MemoryBytes()}, {"device_plan", memory_->bytes()}};
  }
  DeviceUse device_use() const override { return {{device_->number(), memory_->bytes()}}; }

 private:
  const std::shared_ptr<FakeDevice> device_;
  const std::shared_ptr<DeformTarget> inner_;
  const std::unique_ptr<FakeMemory> memory_;
};

}  // namespace

FakeDeviceBackend::FakeDeviceBackend(uint64_t memory_bytes, int number)
    : inner_(MakeCpuBackend({.threads = 1})),
      device_(std::make_shared<FakeDevice>(memory_bytes, number)) {}

FakeDeviceBackend::~FakeDeviceBackend() = default;

absl::StatusOr<std::shared_ptr<DeformTarget>> FakeDeviceBackend::Prepare(
    std::shared_ptr<const DeformPlan> plan, Pipeline pipeline) {
  auto memory = Take(device_, "plan", plan->patches.size() * kPlanBytes);
  if (!memory.ok()) return memory.status();
  auto inner = inner_->Prepare(std::move(plan), pipeline);
  if (!inner.ok()) return inner.status();
  device_->CountPrepare();
  return std::make_shared<FakeTarget>(device_, *std::move(inner), *std::move(memory));
}

std::vector<DeviceState> FakeDeviceBackend::devices() const { return {device_->State()}; }
void FakeDeviceBackend::Lose() { device_->Lose(); }
int FakeDeviceBackend::calls_after_loss() const { return device_->calls_after_loss(); }
uint64_t FakeDeviceBackend::used_bytes() const { return HostBytes(device_->State().use); }
int FakeDeviceBackend::prepares() const { return device_->prepares(); }

}  // namespace latticed::testing
