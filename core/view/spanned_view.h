// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view whose chunks are shared out among other views, each of a slice of the plan
// (core/ffd/plan_slice.h) and each, as a rule, on a device of its own.
//
//   chunks of the plan   0 … first(1) - 1 | first(1) … first(2) - 1 | …
//   part                 0                | 1                       | …
//
// Evaluate hands every part its own and waits for none: parts that enqueue run at once. A part with
// nothing to do is not asked. Encode has a thread a part.
//
// Errors   those of core/view/view_contract.h and of the parts. After one of Evaluate all chunks
//          must be named, also those of the parts that did not fail
// Threads  one thread at a time
#ifndef LATTICED_CORE_VIEW_SPANNED_VIEW_H_
#define LATTICED_CORE_VIEW_SPANNED_VIEW_H_

#include <memory>
#include <vector>

#include "core/backend.h"
#include "core/view/view_contract.h"

namespace latticed {

class SpannedView : public DeformView {
 public:
  struct Part {
    uint32_t first_chunk;  // of the plan; the first part's is 0, and they rise
    std::unique_ptr<DeformView> view;
  };
  SpannedView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec,
              std::vector<Part> parts);

  const ViewSpec& spec() const override { return contract_.spec(); }
  absl::Status Evaluate(std::span<const Vec3d> control_points, const QuantisationBox& box,
                        std::span<const uint32_t> chunks) override;
  absl::Status Read(uint32_t chunk, std::span<uint8_t> out) override;
  absl::StatusOr<std::vector<SharedBytes>> Encode(std::span<const uint32_t> chunks,
                                                  Encoding encoding,
                                                  std::span<VertexDigest> digests) override;
  MemoryUse memory() const override;

  // For measurements.
  const std::vector<Part>& parts() const { return parts_; }

 private:
  // Chunks of one part that stand beside each other among all that are to be encoded.
  struct Run {
    size_t place, count;
  };
  // What a part has to encode, and what came of it.
  struct Share {
    std::vector<Run> runs;
    std::vector<uint32_t> chunks;  // of the part, run by run
    std::vector<VertexDigest> digests;
    absl::StatusOr<std::vector<SharedBytes>> results;
  };
  std::vector<Share> ShareOut(std::span<const uint32_t> chunks,
                              std::span<const VertexDigest> digests) const;
  void EncodeAtOnce(std::vector<Share>& shares, Encoding encoding) const;
  static void Gather(Share& share, std::span<SharedBytes> results, std::span<VertexDigest> digests);

  absl::Status EvaluateParts(std::span<const Vec3d> control_points, const QuantisationBox& box,
                             std::span<const uint32_t> chunks);
  size_t PartOf(uint32_t chunk) const;
  uint32_t End(size_t part) const;  // its last chunk of the plan, plus one

  const std::shared_ptr<const DeformPlan> plan_;
  ViewContract contract_;
  const std::vector<Part> parts_;
  std::span<const uint32_t> all_;  // 0, 1, … for the largest part: whole parts are named by it
  std::vector<uint32_t> named_;    // of the part that is being told
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_VIEW_H_
