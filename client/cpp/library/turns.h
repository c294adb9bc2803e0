// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Admits one caller per key at a time. Of the waiting callers the lowest number goes next.
//
//   const Turns::Turn turn = turns.Wait("scene editor", batch.sequence());  // until destroyed
//
// Threads  any number
#ifndef LATTICED_CLIENT_CPP_LIBRARY_TURNS_H_
#define LATTICED_CLIENT_CPP_LIBRARY_TURNS_H_

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "core/base/mutex.h"

namespace latticed::client {

class Turns {
 public:
  // Its destruction admits the next caller.
  class Turn {
   public:
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    ~Turn();

   private:
    friend class Turns;
    Turn(Turns* turns, std::string key) : turns_(turns), key_(std::move(key)) {}
    Turns* const turns_;
    const std::string key_;
  };

  [[nodiscard]] Turn Wait(const std::string& key, uint64_t number);

 private:
  struct Line {
    bool busy = false;
    std::multiset<uint64_t> waiting;
  };

  Mutex mutex_;
  std::map<std::string, Line> lines_ ABSL_GUARDED_BY(mutex_);  // only keys in use
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_TURNS_H_
