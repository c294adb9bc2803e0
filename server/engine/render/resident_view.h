// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view of a scene: the backend's, by way of Residency.
//
// Chunks that Evaluate does not name must have the vertices that these control points give them,
// as those of scenes do: where it has to be tried again, all are evaluated.
//
// Errors   those of Residency::Run
// Threads  one at a time
#ifndef LATTICED_SERVER_ENGINE_RENDER_RESIDENT_VIEW_H_
#define LATTICED_SERVER_ENGINE_RENDER_RESIDENT_VIEW_H_

#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/backend.h"
#include "server/engine/render/resident_target.h"

namespace latticed {

class ResidentView : public DeformView {
 public:
  // `inner` is a view of `inner_target`, which is not given back while this lives.
  ResidentView(std::shared_ptr<ResidentTarget> target, std::shared_ptr<DeformTarget> inner_target,
               std::unique_ptr<DeformView> inner)
      : target_(std::move(target)),
        inner_target_(std::move(inner_target)),
        inner_(std::move(inner)) {}

  const ViewSpec& spec() const override { return inner_->spec(); }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override {
    return EvaluateInParts(control_points, box, chunks, [](uint64_t) {});
  }
  absl::Status EvaluateInParts(std::span<const Vec3d> control_points, const QuantisationBox& box,
                               std::span<const uint32_t> chunks, Between between) override;
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override {
    return target_->residency().Run([&] { return inner_->Read(chunk, out); });
  }
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding,
                                                  std::span<VertexDigest> digests) override {
    return target_->residency().Run([&] { return inner_->Encode(chunks, encoding, digests); });
  }
  size_t encode_batch() const override { return inner_->encode_batch(); }
  std::vector<uint32_t> EncodeOrder(std::span<const uint32_t> chunks) const override {
    return inner_->EncodeOrder(chunks);
  }
  MemoryUse memory() const override { return inner_->memory(); }

 private:
  const std::shared_ptr<ResidentTarget> target_;
  const std::shared_ptr<DeformTarget> inner_target_;
  const std::unique_ptr<DeformView> inner_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_ENGINE_RENDER_RESIDENT_VIEW_H_
