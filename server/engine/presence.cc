// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/presence.h"

#include <algorithm>
#include <utility>

#include "core/base/limits.h"

namespace latticed {
namespace {

constexpr absl::Duration kInterval = absl::Milliseconds(1000 / limits::kMaxPresencesPerSecond);

}  // namespace

void PresenceBoard::Show(Owner owner, Presence presence) {
  const MutexLock lock(&mutex_);
  owners_[presence.editor_id].insert(owner);
  Entry& entry = entries_[presence.editor_id];
  entry.presence = std::make_shared<const Presence>(std::move(presence));
  entry.version = ++version_;
}

bool PresenceBoard::Leave(Owner owner) {
  const MutexLock lock(&mutex_);
  const size_t before = entries_.size();
  for (auto it = owners_.begin(); it != owners_.end();) {
    it->second.erase(owner);
    if (!it->second.empty()) {
      ++it;
      continue;
    }
    entries_.erase(it->first);
    it = owners_.erase(it);
  }
  if (entries_.size() == before) return false;
  ++version_;
  return true;
}

std::optional<std::map<std::string, PresenceBoard::Entry>> PresenceBoard::NewsSince(
    uint64_t& version) const {
  const MutexLock lock(&mutex_);
  if (version == version_) return std::nullopt;
  version = version_;
  return entries_;
}

std::shared_ptr<const Presence> PresenceFeed::Next(absl::Time now) {
  if (auto news = board_->NewsSince(version_); news.has_value()) there_ = *std::move(news);
  wake_at_ = absl::InfiniteFuture();
  for (auto told = told_.begin(); told != told_.end(); ++told) {
    if (there_.contains(told->first)) continue;
    auto left = std::make_shared<Presence>();
    left->editor_id = told->first;
    left->left = true;
    told_.erase(told);
    return left;
  }
  for (const auto& [editor, entry] : there_) {
    if (editor == own_editor_) continue;
    const auto told = told_.find(editor);
    if (told != told_.end() && told->second.version == entry.version) continue;
    if (told != told_.end() && now < told->second.time + kInterval) {
      wake_at_ = std::min(wake_at_, told->second.time + kInterval);
      continue;
    }
    told_[editor] = {.version = entry.version, .time = now};
    return entry.presence;
  }
  return nullptr;
}

}  // namespace latticed
