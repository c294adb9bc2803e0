// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/scene_list.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
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
PageKey KeyOf(const Scene& scene) {
  return {absl::ToUnixNanos(scene.create_time()), std::string(IdOf(scene.id()))};
}
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

struct Item {
  PageKey key;
  std::shared_ptr<Scene> scene;  // null if it is asleep
  v1::Scene listed;              // of a scene that is asleep
};

// The tenant's scenes after `after` that match, in any order.
absl::StatusOr<std::vector<Item>> ItemsAfter(ServerEnv& env, const std::string& tenant,
                                             const PageKey& after, const LabelFilter& filter) {
  std::vector<Item> items;
  const auto add = [&](std::shared_ptr<Scene> scene) {
    PageKey key = KeyOf(*scene);
    if (key <= after || !filter.Matches(scene->config().labels)) return;
    items.push_back({std::move(key), std::move(scene)});
  };
  // The store first: a scene that is made meanwhile is then in memory.
  LATTICED_ASSIGN_OR_RETURN(const auto stored, env.scenes->Stored());
  std::set<std::string> in_memory;
  for (auto& scene : env.scenes->All()) {
    if (TenantOf(scene->id()) != tenant) continue;
    in_memory.insert(scene->id());
    add(std::move(scene));
  }
  for (const StoredEntry& entry : stored) {
    if (TenantOf(entry.id) != tenant || in_memory.contains(entry.id)) continue;
    if (auto listed = ListedScene(entry.header); listed.ok()) {
      PageKey key = KeyOf(*listed);
      if (key <= after || !filter.Matches({listed->labels().begin(), listed->labels().end()})) {
        continue;
      }
      items.push_back({std::move(key), nullptr, *std::move(listed)});
      continue;
    }
    auto woken = env.scenes->Find(entry.id);
    // Damaged ones are named in the log, and left out.
    if (absl::IsDataLoss(woken.status()) || absl::IsNotFound(woken.status())) continue;
    LATTICED_RETURN_IF_ERROR(woken.status());
    add(*std::move(woken));
  }
  return items;
}

}  // namespace

absl::Status ListScenes(const CallContext& context, const v1::ListScenesRequest& request,
                        v1::ListScenesResponse& response) {
  LATTICED_ASSIGN_OR_RETURN(const auto size, PageSize(request.page_size()));
  LATTICED_ASSIGN_OR_RETURN(const auto filter, LabelFilter::Parse(request.filter()));
  LATTICED_ASSIGN_OR_RETURN(const auto after, FromToken(request.page_token()));
  LATTICED_ASSIGN_OR_RETURN(auto items,
                            ItemsAfter(context.env, context.call.caller.tenant, after, filter));
  std::ranges::sort(items, {}, &Item::key);
  PageRoom room(size);
  PageKey last;
  for (Item& item : items) {
    v1::Scene scene = item.scene != nullptr ? ToProto(*item.scene) : std::move(item.listed);
    if (!room.Take(scene.ByteSizeLong())) {
      response.set_next_page_token(ToToken(last));
      break;
    }
    *response.add_scenes() = std::move(scene);
    last = std::move(item.key);
  }
  return absl::OkStatus();
}

}  // namespace latticed
