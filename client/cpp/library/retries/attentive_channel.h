// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The channel of streams, which notices within 1.5 s that its server is cut off without a word.
//
//   0.6 s       between heartbeats of the server, also while it sends nothing else
//   0.8 s       without any byte: the channel pings. A busy line, slow as it may be, is not pinged
//   0.7 s more  without an answer: its calls fail, UNAVAILABLE
//
// Other calls have no heartbeats: while a slow line is busy with a large upload, nothing comes back for seconds. They
// have a channel of their own, which notices within 40 s.
//
// gRPC handles a socket's events in threads that wait for calls or for the channel's state, and otherwise every 5 s. While
// nobody reads a stream, a thread waits here, so that what the server sends is seen.
//
// Threads  any
#ifndef LATTICED_CLIENT_CPP_LIBRARY_RETRIES_ATTENTIVE_CHANNEL_H_
#define LATTICED_CLIENT_CPP_LIBRARY_RETRIES_ATTENTIVE_CHANNEL_H_

#include <memory>
#include <thread>

#include "grpcpp/channel.h"
#include "grpcpp/support/channel_arguments.h"

namespace latticed::client {

[[nodiscard]] grpc::ChannelArguments Attentive(grpc::ChannelArguments arguments);
// Of the channel of other calls.
[[nodiscard]] grpc::ChannelArguments Patient(grpc::ChannelArguments arguments);

class SocketWatch {
 public:
  explicit SocketWatch(std::shared_ptr<grpc::Channel> channel);

 private:
  std::jthread thread_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LIBRARY_RETRIES_ATTENTIVE_CHANNEL_H_
