// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The files that options name, and that the thread which keeps house reads again: it must not wait.
#ifndef LATTICED_SERVER_BASE_OPTION_FILE_H_
#define LATTICED_SERVER_BASE_OPTION_FILE_H_

#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

// kInvalidArgument: "--quota-file: PATH: what is wrong".
[[nodiscard]] absl::Status BadOptionFile(std::string_view flag, std::string_view path,
                                         std::string_view problem);
// The bytes of a file of at most 1 MiB, which is neither a pipe nor a device. BadOptionFile.
//
// Threads  safe
[[nodiscard]] absl::StatusOr<std::string> ReadOptionFile(std::string_view flag,
                                                         const std::string& path);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_OPTION_FILE_H_
