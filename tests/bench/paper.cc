// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper.h"
namespace latticed::bench {
std::vector<Section> PaperTables() { return {}; }
}  // namespace latticed::bench
