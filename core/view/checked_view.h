// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The base of every backend's views. It checks their arguments, with the same messages everywhere, and turns
// std::bad_alloc into a status.
//
// Errors   kFailedPrecondition, reason NOT_EVALUATED, before the first Evaluate; kInvalidArgument for a chunk that does
//          not exist, for an encoding of another format, and for an Evaluate that does not name all chunks though it is
//          the first or has another box; kResourceExhausted for memory
// Threads  one thread at a time
#ifndef LATTICED_CORE_VIEW_CHECKED_VIEW_H_
#define LATTICED_CORE_VIEW_CHECKED_VIEW_H_

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/backend.h"

namespace latticed {

class CheckedView : public DeformView {
 public:
  const ViewSpec& spec() const final { return spec_; }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) final;
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) final;
  using DeformView::Encode;
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding,
                                                  std::span<VertexDigest> digests,
                                                  TakeEarly early) final;

 protected:
  CheckedView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec)
      : plan_(std::move(plan)), spec_(spec) {}

  const DeformPlan& plan() const { return *plan_; }
  // The box of the last evaluation; there must have been one.
  const QuantisationBox& box() const { return *box_; }
  // For a view that is evaluated in steps and not by Evaluate: the box of an evaluation that is whole.
  void SetBox(const QuantisationBox& box) { box_ = box; }

 private:
  // As DeformView's; the arguments are valid. After an error of EvaluateChunks the next Evaluate must
  // name all chunks. `results` has one entry per chunk, and at least one.
  virtual absl::Status EvaluateChunks(std::span<const Vec3d> control_points,
                                      const QuantisationBox& box,
                                      std::span<const uint32_t> chunks) = 0;
  virtual absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) = 0;
  // The bytes that Read copies.
  virtual size_t SizeOf(uint32_t chunk) const {
    return ChunkPoints(*this, *plan_, chunk) * BytesPerPoint(spec_);
  }
  virtual absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                                    std::span<VertexDigest> digests, std::span<SharedBytes> results,
                                    TakeEarly early) = 0;

  absl::Status CheckEvaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                             std::span<const uint32_t> chunks) const;
  absl::Status CheckChunk(uint32_t chunk) const;

  const std::shared_ptr<const DeformPlan> plan_;
  const ViewSpec spec_;
  std::optional<QuantisationBox> box_;
};

// kInvalidArgument where the arguments of DeformTarget::ControlNets do not fit the plan.
[[nodiscard]] absl::Status CheckControlNets(const DeformPlan& plan,
                                            std::span<const Vec3d> control_points, size_t first,
                                            size_t last);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_CHECKED_VIEW_H_
