// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which edges belong to which chunk, as proto/latticed/v1/patches.proto numbers them: in the order of first use, by
// patches in order and in a patch by its edges 0, 1, 2. DeformPlan::edges are in this order. An edge belongs to the chunk
// that uses it first.
//
// Threads  pure
#ifndef LATTICED_CORE_PATCHES_EDGE_ORDER_H_
#define LATTICED_CORE_PATCHES_EDGE_ORDER_H_

#include <cstdint>
#include <vector>

#include "core/ffd/plan/deform_plan.h"

namespace latticed {

// chunk_count() + 1 numbers: the edges of chunk c are result[c] … result[c + 1] - 1.
[[nodiscard]] std::vector<uint32_t> FirstEdges(const DeformPlan& plan);

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_EDGE_ORDER_H_
