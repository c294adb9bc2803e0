// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Which option of a command fills in a field of a request. A server names fields; users know options.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_FIELD_FLAGS_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_FIELD_FLAGS_H_

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace CLI {
class App;
}

namespace latticed::client {

struct FieldFlag {
  std::string_view field;  // without indices: "lattices.fit.degree"
  std::string_view flag;   // "--degree"; of an argument its name
};

// All pairs. A field has two entries where two options may fill it in.
[[nodiscard]] std::span<const FieldFlag> FieldFlags();

// "lattices[0].fit.degree.u" is "--degree, u". Of two options the first that the command has and that was given counts.
// nullopt for a field that no option of `command` fills in.
[[nodiscard]] std::optional<std::string> InWordsOf(const CLI::App& command, std::string_view field);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMAND_LINE_FIELD_FLAGS_H_
