// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Whole files.
#ifndef LATTICED_CORE_BASE_READ_FILE_H_
#define LATTICED_CORE_BASE_READ_FILE_H_

#include <string>

#include "absl/status/statusor.h"

namespace latticed {

// The bytes of a file. kNotFound names it and says why it cannot be read.
//
// Threads  safe
[[nodiscard]] absl::StatusOr<std::string> ReadFile(const std::string& path);

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_READ_FILE_H_
