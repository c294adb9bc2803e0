// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The answers that a stream owes its client, in the order of the edits. An answer may be there before those of earlier
// edits, which wait for the store; it then waits for them.
//
// Threads  guarded by its owner
#ifndef LATTICED_SERVER_RPC_DUE_ANSWERS_H_
#define LATTICED_SERVER_RPC_DUE_ANSWERS_H_

#include <grpcpp/support/byte_buffer.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

namespace latticed {

class DueAnswers {
 public:
  // An edit has come. Returns the number of its answer.
  [[nodiscard]] uint64_t Expect() {
    due_.emplace_back();
    return first_ + due_.size() - 1;
  }
  // The answer with that number is there, and names `revision`. A second one with the same number is ignored.
  void Fill(uint64_t number, grpc::ByteBuffer event, uint64_t revision) {
    if (number < first_ || due_[number - first_].event.has_value()) return;
    due_[number - first_] = {std::move(event), revision};
  }
  // The next answer if it is there.
  [[nodiscard]] std::optional<grpc::ByteBuffer> Take() {
    if (due_.empty() || !due_.front().event.has_value()) return std::nullopt;
    auto event = std::move(due_.front().event);
    highest_ = std::max(highest_.value_or(0), due_.front().revision);
    due_.pop_front();
    ++first_;
    return event;
  }
  // Those that were not taken.
  size_t size() const { return due_.size(); }
  // The highest revision in an answer that was taken.
  std::optional<uint64_t> highest_revision() const { return highest_; }

 private:
  struct Due {
    std::optional<grpc::ByteBuffer> event;
    uint64_t revision = 0;
  };

  std::deque<Due> due_;
  uint64_t first_ = 0;  // the number of due_.front()
  std::optional<uint64_t> highest_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_DUE_ANSWERS_H_
