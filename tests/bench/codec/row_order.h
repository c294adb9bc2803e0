// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The order of points that the serpentine one is measured against: rows of a patch that all run from
// corner 0 to corner 1.
//
// Threads  pure function
#ifndef LATTICED_TESTS_BENCH_CODEC_ROW_ORDER_H_
#define LATTICED_TESTS_BENCH_CODEC_ROW_ORDER_H_

#include <cstdint>
#include <span>
#include <vector>

#include "core/backend.h"

namespace latticed::bench {

// `integers`: whole patches in the QUANTISED layout of `spec`.
[[nodiscard]] std::vector<uint8_t> RowByRow(std::span<const uint8_t> integers,
                                            const ViewSpec& spec);

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_CODEC_ROW_ORDER_H_
