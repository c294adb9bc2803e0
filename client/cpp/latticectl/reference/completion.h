// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Scripts with which shells complete a program's commands, options, their words, and names of files.
//
//   bash   source <(latticectl completion bash)
//   zsh    source <(latticectl completion zsh)      after compinit
//   fish   latticectl completion fish | source
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_COMPLETION_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_COMPLETION_H_

#include <string>

#include "client/cpp/latticectl/reference/command_table.h"

namespace latticed::client {

[[nodiscard]] std::string BashCompletion(const CommandEntry& program);
[[nodiscard]] std::string ZshCompletion(const CommandEntry& program);
[[nodiscard]] std::string FishCompletion(const CommandEntry& program);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_COMPLETION_H_
