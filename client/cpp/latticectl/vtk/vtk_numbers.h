// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Numbers of VTK files, as text or as bytes.
//
// Errors   kInvalidArgument in one sentence, without the file's name
// Threads  pure functions
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_VTK_VTK_NUMBERS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_VTK_VTK_NUMBERS_H_

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/vec.h"

namespace latticed::client {

// `count` numbers between spaces and line ends from `at` on, which then is behind the last one. kAllNumbers: all to the end.
inline constexpr uint64_t kAllNumbers = UINT64_MAX;
[[nodiscard]] absl::StatusOr<std::vector<double>> TextNumbers(std::string_view bytes,
                                                              uint64_t count, size_t& at);
// `count` numbers of a type of legacy files, as "float", from `at` on, which then is behind them.
[[nodiscard]] absl::StatusOr<std::vector<double>> BinaryNumbers(std::string_view bytes,
                                                                uint64_t count,
                                                                const std::string& type,
                                                                std::endian order, size_t& at);
// x y z of each point.
[[nodiscard]] std::vector<Vec3d> PointsFromNumbers(std::span<const double> numbers);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_VTK_VTK_NUMBERS_H_
