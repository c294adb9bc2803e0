// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The fused kernel with vertices in the order of its vector lanes. These are its fastest stores, so
// stores in wire order are measured against them. Does not encode.
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
