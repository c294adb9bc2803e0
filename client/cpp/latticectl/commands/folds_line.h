// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A report of folds in one line.
//
// Threads  pure
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_FOLDS_LINE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_FOLDS_LINE_H_

#include <string>

#include "latticed/v1/fold.pb.h"

namespace latticed::client {

// "no fold in 27 knot boxes", or "folded: 2 of 27 knot boxes, 1 undecided", with a line break.
[[nodiscard]] std::string FoldsLine(const v1::FoldReport& report);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_COMMANDS_FOLDS_LINE_H_
