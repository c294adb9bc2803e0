// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A view whose chunks are shared out among other views, each of a slice of the plan
// (core/ffd/plan/plan_slice.h) and each, as a rule, on a device of its own.
//
//   chunks of the plan   0 … first(1) - 1 | first(1) … first(2) - 1 | …
//   part                 0                | 1                       | …
//
// Evaluate gives each part its chunks and waits for none, so parts that enqueue run concurrently. A
// part without chunks is not called. With a tolerance, all parts are evaluated in steps, and Evaluate waits for what they
// exchange (tolerance_exchange.h). Encode uses one thread per part.
//
// Errors   those of core/view/checked_view.h and of the parts. After an error of Evaluate, the next one must name all
//          chunks, also those of the parts that did not fail
// Threads  one thread at a time
#ifndef LATTICED_CORE_VIEW_SPANNED_SPANNED_VIEW_H_
#define LATTICED_CORE_VIEW_SPANNED_SPANNED_VIEW_H_

#include <memory>
#include <vector>

#include "core/view/checked_view.h"
#include "core/view/spanned/tolerance_exchange.h"

namespace latticed {

class SpannedView : public CheckedView {
 public:
  struct Part {
    uint32_t first_chunk;  // of the plan; the first part's is 0, and they rise
    std::unique_ptr<DeformView> view;
  };
  // `exchange`: of the parts' views where spec has a tolerance, else null.
  SpannedView(std::shared_ptr<const DeformPlan> plan, const ViewSpec& spec, std::vector<Part> parts,
              std::unique_ptr<ToleranceExchange> exchange = nullptr);

  std::span<const uint32_t> also_changed() const override { return also_changed_; }
  PatternCodes Patterns() const override { return patterns_; }
  double certified_error() const override;
  // All parts have the same.
  double curvature_tolerance() const override { return parts_[0].view->curvature_tolerance(); }
  MemoryUse memory() const override;

  // For measurements.
  const std::vector<Part>& parts() const { return parts_; }

 private:
  // The chunks that one part has to encode, and the results.
  struct Share {
    std::vector<size_t> places;    // in the list of all chunks that are to be encoded
    std::vector<uint32_t> chunks;  // of the part
    std::vector<VertexDigest> digests;
    absl::StatusOr<std::vector<SharedBytes>> results;
  };

  absl::Status EvaluateChunks(std::span<const Vec3d> control_points, const QuantisationBox& box,
                              std::span<const uint32_t> chunks) override;
  absl::Status ReadChunk(uint32_t chunk, std::span<uint8_t> out) override;
  absl::Status EncodeChunks(std::span<const uint32_t> chunks, Encoding encoding,
                            std::span<VertexDigest> digests, std::span<SharedBytes> results,
                            TakeEarly early) override;
  absl::Status EvaluateWithTolerance(std::span<const Vec3d> control_points,
                                     const QuantisationBox& box, std::span<const uint32_t> chunks);
  // Those of `chunks` that a part has, in its own numbers; valid until the next call for this part.
  std::span<const uint32_t> ChunksOf(size_t part, std::span<const uint32_t> chunks);
  std::vector<Share> ShareOut(std::span<const uint32_t> chunks,
                              std::span<const VertexDigest> digests) const;
  size_t PartOf(uint32_t chunk) const;
  uint32_t End(size_t part) const;  // its last chunk of the plan, plus one

  const std::vector<Part> parts_;
  std::span<const uint32_t>
      all_;  // 0, 1, …, as long as the largest part; it names all chunks of a part
  std::vector<std::vector<uint32_t>> named_;  // by part: its chunks where not all are named
  const std::unique_ptr<ToleranceExchange> exchange_;
  std::vector<uint32_t> also_changed_;
  PatternCodes patterns_;
};

}  // namespace latticed

#endif  // LATTICED_CORE_VIEW_SPANNED_SPANNED_VIEW_H_
