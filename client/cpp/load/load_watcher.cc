// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/load/load_watcher.h"

#include <utility>

#include "core/base/status_macros.h"

namespace latticed::client {

absl::StatusOr<std::unique_ptr<LoadWatcher>> LoadWatcher::Open(std::unique_ptr<Client> client,
                                                               v1::WatchRequest request,
                                                               const Options& options,
                                                               LoadControl* control) {
  std::unique_ptr<LoadWatcher> watcher(new LoadWatcher(std::move(client), options, control));
  if (options.pace == Pace::kStalled) request.set_max_unacked_updates(0);
  LATTICED_ASSIGN_OR_RETURN(
      auto stream,
      watcher->client_->Watch(std::move(request),
                              [self = watcher.get()](const auto& event) { self->Take(event); }));
  watcher->stream_ = std::move(stream);
  watcher->open_ = true;
  if (options.pace != Pace::kStalled) {
    watcher->thread_ = std::thread([self = watcher.get()] { self->Read(); });
  }
  return watcher;
}

LoadWatcher::LoadWatcher(std::unique_ptr<Client> client, const Options& options,
                         LoadControl* control)
    : client_(std::move(client)), options_(options), control_(control) {}

void LoadWatcher::Close() {
  if (!closing_.HasBeenNotified()) closing_.Notify();
  if (stream_ != nullptr) stream_->Cancel();
  if (thread_.joinable()) thread_.join();
}

void LoadWatcher::Take(const v1::SceneEvent& event) {
  log_.Take(event);
  if (!open_ || options_.pace != Pace::kSlow) return;
  const double seconds = static_cast<double>(event.ByteSizeLong()) / options_.bytes_per_second;
  (void)closing_.WaitForNotificationWithTimeout(absl::Seconds(seconds));
}

void LoadWatcher::Read() {
  for (;;) {
    const auto update = stream_->Next();
    absl::Status status = update.status();
    if (status.ok() && !update->has_value()) {
      status = absl::UnavailableError("the server has ended a watch");
    }
    if (status.ok() && options_.decodes) status = log_.DecodeNewest(stream_->surface());
    if (status.ok() && control_->begun()) log_.SampleNewest(stream_->surface());
    if (closing_.HasBeenNotified()) return;
    if (status.ok()) continue;
    control_->Fail(status);
    log_.Fail(status);
    return;
  }
}

}  // namespace latticed::client
