// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/telemetry.h"

#include <spdlog/async.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <atomic>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include "fmt/format.h"

namespace latticed {
namespace {

constexpr char kLogger[] = "latticed";
constexpr char kText[] = "text";
constexpr char kJson[] = "json";
// spdlog's patterns: time in UTC, level, and %v, the event. In JSON, %v is the rest of the object.
constexpr char kTextPattern[] = "%Y-%m-%dT%H:%M:%S.%eZ %-7l %v";
constexpr char kJsonPattern[] = R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v)";

std::atomic<bool> log_is_json = false;   // the format of the process-wide logger
std::atomic<uint64_t> told_dropped = 0;  // dropped lines that the log has told of

// Once the log's thread writes again, one line tells how many were dropped.
void TellDropped(spdlog::logger& logger) {
  const auto pool = spdlog::thread_pool();
  if (pool == nullptr || pool->queue_size() > kMostLogLines / 2) return;
  const uint64_t dropped = pool->overrun_counter();
  uint64_t before = told_dropped;
  if (before >= dropped || !told_dropped.compare_exchange_strong(before, dropped)) return;
  logger.log(
      spdlog::level::warn, "{}",
      FormatEvent(log_is_json ? kJson : kText, "log lines were dropped: nobody read them in time",
                  {{"lines", fmt::to_string(dropped - before)}}));
}

}  // namespace

void ConfigureLogging(std::string_view level, std::string_view format) {
  if (spdlog::thread_pool() == nullptr) spdlog::init_thread_pool(kMostLogLines, 1);
  auto logger = std::make_shared<spdlog::async_logger>(
      kLogger, std::make_shared<spdlog::sinks::stderr_sink_mt>(), spdlog::thread_pool(),
      spdlog::async_overflow_policy::overrun_oldest);
  log_is_json = format == kJson;
  logger->set_pattern(log_is_json ? kJsonPattern : kTextPattern, spdlog::pattern_time_type::utc);
  logger->set_level(spdlog::level::from_str(std::string(level)));
  spdlog::set_default_logger(std::move(logger));
}

void SetLogLevel(std::string_view level) {
  spdlog::set_level(spdlog::level::from_str(std::string(level)));
}

uint64_t DroppedLogLines() {
  const auto pool = spdlog::thread_pool();
  return pool == nullptr ? 0 : pool->overrun_counter();
}

bool CloseLog(absl::Duration patience) {
  std::packaged_task<void()> close([] { spdlog::shutdown(); });
  std::future<void> closed = close.get_future();
  std::thread(std::move(close)).detach();
  return closed.wait_for(absl::ToChronoMilliseconds(patience)) == std::future_status::ready;
}

void LogEvent(spdlog::level::level_enum level, std::string_view message,
              std::initializer_list<LogField> fields) {
  const std::shared_ptr<spdlog::logger> logger = spdlog::get(kLogger);
  if (logger == nullptr || !logger->should_log(level)) return;
  TellDropped(*logger);
  logger->log(level, "{}", FormatEvent(log_is_json ? kJson : kText, message, fields));
}

}  // namespace latticed
