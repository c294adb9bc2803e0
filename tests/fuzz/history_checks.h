// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What holds for every history of a scene, wherever it came from: its lattice is valid after any edit, undo and redo, and
// it comes back from its own bytes with the same bits. A check that fails ends the program.
#ifndef LATTICED_TESTS_FUZZ_HISTORY_CHECKS_H_
#define LATTICED_TESTS_FUZZ_HISTORY_CHECKS_H_

#include <string>

#include "core/ffd/history/edit_history.h"

namespace latticed::fuzz {

// Whether two encodings are the same. absl::Status gives its payloads in any order.
[[nodiscard]] bool SameBits(std::string a, std::string b);

// That with which histories and headers of scenes begin.
[[nodiscard]] Lattice FirstLattice();

// Takes the history back and forth, adds to it, and reads it from its own image.
void CheckHistory(EditHistory history);

}  // namespace latticed::fuzz

#endif  // LATTICED_TESTS_FUZZ_HISTORY_CHECKS_H_
