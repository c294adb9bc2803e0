// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Edits through one Deform stream, as a native client does. It sends the next edit when the update
// with the last one is complete. After its last edit it goes on watching.
#ifndef LATTICED_CLIENT_CPP_LOAD_CLOSED_LOOP_EDITOR_H_
#define LATTICED_CLIENT_CPP_LOAD_CLOSED_LOOP_EDITOR_H_

#include <atomic>
#include <memory>
#include <thread>

#include "absl/synchronization/notification.h"
#include "client/cpp/load/load_editor.h"

namespace latticed::client {

class ClosedLoopEditor final : public LoadEditor {
 public:
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<LoadEditor>> Open(
      std::unique_ptr<Client> client, v1::WatchRequest request, const Context& context);
  ClosedLoopEditor(const ClosedLoopEditor&) = delete;  // its thread uses it
  ClosedLoopEditor& operator=(const ClosedLoopEditor&) = delete;
  ~ClosedLoopEditor() override { Close(); }

  void Start(absl::Time begin) override;
  void WaitUntilDone() override { done_.WaitForNotification(); }
  [[nodiscard]] absl::Status WaitFor(uint64_t revision) override;
  void Close() override;
  const UpdateLog& log() const override { return log_; }
  const Surface& surface() const override { return stream_->surface(); }

 private:
  ClosedLoopEditor(std::unique_ptr<Client> client, const Context& context);
  absl::Status Edit();
  absl::Status EditOnce(uint64_t step);
  absl::Status Watch();
  // Waits for the next result or update. The error may be the refusal of an edit.
  absl::Status TakeNext();
  void Fail(const absl::Status& status);

  const std::unique_ptr<Client> client_;
  const Context context_;
  UpdateLog log_;
  v1::EditResult result_;                 // the newest
  uint64_t applied_sequence_ = 0;         // of the newest update
  std::unique_ptr<DeformStream> stream_;  // uses client_ and log_
  absl::Notification done_;
  std::atomic<bool> closing_ = false;
  std::thread thread_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_CLOSED_LOOP_EDITOR_H_
