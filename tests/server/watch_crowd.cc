// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/watch_crowd.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>

#include <grpcpp/alarm.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include "absl/time/clock.h"
#include "core/base/mutex.h"

namespace latticed::testing {
namespace {

constexpr char kMethod[] = "/latticed.v1.SceneService/Watch";
// Larger messages carry chunks.
constexpr size_t kSmallMessage = size_t{4} << 10;

std::shared_ptr<grpc::Channel> OwnConnection(const std::string& address, bool reads) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  // Otherwise the window of a fast connection grows, and this side holds megabytes that nobody reads.
  if (!reads) arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

}  // namespace

class WatchCrowd::Stream : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  Stream(const std::string& address, const v1::WatchRequest& request, const Options& options)
      : options_(options), stub_(OwnConnection(address, options.reads)) {
    const grpc::Slice slice(request.SerializeAsString());
    request_ = grpc::ByteBuffer(&slice, 1);
    stub_.PrepareBidiStreamingCall(&context_, kMethod, grpc::StubOptions(), this);
    AddHold();  // for reads that begin outside of reactions
    StartCall();
    StartWriteLast(&request_, grpc::WriteOptions());
    if (options.reads) StartRead(&message_);
  }
  ~Stream() override {
    context_.TryCancel();
    {
      const MutexLock lock(&mutex_);
      pause_.reset();  // cancels it: then it does not read
      let_go_ = true;
      RemoveHold();
    }
    const MutexLock lock(&mutex_);
    mutex_.Await([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return done_; });
  }

  void ReadOn() {
    const MutexLock lock(&mutex_);
    if (!let_go_) StartRead(&message_);
  }
  bool WaitForRevision(uint64_t revision, absl::Time deadline) {
    const MutexLock lock(&mutex_);
    mutex_.AwaitFor([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(
                        mutex_) { return done_ || (updates_ > 0 && revision_ >= revision); },
                    deadline - absl::Now());
    return updates_ > 0 && revision_ >= revision;
  }
  uint64_t updates() const { return updates_; }
  uint64_t restarts() const { return restarts_; }

  void OnReadDone(bool ok) override {
    if (!ok) return;
    if (message_.Length() <= kSmallMessage) Take();
    if (options_.pause == absl::ZeroDuration()) return StartRead(&message_);
    const MutexLock lock(&mutex_);
    if (let_go_) return;
    pause_ = std::make_unique<grpc::Alarm>();
    pause_->Set(absl::ToChronoTime(absl::Now() + options_.pause), [this](bool expired) {
      if (expired) ReadOn();
    });
  }
  void OnDone(const grpc::Status& /*status*/) override {
    const MutexLock lock(&mutex_);
    done_ = true;
  }

 private:
  void Take() {
    std::vector<grpc::Slice> slices;
    if (!message_.Dump(&slices).ok()) return;
    std::string bytes;
    for (const grpc::Slice& slice : slices) {
      bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
    }
    v1::SceneEvent event;
    if (!event.ParseFromString(bytes)) return;
    if (event.has_update_begin() && event.update_begin().restart()) ++restarts_;
    if (!event.has_update_end()) return;
    options_.on_update(event.update_end().revision());
    const MutexLock lock(&mutex_);
    revision_ = event.update_end().revision();
    ++updates_;
  }

  const Options options_;
  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::ByteBuffer request_, message_;
  std::atomic<uint64_t> updates_ = 0, restarts_ = 0;

  Mutex mutex_;
  std::unique_ptr<grpc::Alarm> pause_ ABSL_GUARDED_BY(mutex_);
  uint64_t revision_ ABSL_GUARDED_BY(mutex_) = 0;
  bool let_go_ ABSL_GUARDED_BY(mutex_) = false;
  bool done_ ABSL_GUARDED_BY(mutex_) = false;
};

WatchCrowd::WatchCrowd(const std::string& address, const v1::WatchRequest& request,
                       Options options) {
  for (int i = 0; i < options.count; ++i) {
    streams_.push_back(std::make_unique<Stream>(address, request, options));
  }
}

WatchCrowd::~WatchCrowd() = default;

void WatchCrowd::ReadOn() {
  for (const auto& stream : streams_) stream->ReadOn();
}

bool WatchCrowd::WaitForRevision(uint64_t revision, absl::Duration most) const {
  const absl::Time deadline = absl::Now() + most;
  return std::ranges::all_of(
      streams_, [&](const auto& stream) { return stream->WaitForRevision(revision, deadline); });
}

uint64_t WatchCrowd::updates() const {
  uint64_t sum = 0;
  for (const auto& stream : streams_) sum += stream->updates();
  return sum;
}

uint64_t WatchCrowd::restarts() const {
  uint64_t sum = 0;
  for (const auto& stream : streams_) sum += stream->restarts();
  return sum;
}

}  // namespace latticed::testing
