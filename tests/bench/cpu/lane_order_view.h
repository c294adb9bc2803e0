// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused kernel with its vertices as its lanes have them: the fastest stores there are, to measure
// those in wire order by. Encodes nothing.
#ifndef LATTICED_TESTS_BENCH_CPU_LANE_ORDER_VIEW_H_
#define LATTICED_TESTS_BENCH_CPU_LANE_ORDER_VIEW_H_

#include <memory>

#include "core/backend.h"

namespace latticed::bench {

// kFloat32 only.
[[nodiscard]] std::unique_ptr<DeformView> MakeLaneOrderView(std::shared_ptr<const DeformPlan> plan,
                                                            const ViewSpec& spec, int threads);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_CPU_LANE_ORDER_VIEW_H_
