// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A store whose medium of meshes stands still, as a bucket may.
#ifndef LATTICED_TESTS_SERVER_SUPPORT_SLOW_MESH_STORE_H_
#define LATTICED_TESTS_SERVER_SUPPORT_SLOW_MESH_STORE_H_

#include <atomic>
#include <string>
#include <string_view>
#include <utility>

#include "absl/synchronization/notification.h"
#include "server/store/memory_store.h"

namespace latticed::testing {

// The first call that puts or deletes a mesh goes on when it is let go.
class SlowMeshStore : public MemoryStore {
 public:
  absl::Status PutMesh(std::string_view id, std::string header, std::string_view bytes) override {
    if (!is_quick_) StandStill();
    return MemoryStore::PutMesh(id, std::move(header), bytes);
  }
  absl::Status DeleteMesh(std::string_view id) override {
    StandStill();
    return MemoryStore::DeleteMesh(id);
  }
  // Only deletions stand still.
  void PutAtOnce() { is_quick_ = true; }
  void AwaitCall() { begun_.WaitForNotification(); }
  void LetGo() { go_on_.Notify(); }

 private:
  void StandStill() {
    if (was_called_.exchange(true)) return;
    begun_.Notify();
    go_on_.WaitForNotification();
  }

  std::atomic<bool> is_quick_ = false, was_called_ = false;
  absl::Notification begun_, go_on_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_SLOW_MESH_STORE_H_
