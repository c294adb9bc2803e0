// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits that are due every period: ApplyEdits from one thread, beside a watch, as a browser does.
// One batch is on its way at a time, as the protocol asks. In the open loop each edit is a batch of
// its own, late or not. In interval mode all edits are one gesture, and only the newest of those
// that are due is sent.
#ifndef LATTICED_CLIENT_CPP_LOAD_PERIODIC_EDITOR_H_
#define LATTICED_CLIENT_CPP_LOAD_PERIODIC_EDITOR_H_

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "client/cpp/load/load_editor.h"
#include "client/cpp/load/load_watcher.h"

namespace latticed::client {

class PeriodicEditor final : public LoadEditor {
 public:
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<LoadEditor>> Open(
      std::unique_ptr<Client> client, v1::WatchRequest request, const Context& context);
  PeriodicEditor(const PeriodicEditor&) = delete;  // its thread uses it
  PeriodicEditor& operator=(const PeriodicEditor&) = delete;
  ~PeriodicEditor() override { Close(); }

  void Start(absl::Time begin) override;
  void WaitUntilDone() override { done_.WaitForNotification(); }
  [[nodiscard]] absl::Status WaitFor(uint64_t revision) override {
    return watcher_->log().WaitFor(revision);
  }
  void Close() override;
  const UpdateLog& log() const override { return watcher_->log(); }
  const Surface& surface() const override { return watcher_->surface(); }

 private:
  PeriodicEditor(Client* client, std::string scene, std::unique_ptr<LoadWatcher> watcher,
                 const Context& context);
  absl::Status Edit(absl::Time first_due);
  // The newest edit that is due by now, `step` or later: it replaces the others.
  uint64_t NewestDue(uint64_t step, absl::Time first_due) const;
  absl::Status Apply(v1::EditBatch batch, uint64_t step, const std::vector<absl::Time>& due);
  absl::Status Commit();
  absl::StatusOr<v1::EditResult> Send(v1::EditBatch batch, v1::GesturePhase phase);

  Client* const client_;  // the watcher's
  const std::string scene_, editor_id_;
  const std::unique_ptr<LoadWatcher> watcher_;
  const Context context_;
  uint64_t sequence_ = 0;
  absl::Notification done_;
  std::thread thread_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_PERIODIC_EDITOR_H_
