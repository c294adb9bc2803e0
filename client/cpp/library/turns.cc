// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/turns.h"

namespace latticed::client {

Turns::Turn Turns::Wait(const std::string& key, uint64_t number) {
  const MutexLock lock(&mutex_);
  Line& line = lines_[key];  // only its last user erases it
  const auto place = line.waiting.insert(number);
  mutex_.Await([&] { return !line.busy && place == line.waiting.begin(); });
  line.waiting.erase(place);
  line.busy = true;
  return Turn(this, key);
}

Turns::Turn::~Turn() {
  const MutexLock lock(&turns_->mutex_);
  const auto line = turns_->lines_.find(key_);
  line->second.busy = false;
  if (line->second.waiting.empty()) turns_->lines_.erase(line);
}

}  // namespace latticed::client
