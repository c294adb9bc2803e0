// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of a scene: the backend's, by way of Residency.
//
// Errors   those of Residency::Run
// Threads  one at a time
#ifndef LATTICED_SERVER_RESIDENT_VIEW_H_
#define LATTICED_SERVER_RESIDENT_VIEW_H_

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/backend.h"
#include "server/residency.h"

namespace latticed {

class ResidentView : public DeformView {
 public:
  ResidentView(Residency* residency, std::unique_ptr<DeformView> inner)
      : residency_(residency), inner_(std::move(inner)) {}

  const ViewSpec& spec() const override { return inner_->spec(); }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override {
    return residency_->Run([&] { return inner_->Evaluate(control_points, box, chunks); });
  }
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override {
    return residency_->Run([&] { return inner_->Read(chunk, out); });
  }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding) override {
    return residency_->Run([&] { return inner_->Encode(chunks, encoding); });
  }
  MemoryUse memory() const override { return inner_->memory(); }

 private:
  Residency* const residency_;
  const std::unique_ptr<DeformView> inner_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RESIDENT_VIEW_H_
