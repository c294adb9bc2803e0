// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A Watch stream that reads when it is told to, and ends with its scope.
#ifndef LATTICED_TESTS_SERVER_WATCH_CLIENT_H_
#define LATTICED_TESTS_SERVER_WATCH_CLIENT_H_

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "tests/server/stream_support.h"

namespace latticed::testing {

class WatchClient {
 public:
  WatchClient(v1::SceneService::Stub& stub, const v1::WatchRequest& request) {
    context_.set_deadline(std::chrono::system_clock::now() + kStreamDeadline);
    reader_ = stub.Watch(&context_, request);
  }
  ~WatchClient() {
    context_.TryCancel();
    (void)Finish();
  }

  // Fails the test when the stream ends before.
  void ReadUntil(const std::function<bool()>& done) {
    while (!done()) {
      v1::SceneEvent event;
      ASSERT_TRUE(reader_->Read(&event)) << "the stream ended";
      log.Take(event);
    }
  }
  void ReadUpdates(size_t count) {
    ReadUntil([&] { return log.ends.size() >= count; });
  }
  // Reads to the end.
  grpc::Status Finish() {
    if (!status_.has_value()) {
      v1::SceneEvent event;
      while (reader_->Read(&event)) log.Take(event);
      status_ = reader_->Finish();
    }
    return *status_;
  }

  EventLog log;

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::SceneEvent>> reader_;
  std::optional<grpc::Status> status_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_WATCH_CLIENT_H_
