// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticed_client_watch.h"

#include <chrono>
#include <utility>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/latticed_client.h"
#include "client/cpp/latticed_client_reply.h"

namespace latticed::client {
namespace {

// Of a ControlWatch: reading goes on afterwards, and tells what is wrong.
constexpr auto kControlTimeout = std::chrono::seconds(10);

absl::Duration ToDuration(const google::protobuf::Duration& duration) {
  return absl::Seconds(duration.seconds()) + absl::Nanoseconds(duration.nanos());
}

}  // namespace

absl::StatusOr<std::unique_ptr<WatchStream>> WatchStream::Open(Client* client,
                                                               v1::WatchRequest watch) {
  std::unique_ptr<WatchStream> stream(new WatchStream(client, std::move(watch)));
  stream->Start();
  auto first = stream->Next();
  if (!first.ok()) return first.status();
  stream->first_update_ = *std::move(first);
  return stream;
}

WatchStream::WatchStream(Client* client, v1::WatchRequest watch)
    : client_(client), watch_(std::move(watch)) {}

WatchStream::~WatchStream() {
  if (stream_ == nullptr) return;
  Cancel();
  v1::SceneEvent event;
  while (stream_->Read(&event)) {
  }
  (void)stream_->Finish();
}

void WatchStream::Start() {
  {
    const std::lock_guard lock(context_mutex_);
    stream_.reset();
    context_ = client_->NewContext(watch_.scene());
    if (cancelled_) context_->TryCancel();
  }
  goaway_ = false;
  stream_ = client_->scenes_->Watch(context_.get(), watch_);
}

absl::StatusOr<bool> WatchStream::Restart() {
  const absl::Status status = FromGrpc(stream_->Finish(), *context_);
  stream_.reset();
  surface_.DropPartialUpdate();
  const bool done = status.ok() && !goaway_;
  if (done || cancelled_) return true;
  if (!status.ok()) {
    if (auto fatal = reopening_.AfterBreak(status); !fatal.ok()) return fatal;
  }
  ++reconnections_;
  Start();
  return false;
}

void WatchStream::Cancel() {
  cancelled_ = true;
  const std::lock_guard lock(context_mutex_);
  if (context_ != nullptr) context_->TryCancel();
}

absl::Status WatchStream::Control(v1::ControlWatchRequest request) {
  request.set_scene(watch_.scene());
  request.set_watch_id(hello_.watch_id());
  const auto context = client_->NewContext(watch_.scene());
  context->set_deadline(std::chrono::system_clock::now() + kControlTimeout);
  v1::ControlWatchResponse response;
  const grpc::Status status = client_->scenes_->ControlWatch(context.get(), request, &response);
  return FromGrpc(status, *context);
}

absl::StatusOr<std::optional<CompleteUpdate>> WatchStream::Next() {
  while (stream_ != nullptr) {
    v1::SceneEvent event;
    if (!stream_->Read(&event)) {
      const auto ended = Restart();
      if (!ended.ok()) return ended.status();
      if (*ended) return std::nullopt;
      continue;
    }
    auto update = Take(std::move(event));
    if (!update.ok()) Cancel();
    if (!update.ok() || update->has_value()) return update;
  }
  return std::nullopt;
}

absl::StatusOr<std::optional<CompleteUpdate>> WatchStream::Take(v1::SceneEvent event) {
  // A ControlWatch that fails is not an error of its own: a stream that has broken is opened again
  // by Next, and one that has not goes on.
  switch (event.event_case()) {
    case v1::SceneEvent::kHello:
      hello_ = event.hello();
      return std::nullopt;
    case v1::SceneEvent::kHeartbeat:
      (void)Control({});
      return std::nullopt;
    case v1::SceneEvent::kGoaway:
      goaway_ = true;
      absl::SleepFor(ToDuration(event.goaway().retry_after()));
      return std::nullopt;
    default:
      break;
  }
  auto update = surface_.Apply(std::move(event));
  if (!update.ok() || !update->has_value()) return update;
  reopening_.Worked();
  watch_.set_resume_token((*update)->end.resume_token());
  v1::ControlWatchRequest acknowledgement;
  acknowledgement.set_acked_update_id((*update)->end.update_id());
  (void)Control(std::move(acknowledgement));
  return update;
}

}  // namespace latticed::client
