// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A sink for the server's log that keeps the fields of every line.
#ifndef LATTICED_TESTS_SERVER_SUPPORT_CALL_SINK_H_
#define LATTICED_TESTS_SERVER_SUPPORT_CALL_SINK_H_

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "server/base/telemetry.h"

namespace latticed::testing {

class CallSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  using Line = std::map<std::string, std::string>;

  // Replaces the log's sinks and sets its level to debug. Null before a server has set up the log.
  static std::shared_ptr<CallSink> Install() {
    if (spdlog::get("latticed") == nullptr) return nullptr;
    ConfigureLogging("debug", "json");
    const auto logger = spdlog::get("latticed");
    auto sink = std::make_shared<CallSink>();
    logger->sinks() = {sink};
    return sink;
  }

  // Waits for the log's thread to write what was logged before.
  std::vector<Line> Of(const std::string& request_id) {
    const int before = flushes_;
    spdlog::get("latticed")->flush();
    while (flushes_ == before) std::this_thread::yield();
    const std::lock_guard lock(mutex_);
    std::vector<Line> found;
    for (const Line& line : lines_) {
      const auto id = line.find("latticed-request-id");
      if (id != line.end() && id->second == request_id) found.push_back(line);
    }
    return found;
  }

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    const std::string text(message.payload.data(), message.payload.size());
    lines_.push_back(nlohmann::json::parse("{" + text).get<Line>());
  }
  void flush_() override { ++flushes_; }

 private:
  std::atomic<int> flushes_ = 0;
  std::vector<Line> lines_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_SUPPORT_CALL_SINK_H_
