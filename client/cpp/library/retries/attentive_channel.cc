// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/retries/attentive_channel.h"

#include <chrono>
#include <stop_token>
#include <utility>

namespace latticed::client {
namespace {

// Longer than the 0.6 s between two heartbeats.
constexpr int kSilentMs = 800;
constexpr int kAnswerMs = 700;
// The watch notices so late that it is stopped.
constexpr auto kWatchSlice = std::chrono::milliseconds(100);

}  // namespace

grpc::ChannelArguments Patient(grpc::ChannelArguments arguments) {
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  return arguments;
}

grpc::ChannelArguments Attentive(grpc::ChannelArguments arguments) {
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kSilentMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kAnswerMs);
  // Where heartbeats are rarer than by default, pings go on: gRPC would stop after two.
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  return arguments;
}

SocketWatch::SocketWatch(std::shared_ptr<grpc::Channel> channel)
    : thread_([channel = std::move(channel)](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          const grpc_connectivity_state state = channel->GetState(/*try_to_connect=*/false);
          (void)channel->WaitForStateChange(state, std::chrono::system_clock::now() + kWatchSlice);
        }
      }) {}

}  // namespace latticed::client
