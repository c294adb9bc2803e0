// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticed_client_turns.h"

namespace latticed::client {

Turns::Turn Turns::Wait(const std::string& key, uint64_t number) {
  std::unique_lock lock(mutex_);
  Line& line = lines_[key];  // stays where it is, and is erased by its last user alone
  const auto place = line.waiting.insert(number);
  changed_.wait(lock, [&] { return !line.busy && place == line.waiting.begin(); });
  line.waiting.erase(place);
  line.busy = true;
  return Turn(this, key);
}

Turns::Turn::~Turn() {
  {
    const std::lock_guard lock(turns_->mutex_);
    const auto line = turns_->lines_.find(key_);
    line->second.busy = false;
    if (line->second.waiting.empty()) turns_->lines_.erase(line);
  }
  turns_->changed_.notify_all();
}

}  // namespace latticed::client
