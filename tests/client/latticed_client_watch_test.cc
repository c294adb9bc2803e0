// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A watch without edits. It acknowledges updates and answers heartbeats by ControlWatch, and opens its
// stream again when it breaks.
#include "client/cpp/library/watch.h"

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "client/cpp/library/latticed_client.h"
#include "core/base/mutex.h"
#include "tests/client/fake_server.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

// Sends the next update when the last one is acknowledged. After its first update, stream number n ends
// with failures[n], or with a goaway whose retry_after is goaways[n] seconds.
class AcknowledgedScenes final : public v1::SceneService::Service {
 public:
  std::map<int, grpc::Status> failures;
  std::map<int, int64_t> goaways;
  std::vector<v1::WatchRequest> opened;
  std::vector<v1::ControlWatchRequest> controls;

  grpc::Status Watch(grpc::ServerContext* context, const v1::WatchRequest* request,
                     grpc::ServerWriter<v1::SceneEvent>* writer) override {
    const MutexLock lock(&mutex_);
    opened.push_back(*request);
    const int number = static_cast<int>(opened.size());
    v1::SceneEvent event;
    event.mutable_hello()->set_watch_id("watch " + std::to_string(number));
    writer->Write(event);
    event.mutable_heartbeat();
    writer->Write(event);
    while (!context->IsCancelled()) {
      SendUpdate(writer);
      const auto acked = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return acked_update_id_ == update_id_;
      };
      while (!context->IsCancelled() && !mutex_.AwaitFor(acked, absl::Milliseconds(20))) {
      }
      if (failures.contains(number)) return failures[number];
      if (!goaways.contains(number)) continue;
      event.mutable_goaway()->mutable_retry_after()->set_seconds(goaways[number]);
      writer->Write(event);
      return grpc::Status::OK;
    }
    return grpc::Status::CANCELLED;
  }

  grpc::Status ControlWatch(grpc::ServerContext*, const v1::ControlWatchRequest* request,
                            v1::ControlWatchResponse*) override {
    const MutexLock lock(&mutex_);
    controls.push_back(*request);
    if (request->has_acked_update_id()) acked_update_id_ = request->acked_update_id();
    return grpc::Status::OK;
  }

 private:
  void SendUpdate(grpc::ServerWriter<v1::SceneEvent>* writer)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    v1::SceneEvent begin, end;
    begin.mutable_update_begin()->set_update_id(++update_id_);
    writer->Write(begin);
    end.mutable_update_end()->set_update_id(update_id_);
    end.mutable_update_end()->set_resume_token("token " + std::to_string(update_id_));
    writer->Write(end);
  }

  Mutex mutex_;
  uint64_t update_id_ ABSL_GUARDED_BY(mutex_) = 0, acked_update_id_ ABSL_GUARDED_BY(mutex_) = 0;
};

class WatchStreamTest : public ::testing::Test {
 protected:
  absl::StatusOr<std::unique_ptr<WatchStream>> Open() {
    v1::WatchRequest watch;
    watch.set_scene("scene-of-this-test");
    return client_->Watch(watch);
  }

  AcknowledgedScenes service_;
  FakeServer server_{&service_};
  const std::unique_ptr<Client> client_ = Client::Connect({.address = server_.address()});
};

TEST_F(WatchStreamTest, AcknowledgesEveryUpdateAndAnswersHeartbeats) {
  {
    const auto watch = Open();
    ASSERT_OK(watch);
    ASSERT_TRUE((*watch)->first_update().has_value());
    EXPECT_EQ((*watch)->hello().watch_id(), "watch 1");
    for (uint64_t id = 2; id <= 4; ++id) {
      const auto update = (*watch)->Next();
      ASSERT_OK(update);
      ASSERT_TRUE(update->has_value());
      EXPECT_EQ((*update)->end.update_id(), id);
    }
  }
  server_.Shutdown();
  ASSERT_GE(service_.controls.size(), 5u);
  EXPECT_FALSE(service_.controls[0].has_acked_update_id());  // the heartbeat
  for (uint64_t i = 1; i < 5; ++i) EXPECT_EQ(service_.controls[i].acked_update_id(), i);
  for (const auto& control : service_.controls) {
    EXPECT_EQ(control.watch_id(), "watch 1");
    EXPECT_EQ(control.scene(), "scene-of-this-test");
  }
}

TEST_F(WatchStreamTest, OpensItselfAgainWithItsTokenAfterBreaksAndAGoaway) {
  service_.failures[1] = grpc::Status(grpc::StatusCode::UNAVAILABLE, "broken");
  service_.goaways[2] = 0;
  {
    const auto watch = Open();
    ASSERT_OK(watch);
    for (int i = 0; i < 2; ++i) {
      const auto update = (*watch)->Next();
      ASSERT_OK(update);
      EXPECT_TRUE(update->has_value());
    }
    EXPECT_EQ((*watch)->reconnections(), 2);
    EXPECT_EQ((*watch)->hello().watch_id(), "watch 3");
  }
  server_.Shutdown();
  ASSERT_EQ(service_.opened.size(), 3u);
  EXPECT_EQ(service_.opened[0].resume_token(), "");
  for (size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(service_.opened[i].resume_token(), "token " + std::to_string(i));
  }
}

TEST_F(WatchStreamTest, CancelEndsItFromAnotherThread) {
  const auto watch = Open();
  ASSERT_OK(watch);
  std::thread cancel([&] { (*watch)->Cancel(); });
  for (;;) {
    const auto update = (*watch)->Next();
    ASSERT_OK(update);
    if (!update->has_value()) break;
  }
  cancel.join();
}

TEST_F(WatchStreamTest, CancelEndsAPauseBetweenTwoStreams) {
  service_.goaways[1] = 3600;
  const auto watch = Open();
  ASSERT_OK(watch);
  std::thread cancel([&] { (*watch)->Cancel(); });
  const auto update = (*watch)->Next();
  ASSERT_OK(update);
  EXPECT_FALSE(update->has_value());
  cancel.join();
}

}  // namespace
}  // namespace latticed::client
