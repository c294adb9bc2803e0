// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the tensor-product comparator (tensor_product.h) keeps of a plan and of a number of segments:
// made on the host in double, once.
#ifndef LATTICED_TESTS_BENCH_TENSOR_TABLES_H_
#define LATTICED_TESTS_BENCH_TENSOR_TABLES_H_

#include <vector>

#include "core/ffd/deform_plan.h"
#include "tests/bench/tensor_product.h"

namespace latticed::bench {

[[nodiscard]] TensorTables MakeTensorTables(int segments);

// World coordinates are relative to the plan's local origin.
[[nodiscard]] std::vector<TensorPatch> MakeTensorPatches(const DeformPlan& plan);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_TENSOR_TABLES_H_
