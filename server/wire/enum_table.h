// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An enum of latticed.v1 beside the values that it stands for, read in both directions.
//
//   constexpr auto kModes = std::to_array<std::pair<v1::Mode, Mode>>(
//       {{v1::MODE_FAST, Mode::kFast}, {v1::MODE_UNSPECIFIED, Mode::kFast}});
//
// A value in two rows is written as in the first of them, so the default comes last.
//
// Errors   kInvalidArgument UNSUPPORTED for a value without a row
// Threads  pure functions
#ifndef LATTICED_SERVER_WIRE_ENUM_TABLE_H_
#define LATTICED_SERVER_WIRE_ENUM_TABLE_H_

#include <array>
#include <string_view>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {

template <typename Proto, typename Core, size_t kRows>
using EnumTable = std::array<std::pair<Proto, Core>, kRows>;

template <typename Proto, typename Core, size_t kRows>
[[nodiscard]] absl::StatusOr<Core> ReadEnum(const EnumTable<Proto, Core, kRows>& table, Proto value,
                                            std::string_view field) {
  for (const auto& [proto, core] : table) {
    if (proto == value) return core;
  }
  return error::Unsupported(field, fmt::format("value {}", static_cast<int>(value)));
}

// UNSPECIFIED for a value without a row.
template <typename Proto, typename Core, size_t kRows>
[[nodiscard]] Proto WriteEnum(const EnumTable<Proto, Core, kRows>& table, const Core& value) {
  for (const auto& [proto, core] : table) {
    if (core == value) return proto;
  }
  return Proto{};
}

}  // namespace latticed

#endif  // LATTICED_SERVER_WIRE_ENUM_TABLE_H_
