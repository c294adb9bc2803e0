// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the views of every backend refuse, in the same words.
//
// Errors   kFailedPrecondition, reason NOT_EVALUATED, before the first Evaluate;
//          kInvalidArgument for a chunk that is not there, a first or re-boxed Evaluate that does
//          not name all chunks, or an encoding of another format
// Threads  one thread at a time, as the view that it belongs to
#ifndef LATTICED_CORE_VIEW_VIEW_CONTRACT_H_
#define LATTICED_CORE_VIEW_VIEW_CONTRACT_H_

#include <optional>
#include <span>

#include "core/backend.h"

namespace latticed {

class ViewContract {
 public:
  // Keeps a reference to the plan.
  ViewContract(const DeformPlan& plan, const ViewSpec& spec) : plan_(plan), spec_(spec) {}

  const ViewSpec& spec() const { return spec_; }
  // Of the last evaluation; there must have been one.
  const QuantisationBox& box() const { return *box_; }

  [[nodiscard]] absl::Status CheckEvaluate(std::span<const Vec3d> control_points,
                                           const QuantisationBox& box,
                                           std::span<const uint32_t> chunks) const;
  // `bytes`: the room that the caller gives.
  [[nodiscard]] absl::Status CheckRead(uint32_t chunk, size_t bytes) const;
  [[nodiscard]] absl::Status CheckEncode(std::span<const uint32_t> chunks, Encoding encoding) const;

  void Evaluated(const QuantisationBox& box) { box_ = box; }
  // The vertices are no longer whole: the next Evaluate must name all chunks.
  void Lost() { box_.reset(); }

 private:
  [[nodiscard]] absl::Status CheckChunk(uint32_t chunk) const;

  const DeformPlan& plan_;
  ViewSpec spec_;
  std::optional<QuantisationBox> box_;
};

// kInvalidArgument where the count is not the lattice's.
[[nodiscard]] absl::Status CheckControlPoints(const DeformPlan& plan,
                                              std::span<const Vec3d> control_points);
// The arguments of DeformTarget::ControlNets.
[[nodiscard]] absl::Status CheckControlNets(const DeformPlan& plan,
                                            std::span<const Vec3d> control_points, size_t first,
                                            size_t last);

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_VIEW_CONTRACT_H_
