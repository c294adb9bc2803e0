// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares a view with the definition in double (tests/support/definition.h).
#ifndef LATTICED_TESTS_BENCH_VERIFY_H_
#define LATTICED_TESTS_BENCH_VERIFY_H_

#include "absl/status/status.h"
#include "core/backend.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {

// `view` was evaluated with control_points[0]. About 64 of its chunks are compared. kInternal names
// the first wrong point and its error.
[[nodiscard]] absl::Status Verify(const Scenario& scenario, Pipeline pipeline, DeformView& view);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_VERIFY_H_
