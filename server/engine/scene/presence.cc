// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/engine/scene/presence.h"

#include <utility>

#include "core/base/limits.h"
#include "server/engine/scene/scene_listener.h"

namespace latticed {
namespace {

constexpr absl::Duration kInterval = absl::Milliseconds(1000 / limits::kMaxPresencesPerSecond);

}  // namespace

PresenceBoard::Waiting PresenceBoard::Show(Stream stream, Presence presence) {
  auto shown = std::make_shared<const Presence>(std::move(presence));
  const MutexLock lock(&mutex_);
  Editor& editor = editors_[shown->editor_id];
  editor.streams.insert(stream);
  EditorName name;
  if (const auto before = entries_.extract(editor.version); !before.empty()) {
    name = before.mapped().editor;
  } else {
    name = std::make_shared<const std::string>(shown->editor_id);
  }
  editor.version = ++news_.version;
  entries_.emplace_hint(entries_.end(), editor.version,
                        Entry{editor.version, std::move(name), std::move(shown)});
  return std::exchange(waiting_, {});
}

PresenceBoard::Waiting PresenceBoard::Leave(Stream stream, const std::string& editor_id) {
  const MutexLock lock(&mutex_);
  waiting_.erase(stream);
  const auto editor = editors_.find(editor_id);
  if (editor == editors_.end() || editor->second.streams.erase(stream) == 0 ||
      !editor->second.streams.empty()) {
    return {};
  }
  entries_.erase(editor->second.version);
  editors_.erase(editor);
  news_.departure = ++news_.version;
  return std::exchange(waiting_, {});
}

std::optional<PresenceBoard::News> PresenceBoard::NewsSince(
    uint64_t version, const std::shared_ptr<SceneListener>& stream) {
  const MutexLock lock(&mutex_);
  if (version != news_.version) return news_;
  waiting_.try_emplace(stream.get(), stream);
  return std::nullopt;
}

std::optional<PresenceBoard::Entry> PresenceBoard::NextAfter(uint64_t version) const {
  const MutexLock lock(&mutex_);
  const auto next = entries_.upper_bound(version);
  if (next == entries_.end()) return std::nullopt;
  return next->second;
}

bool PresenceBoard::Shows(const std::string& editor_id) const {
  const MutexLock lock(&mutex_);
  return editors_.contains(editor_id);
}

std::shared_ptr<const Presence> PresenceFeed::Next(absl::Time now,
                                                   const std::shared_ptr<SceneListener>& stream) {
  wake_at_ = absl::InfiniteFuture();
  for (;;) {
    if (!turn_end_.has_value()) {
      if (now < next_turn_) {
        wake_at_ = next_turn_;
        return nullptr;
      }
      if (!BeginTurn(stream)) return nullptr;
    }
    if (auto presence = NextOfTurn(); presence != nullptr) {
      told_in_turn_ = true;
      return presence;
    }
    read_ = *turn_end_;
    turn_end_.reset();
    if (std::exchange(told_in_turn_, false)) next_turn_ = now + kInterval;
  }
}

bool PresenceFeed::BeginTurn(const std::shared_ptr<SceneListener>& stream) {
  const auto news = board_->NewsSince(read_, stream);
  if (!news.has_value()) return false;
  turn_end_ = news->version;
  if (std::exchange(departure_, news->departure) == news->departure) return true;
  for (const auto& editor : told_) {
    if (!board_->Shows(*editor)) left_.push_back(editor);
  }
  return true;
}

std::shared_ptr<const Presence> PresenceFeed::NextOfTurn() {
  if (!left_.empty()) {
    auto left = std::make_shared<Presence>();
    left->editor_id = *left_.back();
    left->left = true;
    told_.erase(left_.back());
    left_.pop_back();
    return left;
  }
  for (;;) {
    auto entry = board_->NextAfter(read_);
    if (!entry.has_value() || entry->version > *turn_end_) return nullptr;
    read_ = entry->version;
    if (*entry->editor == own_editor_) continue;
    told_.insert(std::move(entry->editor));
    return std::move(entry->presence);
  }
}

void Wake(const PresenceBoard::Waiting& waiting) {
  for (const auto& [stream, listener] : waiting) {
    if (const auto alive = listener.lock(); alive != nullptr) alive->OnSceneChanged();
  }
}

}  // namespace latticed
