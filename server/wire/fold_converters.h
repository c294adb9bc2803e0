// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Reports of folds <-> core/folds.
//
// Errors   kInvalidArgument naming the field
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_FOLD_CONVERTERS_H_
#define LATTICED_SERVER_WIRE_FOLD_CONVERTERS_H_

#include <cstddef>
#include <cstdint>

#include "absl/status/statusor.h"
#include "core/folds/fold_report.h"
#include "latticed/v1/fold.pb.h"

namespace latticed {

// The most places of a report: 60 KB.
inline constexpr size_t kMostPlaces = 1'024;
// Of one in an EditResult: 15 KB. A stream may queue limits::kMaxQueuedAnswers of them.
inline constexpr size_t kMostEditPlaces = 256;

[[nodiscard]] absl::StatusOr<FoldScope> FoldScopeFromProto(v1::FoldScope scope);
// With the first `most` places: folded ones first.
[[nodiscard]] v1::FoldReport ToProto(const FoldReport& report, uint64_t revision,
                                     uint64_t structure_id, size_t most);

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_FOLD_CONVERTERS_H_
