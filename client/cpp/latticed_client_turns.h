// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One caller at a time per key; of those that wait the lowest number goes next.
//
//   const Turns::Turn turn = turns.Wait("scene editor", batch.sequence());  // until destroyed
//
// Threads  any number
#ifndef LATTICED_CLIENT_CPP_LATTICED_CLIENT_TURNS_H_
#define LATTICED_CLIENT_CPP_LATTICED_CLIENT_TURNS_H_

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <set>
#include <string>

namespace latticed::client {

class Turns {
 public:
  // Its destruction lets the next one go.
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

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::string, Line> lines_;  // of keys in use alone
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICED_CLIENT_TURNS_H_
