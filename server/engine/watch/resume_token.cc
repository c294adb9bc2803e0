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

std::string TokenOf(const TokenScope& scope, const ClientSurface& had, const std::string& run) {
  const std::string text = fmt::format(
      "{}/{}/{}/{}/{}/{}/{}", had.structure_id, had.quantisation_id, had.revision,
      absl::ToUnixNanos(had.commit_time), had.curvature_tolerance, run, KeyText(had.view));
  const std::string mac = HmacSha256Hex(scope.key, fmt::format("{}/{}", text, scope.evaluator));
  return fmt::format("{}/{}", text, mac.substr(0, kMacDigits));
}

}  // namespace

std::string MakeResumeToken(const TokenScope& scope, const ClientSurface& had) {
  return TokenOf(scope, had, scope.run);
}

std::optional<ClientSurface> ParseResumeToken(std::string_view token, const TokenScope& scope,
                                              const ViewKey& view, const SceneState& state,
                                              CommitTimeOf committed) {
  const std::vector<std::string> parts = absl::StrSplit(std::string(token), '/');
  ClientSurface had{.view = view};
  int64_t nanos = 0;
  if (parts.size() != 8 || !absl::SimpleAtoi(parts[2], &had.revision) ||
      !absl::SimpleAtoi(parts[3], &nanos) ||
      !absl::SimpleAtod(parts[4], &had.curvature_tolerance)) {
    return std::nullopt;
  }
  had.structure_id = state.structure_id;
  had.quantisation_id = QuantisationId(view, state.box);
  had.commit_time = absl::FromUnixNanos(nanos);
  const std::string& run = parts[5];
  if (had.revision > state.revision || token != TokenOf(scope, had, run)) return std::nullopt;
  if (run == scope.run) return had;
  return committed(had.revision) == had.commit_time ? std::optional(had) : std::nullopt;
}

}  // namespace latticed
