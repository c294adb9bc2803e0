// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/telemetry.h"

#include <spdlog/formatter.h>
#include <spdlog/sinks/stdout_sinks.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "absl/strings/str_split.h"
#include "absl/time/time.h"
#include "fmt/format.h"

namespace latticed {
namespace {

constexpr char kLogger[] = "latticed";
// Between message, field names and values; PackEvent replaces it inside of them.
constexpr char kSeparator = '\x1f';

// Control characters in a value could forge lines.
std::string Printable(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (static_cast<unsigned char>(c) < ' ') c = ' ';
  }
  return result;
}

std::string QuotedWhereNeeded(const std::string& value) {
  const bool plain = value.find_first_of(" =\"") == std::string::npos;
  return plain
             ? value
             : nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

class EventFormatter final : public spdlog::formatter {
 public:
  explicit EventFormatter(std::string format) : format_(std::move(format)) {}

  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const std::string time = absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ",
                                              absl::FromChrono(message.time), absl::UTCTimeZone());
    const auto level = spdlog::level::to_string_view(message.level);
    const std::string line = FormatEvent(format_, time, {level.data(), level.size()},
                                         {message.payload.data(), message.payload.size()}) +
                             "\n";
    out.append(line.data(), line.data() + line.size());
  }

  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<EventFormatter>(format_);
  }

 private:
  std::string format_;
};

}  // namespace

void ConfigureLogging(std::string_view level, std::string_view format) {
  auto logger =
      std::make_shared<spdlog::logger>(kLogger, std::make_shared<spdlog::sinks::stderr_sink_mt>());
  logger->set_formatter(std::make_unique<EventFormatter>(std::string(format)));
  logger->set_level(spdlog::level::from_str(std::string(level)));
  logger->flush_on(spdlog::level::info);
  spdlog::set_default_logger(std::move(logger));
}

std::string PackEvent(std::string_view message, std::initializer_list<LogField> fields) {
  std::string payload = Printable(message);
  for (const auto& [name, value] : fields) {
    if (!value.empty()) payload += fmt::format("{0}{1}{0}{2}", kSeparator, name, Printable(value));
  }
  return payload;
}

void LogEvent(spdlog::level::level_enum level, std::string_view message,
              std::initializer_list<LogField> fields) {
  const std::shared_ptr<spdlog::logger> logger = spdlog::get(kLogger);
  if (logger == nullptr || !logger->should_log(level)) return;
  logger->log(level, "{}", PackEvent(message, fields));
}

std::string FormatEvent(std::string_view format, std::string_view time, std::string_view level,
                        std::string_view payload) {
  const std::string text(payload);
  const std::vector<std::string> parts = absl::StrSplit(text, kSeparator);
  if (format == "json") {
    nlohmann::ordered_json line = {{"time", time}, {"level", level}, {"message", parts[0]}};
    for (size_t i = 1; i + 1 < parts.size(); i += 2) line[parts[i]] = parts[i + 1];
    return line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  }
  std::string line = fmt::format("{} {:<7} {}", time, level, parts[0]);
  for (size_t i = 1; i + 1 < parts.size(); i += 2) {
    line += fmt::format(" {}={}", parts[i], QuotedWhereNeeded(parts[i + 1]));
  }
  return line;
}

}  // namespace latticed
