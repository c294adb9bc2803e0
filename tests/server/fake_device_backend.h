// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A device for machines without one: the CPU backend, whose plans and vertices are said to lie in
// a device's memory of so many bytes, and which can be lost.
//
//   "device_plan"      kPlanBytes a patch, of each target
//   "device_vertices"  points times BytesPerPoint, of each view
//
// Threads  safe, as backends are
#ifndef LATTICED_TESTS_SERVER_FAKE_DEVICE_BACKEND_H_
#define LATTICED_TESTS_SERVER_FAKE_DEVICE_BACKEND_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/backend.h"

namespace latticed::testing {

class FakeDevice;  // its memory, shared by all that is in it

class FakeDeviceBackend : public Backend {
 public:
  static constexpr uint64_t kPlanBytes = 64;

  explicit FakeDeviceBackend(uint64_t memory_bytes, int number = 0);
  ~FakeDeviceBackend() override;

  std::string_view name() const override { return "fake"; }
  std::string description() const override { return "a device that is not there"; }
  std::vector<DeviceState> devices() const override;
  absl::StatusOr<std::shared_ptr<DeformTarget>> Prepare(std::shared_ptr<const DeformPlan> plan,
                                                        Pipeline pipeline) override;

  // From now on everything is kUnavailable, as after a sticky CUDA error.
  void Lose();
  // What was asked of the device since then.
  int calls_after_loss() const;
  uint64_t used_bytes() const;
  // Targets made so far.
  int prepares() const;

 private:
  const std::unique_ptr<Backend> inner_;
  const std::shared_ptr<FakeDevice> device_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_FAKE_DEVICE_BACKEND_H_
