// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What this program is: project version and commit, set by CMake.
#ifndef LATTICED_SERVER_BASE_VERSION_H_
#define LATTICED_SERVER_BASE_VERSION_H_

#include <string_view>

namespace latticed {

[[nodiscard]] std::string_view Version();  // "0.1.0"
[[nodiscard]] std::string_view Commit();   // 12 hex digits, or "unknown" outside of a git checkout

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_VERSION_H_
