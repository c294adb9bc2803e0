// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The manual page of a program, in the man macros of groff, from its table of commands.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_MAN_PAGE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_MAN_PAGE_H_

#include <string>
#include <string_view>

#include "client/cpp/latticectl/reference/command_table.h"

namespace latticed::client {

[[nodiscard]] std::string ManPage(const CommandEntry& program, std::string_view version);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_REFERENCE_MAN_PAGE_H_
