// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Options that take one of a few names, each with a value.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_NAMED_VALUES_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_NAMED_VALUES_H_

#include <CLI/CLI.hpp>
#include <array>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace latticed::client {

template <typename Value, size_t N>
using NamedValues = std::array<std::pair<const char*, Value>, N>;

template <typename Value, size_t N>
std::string NameOf(const NamedValues<Value, N>& names, Value wanted, const char* otherwise) {
  for (const auto& [name, value] : names) {
    if (value == wanted) return name;
  }
  return otherwise;
}

// Calls `set` with the value of the name that is given. `names` lives as long as the command.
template <typename Value, size_t N>
CLI::Option* AddNamedOption(CLI::App& command, const std::string& option,
                            const NamedValues<Value, N>& names, std::function<void(Value)> set,
                            const std::string& text) {
  std::vector<std::string> words;
  for (const auto& [name, value] : names) words.emplace_back(name);
  const auto take = [&names, set = std::move(set)](const std::string& word) {
    for (const auto& [name, value] : names) {
      if (name == word) set(value);
    }
  };
  return command.add_option_function<std::string>(option, take, text)->check(CLI::IsMember(words));
}

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_NAMED_VALUES_H_
