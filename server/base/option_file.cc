// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/option_file.h"

#include <cstddef>
#include <filesystem>
#include <system_error>

#include "core/base/read_file.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr size_t kMostBytes = size_t{1} << 20;

}  // namespace

absl::Status BadOptionFile(std::string_view flag, std::string_view path, std::string_view problem) {
  return absl::InvalidArgumentError(fmt::format("{}: {}: {}", flag, path, problem));
}

absl::StatusOr<std::string> ReadOptionFile(std::string_view flag, const std::string& path) {
  std::error_code missing;
  if (!std::filesystem::is_regular_file(path, missing)) {
    return BadOptionFile(flag, path, "is no file");
  }
  if (std::filesystem::file_size(path, missing) > kMostBytes || missing) {
    return BadOptionFile(flag, path, "is larger than 1 MiB");
  }
  auto text = ReadFile(path);
  if (text.ok()) return text;
  return BadOptionFile(flag, path, std::string(text.status().message()));
}

}  // namespace latticed
