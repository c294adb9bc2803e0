// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/watch.h"

#include <chrono>
#include <utility>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/reply.h"
#include "client/cpp/library/status.h"
#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

// Of a ControlWatch: reading goes on afterwards, and tells what is wrong.
constexpr auto kControlTimeout = std::chrono::seconds(10);

}  // namespace

absl::StatusOr<std::unique_ptr<WatchStream>> WatchStream::Open(Client* client,
                                                               v1::WatchRequest watch,
                                                               EventObserver observer) {
  std::unique_ptr<WatchStream> stream(
      new WatchStream(client, std::move(watch), std::move(observer)));
  stream->stream_.Start();
  LATTICED_ASSIGN_OR_RETURN(auto first, stream->Next());
  if (!first.has_value() && client->stop_.stop_requested()) return Stopped();
  stream->first_update_ = std::move(first);
  return stream;
}

WatchStream::WatchStream(Client* client, v1::WatchRequest watch, EventObserver observer)
    : client_(client),
      stream_(
          std::move(watch), [this] { return client_->NewContext(stream_.watch().scene()); },
          [this](grpc::ClientContext* context, const v1::WatchRequest& request) {
            return client_->scenes_->Watch(context, request);
          },
          &surface_, client->stop_, std::move(observer)) {}

absl::Status WatchStream::Control(v1::ControlWatchRequest request) {
  request.set_scene(stream_.watch().scene());
  request.set_watch_id(hello_.watch_id());
  const auto context = client_->NewContext(stream_.watch().scene());
  context->set_deadline(std::chrono::system_clock::now() + kControlTimeout);
  v1::ControlWatchResponse response;
  const grpc::Status status = client_->scenes_->ControlWatch(context.get(), request, &response);
  return FromGrpc(status, *context);
}

absl::Status WatchStream::Show(v1::Presence presence) {
  presence_.Show(std::move(presence));
  return ControlPresence(*presence_.shown());
}

absl::Status WatchStream::ControlPresence(const v1::Presence& presence) {
  v1::ControlWatchRequest request;
  *request.mutable_presence() = presence;
  return Control(std::move(request));
}

absl::StatusOr<std::optional<CompleteUpdate>> WatchStream::Next() {
  for (;;) {
    LATTICED_ASSIGN_OR_RETURN(auto event, stream_.Read());
    if (!event.has_value()) return std::nullopt;
    auto update = Take(*std::move(event));
    if (!update.ok()) Cancel();
    if (!update.ok() || update->has_value()) return update;
  }
}

absl::StatusOr<std::optional<CompleteUpdate>> WatchStream::Take(v1::SceneEvent event) {
  // A ControlWatch that fails is not an error of its own: a stream that has broken is opened again
  // by Next, and one that has not goes on.
  switch (event.event_case()) {
    case v1::SceneEvent::kHello:
      hello_ = event.hello();
      presence_.Begin();
      if (presence_.shown().has_value()) (void)ControlPresence(*presence_.shown());
      return std::nullopt;
    case v1::SceneEvent::kPresence:
      presence_.Take(event.presence());
      return std::nullopt;
    case v1::SceneEvent::kHeartbeat:
      (void)Control({});
      return std::nullopt;
    default:
      break;
  }
  auto update = surface_.Apply(std::move(event));
  if (!update.ok() || !update->has_value()) return update;
  stream_.Worked((*update)->end.resume_token());
  v1::ControlWatchRequest acknowledgement;
  acknowledgement.set_acked_update_id((*update)->end.update_id());
  (void)Control(std::move(acknowledgement));
  return update;
}

}  // namespace latticed::client
