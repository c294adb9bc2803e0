// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/connection_set.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "core/base/limits.h"

namespace latticed::web {

std::shared_ptr<ConnectionSet::Place> ConnectionSet::Enter(const std::string& address) {
  std::shared_ptr<Connection> replaced;
  std::shared_ptr<Place> place;
  {
    const MutexLock lock(&mutex_);
    const auto of_address = std::ranges::count(
        connections_, address, [](const auto& entry) { return entry.second.address; });
    const bool has_share = address.empty() || static_cast<size_t>(of_address) < most_of_address_;
    const bool served = has_share && (served_ < most_ || replaces_);
    if (!served) ++refused_;
    if (!served && connections_.size() - served_ >= limits::kMaxRefusedHttpConnections)
      return nullptr;
    if (served && served_ >= most_ && !connections_.empty()) {
      replaced = connections_.begin()->second.connection.lock();
    }
    if (served) ++served_;
    const uint64_t id = next_id_++;
    connections_.emplace(id, Entry{.address = served ? address : "", .connection = {}});
    place = std::make_shared<Place>(this, id, served);
  }
  if (replaced != nullptr) replaced->Abort();
  return place;
}

void ConnectionSet::Leave(uint64_t id, bool served) {
  const MutexLock lock(&mutex_);
  if (served) --served_;
  connections_.erase(id);
}

void ConnectionSet::Hold(uint64_t id, const std::shared_ptr<Connection>& connection) {
  bool draining = false, aborting = false;
  {
    const MutexLock lock(&mutex_);
    connections_[id].connection = connection;
    draining = draining_;
    aborting = aborting_;
  }
  if (draining) connection->Drain();
  if (aborting) connection->Abort();
}

void ConnectionSet::Drain() {
  {
    const MutexLock lock(&mutex_);
    draining_ = true;
  }
  TellAll(&Connection::Drain);
}

void ConnectionSet::Abort() {
  {
    const MutexLock lock(&mutex_);
    aborting_ = true;
  }
  TellAll(&Connection::Abort);
}

ConnectionCounts ConnectionSet::counts() const {
  const MutexLock lock(&mutex_);
  return {.open = served_, .most = most_, .refused = refused_};
}

// Calls `what` without the lock: this may destroy a connection, whose place then calls Leave.
void ConnectionSet::TellAll(void (Connection::*what)()) {
  std::vector<std::shared_ptr<Connection>> all;
  {
    const MutexLock lock(&mutex_);
    for (const auto& [id, entry] : connections_) {
      if (auto held = entry.connection.lock(); held != nullptr) all.push_back(std::move(held));
    }
  }
  for (const auto& connection : all) ((*connection).*what)();
}

bool ConnectionSet::AwaitEmpty(absl::Time deadline) {
  const MutexLock lock(&mutex_);
  return mutex_.AwaitFor([this]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return connections_.empty(); },
                         std::max(deadline - absl::Now(), absl::ZeroDuration()));
}

}  // namespace latticed::web
