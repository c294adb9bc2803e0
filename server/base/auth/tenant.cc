// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth/tenant.h"

#include <algorithm>

#include "fmt/format.h"

namespace latticed {

bool IsTenantName(std::string_view name) {
  constexpr size_t kMostBytes = 63;
  return !name.empty() && name.size() <= kMostBytes && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

std::string TenantKey(std::string_view tenant, std::string_view id) {
  if (tenant.empty() && id.find('/') == std::string_view::npos) return std::string(id);
  return fmt::format("{}/{}", tenant, id);
}

std::string_view TenantOf(std::string_view key) {
  const size_t slash = key.find('/');
  return slash == std::string_view::npos ? "" : key.substr(0, slash);
}

std::string_view IdOf(std::string_view key) {
  const size_t slash = key.find('/');
  return slash == std::string_view::npos ? key : key.substr(slash + 1);
}

}  // namespace latticed
