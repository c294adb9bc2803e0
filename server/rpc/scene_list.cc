// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/scene_list.h"

#include <algorithm>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/labels.h"
#include "server/stores/scene_registry.h"
#include "server/wire/scene_converters.h"
#include "server/wire/stored_scene.h"

namespace latticed {
namespace {

constexpr int64_t kNanosPerSecond = 1'000'000'000;

// A scene's place in lists, which are oldest first. A page begins after the scene that its key names.
struct PageKey {
  int64_t created = std::numeric_limits<int64_t>::min();  // Unix time, nanoseconds
  std::string id;
  friend auto operator<=>(const PageKey&, const PageKey&) = default;
};
PageKey KeyOf(const v1::Scene& scene) {
  const auto& time = scene.create_time();
  return {time.seconds() * kNanosPerSecond + time.nanos(), scene.id()};
}

std::string ToToken(const PageKey& key) { return fmt::format("{}.{}", key.created, key.id); }
absl::StatusOr<PageKey> FromToken(const std::string& token) {
  if (token.empty()) return PageKey{};
  const size_t dot = token.find('.');
  int64_t nanos = 0;
  if (dot == std::string::npos || !absl::SimpleAtoi(token.substr(0, dot), &nanos)) {
    return error::InvalidField("page_token", "was not issued by this server");
  }
  return PageKey{nanos, token.substr(dot + 1)};
}

// All scenes by id. What is in memory is newer than what is stored. Damaged ones are named in the log, and left out.
absl::StatusOr<std::map<std::string, v1::Scene>> AllScenes(ServerEnv& env) {
  std::map<std::string, v1::Scene> all;
  LATTICED_ASSIGN_OR_RETURN(const auto stored, env.scenes->Stored());
  for (const StoredEntry& entry : stored) {
    if (auto scene = ListedScene(entry.header); scene.ok()) all[entry.id] = *std::move(scene);
  }
  for (const auto& scene : env.scenes->All()) all[scene->id()] = ToProto(*scene);
  return all;
}

}  // namespace

absl::Status ListScenes(const CallContext& context, const v1::ListScenesRequest& request,
                        v1::ListScenesResponse& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto size, PageSize(request.page_size()));
  LATTICED_ASSIGN_OR_RETURN(const auto filter, LabelFilter::Parse(request.filter()));
  LATTICED_ASSIGN_OR_RETURN(const auto after, FromToken(request.page_token()));
  LATTICED_ASSIGN_OR_RETURN(auto all, AllScenes(context.env));
  std::vector<v1::Scene> scenes;
  for (auto& [id, scene] : all) {
    if (!filter.Matches({scene.labels().begin(), scene.labels().end()})) continue;
    if (KeyOf(scene) > after) scenes.push_back(std::move(scene));
  }
  std::ranges::sort(scenes, {}, KeyOf);
  PageRoom room(size);
  PageKey last;
  for (v1::Scene& scene : scenes) {
    if (!room.Take(scene.ByteSizeLong())) {
      response.set_next_page_token(ToToken(last));
      break;
    }
    last = KeyOf(scene);
    *response.add_scenes() = std::move(scene);
  }
  return absl::OkStatus();
}

}  // namespace latticed
