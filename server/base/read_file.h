// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The files that options name.
#ifndef LATTICED_SERVER_BASE_READ_FILE_H_
#define LATTICED_SERVER_BASE_READ_FILE_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace latticed {

// kInvalidArgument names the option, such as "--tls-key", and says why its file cannot be read.
[[nodiscard]] absl::StatusOr<std::string> ReadFile(std::string_view option,
                                                   const std::string& path);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_READ_FILE_H_
