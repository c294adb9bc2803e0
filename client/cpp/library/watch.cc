// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/watch.h"

#include <chrono>
#include <utility>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/status.h"
#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

// A ControlWatch that takes longer is abandoned. Reading goes on, and returns the stream's error.
constexpr auto kControlTimeout = std::chrono::seconds(10);

}  // namespace

absl::StatusOr<std::unique_ptr<WatchStream>> WatchStream::Open(Client* client,
                                                               v1::WatchRequest watch,
                                                               EventObserver observer) {
  std::unique_ptr<WatchStream> stream(
      new WatchStream(client, std::move(watch), std::move(observer)));
  stream->Start();
  LATTICED_ASSIGN_OR_RETURN(stream->first_update_, stream->Next());
  if (!stream->first_update_.has_value() && client->stop_.stop_requested()) return Stopped();
  return stream;
}

WatchStream::WatchStream(Client* client, v1::WatchRequest watch, EventObserver observer)
    : ResumingStream(std::move(watch), client->reachability_.get(), client->stream_channel_.get(),
                     client->stop_, std::move(observer)),
      client_(client) {}

std::unique_ptr<grpc::ClientContext> WatchStream::NewContext() {
  return client_->NewContext(watch().scene());
}

std::unique_ptr<WatchStream::Rpc> WatchStream::OpenRpc(grpc::ClientContext* context) {
  return client_->streams_->Watch(context, watch());
}

absl::Status WatchStream::Control(v1::ControlWatchRequest request) {
  request.set_scene(watch().scene());
  request.set_watch_id(hello().watch_id());
  const auto context = NewContext();
  context->set_deadline(std::chrono::system_clock::now() + kControlTimeout);
  v1::ControlWatchResponse response;
  const grpc::Status status = client_->streams_->ControlWatch(context.get(), request, &response);
  return FromGrpc(status, *context);
}

absl::Status WatchStream::Show(v1::Presence presence) {
  shown_ = std::move(presence);
  return ControlPresence();
}

absl::Status WatchStream::ControlPresence() {
  v1::ControlWatchRequest request;
  *request.mutable_presence() = *shown_;
  return Control(std::move(request));
}

absl::StatusOr<std::optional<CompleteUpdate>> WatchStream::Next() {
  for (;;) {
    LATTICED_ASSIGN_OR_RETURN(auto event, Read());
    if (!event.has_value()) return std::nullopt;
    auto update = Take(*std::move(event));
    if (!update.ok()) Cancel();
    if (!update.ok() || update->has_value()) return update;
  }
}

absl::StatusOr<std::optional<CompleteUpdate>> WatchStream::Take(v1::SceneEvent event) {
  // A failed ControlWatch is ignored: Next opens a broken stream again, and an intact one goes on.
  if (event.has_hello() && shown_.has_value()) (void)ControlPresence();
  if (event.has_heartbeat()) (void)Control({});
  auto update = surface_.Apply(std::move(event));
  if (!update.ok() || !update->has_value()) return update;
  Worked((*update)->end.resume_token());
  v1::ControlWatchRequest acknowledgement;
  acknowledgement.set_acked_update_id((*update)->end.update_id());
  (void)Control(std::move(acknowledgement));
  return update;
}

}  // namespace latticed::client
