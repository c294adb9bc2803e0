// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What an option takes: names of files and folders, which the help calls by these types (CLI::Option::type_name) and
// shells complete; and how many values.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_VALUE_TYPES_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_VALUE_TYPES_H_

#include <CLI/CLI.hpp>

namespace latticed::client {

inline constexpr char kFileType[] = "FILE";
inline constexpr char kFolderType[] = "FOLDER";

// CLI11 gives an option without a limit a maximum of 2^29 values.
inline bool TakesAnyNumber(const CLI::Option& option) {
  constexpr int kNobodyTypes = 1'000'000;
  return option.get_items_expected_max() > kNobodyTypes;
}

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_VALUE_TYPES_H_
