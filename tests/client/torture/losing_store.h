// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A store that says of some edits that they are kept, and does not keep them.
#ifndef LATTICED_TESTS_CLIENT_TORTURE_LOSING_STORE_H_
#define LATTICED_TESTS_CLIENT_TORTURE_LOSING_STORE_H_

#include <atomic>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/mutex.h"
#include "server/store/shared_memory_store.h"

namespace latticed::testing {

enum class Loses {
  kNothing,
  kEveryHundredth,  // record of all scenes together
  kTheRest,         // of the scene of each hundredth record, from it on
};

class LosingStore final : public SharedMemoryStore {
 public:
  LosingStore(std::shared_ptr<SharedMemory> memory, std::string name, Loses loses)
      : SharedMemoryStore(std::move(memory), std::move(name)), loses_(loses) {}

  void Append(std::string_view scene, uint64_t lsn, std::string record, Done done) override {
    const MutexLock lock(&mutex_);
    uint64_t& lost = lost_[std::string(scene)];
    if (lsn > 0 && IsLost(++appends_ % 100 == 0, lost)) {
      ++lost;
      lsn = 0;  // nothing is written, and `done` is called in its turn
      record.clear();
    }
    SharedMemoryStore::Append(scene, lsn == 0 ? 0 : lsn - lost, std::move(record), std::move(done));
  }
  // A snapshot would have what was lost.
  void PutSnapshot(std::string_view, uint64_t, std::string) override {}

  uint64_t appends() const { return appends_; }

 private:
  bool IsLost(bool hundredth, uint64_t lost) const {
    return loses_ != Loses::kNothing && (hundredth || (loses_ == Loses::kTheRest && lost > 0));
  }

  const Loses loses_;
  Mutex mutex_;
  std::atomic<uint64_t> appends_ = 0;
  std::map<std::string, uint64_t> lost_ ABSL_GUARDED_BY(mutex_);  // records, by scene
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_CLIENT_TORTURE_LOSING_STORE_H_
