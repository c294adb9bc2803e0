// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/telemetry.h"

#include <spdlog/sinks/stdout_sinks.h>

#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>

#include "fmt/format.h"

namespace latticed {
namespace {

constexpr char kLogger[] = "latticed";
constexpr char kText[] = "text";
constexpr char kJson[] = "json";
// spdlog's patterns: time in UTC, level, and %v, the event. In JSON, %v is the rest of the object.
constexpr char kTextPattern[] = "%Y-%m-%dT%H:%M:%S.%eZ %-7l %v";
constexpr char kJsonPattern[] = R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l",%v)";

std::atomic<bool> log_is_json = false;  // the format of the process-wide logger

// Replaces control characters by spaces: in a value they could forge log lines.
std::string Printable(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return result;
}

std::string ToJson(const nlohmann::ordered_json& value) {
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string QuotedWhereNeeded(const std::string& value) {
  return value.find_first_of(" =\"") == std::string::npos ? value : ToJson(value);
}

}  // namespace

void ConfigureLogging(std::string_view level, std::string_view format) {
  auto logger =
      std::make_shared<spdlog::logger>(kLogger, std::make_shared<spdlog::sinks::stderr_sink_mt>());
  log_is_json = format == kJson;
  logger->set_pattern(log_is_json ? kJsonPattern : kTextPattern, spdlog::pattern_time_type::utc);
  logger->set_level(spdlog::level::from_str(std::string(level)));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

void LogEvent(spdlog::level::level_enum level, std::string_view message,
              std::initializer_list<LogField> fields) {
  const std::shared_ptr<spdlog::logger> logger = spdlog::get(kLogger);
  if (logger == nullptr || !logger->should_log(level)) return;
  logger->log(level, "{}", FormatEvent(log_is_json ? kJson : kText, message, fields));
}

std::string FormatEvent(std::string_view format, std::string_view message,
                        std::initializer_list<LogField> fields) {
  const bool is_json = format == kJson;
  std::string text = Printable(message);
  nlohmann::ordered_json object = {{"message", text}};
  for (const auto& [name, value] : fields) {
    if (value.empty()) continue;
    std::string printable = Printable(value);
    if (is_json) {
      object[std::string(name)] = std::move(printable);
    } else {
      text += fmt::format(" {}={}", name, QuotedWhereNeeded(printable));
    }
  }
  return is_json ? ToJson(object).substr(1) : text;
}

}  // namespace latticed
