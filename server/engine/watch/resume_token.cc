// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/watch/resume_token.h"

#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/base/sha256.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr size_t kMacDigits = 32;  // 128 bits

// All numbers that distinguish one view from another.
std::string KeyText(const ViewKey& key) {
  const ViewSpec& s = key.spec;
  return fmt::format("{}.{}.{}.{}.{}.{}.{}", s.segments, static_cast<int>(s.normals),
                     static_cast<int>(s.format), s.position_bits, s.normal_bits,
                     static_cast<int>(key.encoding), s.tolerance);
}

}  // namespace

std::string MakeResumeToken(const TokenScope& scope, const ClientSurface& had) {
  const std::string text = fmt::format("{}/{}/{}/{}", had.structure_id, had.quantisation_id,
                                       had.revision, KeyText(had.view));
  const std::string mac = HmacSha256Hex(scope.key, fmt::format("{}/{}", text, scope.evaluator));
  return fmt::format("{}/{}", text, mac.substr(0, kMacDigits));
}

std::optional<ClientSurface> ParseResumeToken(std::string_view token, const TokenScope& scope,
                                              const ViewKey& view, const SceneState& state) {
  const std::vector<std::string> parts = absl::StrSplit(std::string(token), '/');
  ClientSurface had{.view = view};
  if (parts.size() != 5 || !absl::SimpleAtoi(parts[2], &had.revision)) return std::nullopt;
  had.structure_id = state.structure_id;
  had.quantisation_id = QuantisationId(view, state.box);
  if (had.revision > state.revision || token != MakeResumeToken(scope, had)) return std::nullopt;
  return had;
}

}  // namespace latticed
