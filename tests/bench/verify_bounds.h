// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares the bytes of edge bounds with the definition in double (core/adaptive/adaptive_reference.h), and with those
// of the CPU backend.
#ifndef LATTICED_TESTS_BENCH_VERIFY_BOUNDS_H_
#define LATTICED_TESTS_BENCH_VERIFY_BOUNDS_H_

#include "absl/status/status.h"
#include "core/backend.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

// Evaluates `view`, which has VertexFormat::kEdgeBounds, with control_points[0], and encodes all chunks. kInternal names
// the first edge whose bound is below the definition on either backend, or whose bytes are more than one step apart.
//
// Edges that bend by less than 1e-5 of the mesh's diagonal may be further apart. Most of their bound stands for rounding
// (core/adaptive/curvature_slack.h). Backends add different amounts, because they frame a patch differently.
[[nodiscard]] absl::Status VerifyBounds(const Scenario& scenario, DeformView& view);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_VERIFY_BOUNDS_H_
