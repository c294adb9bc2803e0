// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/base/read_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "fmt/format.h"

namespace latticed {

absl::StatusOr<std::string> ReadFile(const std::string& path) {
  const auto unreadable = [&](std::string_view why) {
    return absl::NotFoundError(fmt::format("cannot read {}: {}", path, why));
  };
  std::error_code failure;
  if (std::filesystem::is_directory(path, failure)) return unreadable("it is a folder");
  std::ifstream file(path, std::ios::binary);
  if (!file) return unreadable(std::strerror(errno));
  std::ostringstream bytes;
  // Copying an empty file would set failbit of `bytes`.
  if (file.peek() != std::ifstream::traits_type::eof()) bytes << file.rdbuf();
  if (file.bad() || !bytes) return unreadable(std::strerror(errno));
  return std::move(bytes).str();
}

}  // namespace latticed
