// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One call of an rpc whose requests are bytes, and the ids that answers contain. Ids are random, so inputs write a
// placeholder, and the value of the last answer takes its place:
//
//   "@mesh" "@upload" "@watch" "@resume" "@topology" "@page" "@points"
//
// A call fails the fuzzer by an answer that its rpc does not have, and by the status INTERNAL or UNKNOWN.
//
// Threads  one; Strand::Post from any
#ifndef LATTICED_TESTS_FUZZ_FUZZ_CALL_H_
#define LATTICED_TESTS_FUZZ_FUZZ_CALL_H_

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "google/protobuf/descriptor.h"
#include "google/protobuf/message.h"
#include "server/web/generic_call.h"

namespace latticed::fuzz {

// Work that calls bring, run by the fuzzer's thread.
class Strand {
 public:
  void Post(std::function<void()> work) ABSL_LOCKS_EXCLUDED(mutex_);
  // Waits for work and runs it. Returns false if none comes within `patience`.
  bool RunOne(absl::Duration patience) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  Mutex mutex_;
  std::deque<std::function<void()>> work_ ABSL_GUARDED_BY(mutex_);
};

using KnownIds = std::map<std::string, std::string>;  // by placeholder

[[nodiscard]] std::unique_ptr<google::protobuf::Message> NewMessage(
    const google::protobuf::Descriptor* type);

class FuzzCall final : public web::CallObserver, public std::enable_shared_from_this<FuzzCall> {
 public:
  // `method`, `strand` and `ids` outlive the call.
  FuzzCall(const google::protobuf::MethodDescriptor* method, Strand* strand, KnownIds* ids)
      : method_(method), strand_(strand), ids_(ids) {}

  void Start(const web::ServerChannel& server);
  void Send(std::string_view message);
  void HalfClose();
  void Cancel() { call_->Cancel(); }
  bool ended() const { return ended_; }
  // The surface is complete: a watch has nothing more to send.
  bool updated() const { return updated_; }

  void Post(std::function<void()> work) override { strand_->Post(std::move(work)); }
  void OnHead(web::CallMetadata /*metadata*/) override {}
  void OnMessage(grpc::ByteBuffer bytes) override;
  void OnWritten() override;
  void OnEnd(grpc::Status status, web::CallMetadata trailers) override;

 private:
  void SendNext();

  const google::protobuf::MethodDescriptor* const method_;
  Strand* const strand_;
  KnownIds* const ids_;
  std::shared_ptr<web::GenericCall> call_;
  std::deque<std::string> messages_;  // to be sent
  bool writing_ = false, closing_ = false, closed_ = false, ended_ = false, updated_ = false;
};

}  // namespace latticed::fuzz

#endif  // LATTICED_TESTS_FUZZ_FUZZ_CALL_H_
