// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/audit_log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "absl/time/clock.h"
#include "fmt/format.h"
#include "server/base/telemetry.h"

namespace latticed {
namespace {

std::string TimeText(absl::Time time) {
  return absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ", time, absl::UTCTimeZone());
}

}  // namespace

AuditLog::~AuditLog() {
  WriteEditsBefore(absl::InfiniteFuture());
  const MutexLock lock(&mutex_);
  if (file_ >= 0) close(file_);
}

absl::Status AuditLog::Open() {
  if (path_.empty()) return absl::OkStatus();
  // Does not wait for the reader of a pipe.
  const int opened = open(path_.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK,
                          S_IRUSR | S_IWUSR);
  if (opened < 0) {
    return absl::InvalidArgumentError(
        fmt::format("--audit-log: {}: {}", path_, std::strerror(errno)));
  }
  const MutexLock lock(&mutex_);
  if (file_ >= 0) close(file_);
  file_ = opened;
  return absl::OkStatus();
}

void AuditLog::Note(const char* event, const AuditActor& actor, const AuditFields& fields,
                    absl::Time now) {
  const MutexLock lock(&mutex_);
  if (file_ >= 0) Write(event, actor, fields, now);
}

void AuditLog::NoteEdit(const AuditActor& actor, const std::string& scene, absl::Time now) {
  const MutexLock lock(&mutex_);
  if (file_ < 0) return;
  Edits& edits = edits_[{actor.tenant, scene, actor.caller}];
  if (edits.count++ == 0) {
    edits.actor = actor;
    edits.first = now;
  }
  edits.last = now;
}

void AuditLog::WriteEditsBefore(absl::Time time) {
  const MutexLock lock(&mutex_);
  for (auto at = edits_.begin(); at != edits_.end();) {
    const auto& [editor, edits] = *at;
    if (edits.last >= time) {
      ++at;
      continue;
    }
    Write("scene_edited", edits.actor,
          {{"scene", std::get<1>(editor)},
           {"edits", fmt::to_string(edits.count)},
           {"first", TimeText(edits.first)},
           {"last", TimeText(edits.last)}},
          absl::Now());
    at = edits_.erase(at);
  }
}

void AuditLog::Write(const char* event, const AuditActor& actor, const AuditFields& fields,
                     absl::Time now) {
  nlohmann::ordered_json line{{"time", TimeText(now)},
                              {"event", event},
                              {"tenant", actor.tenant},
                              {"caller", actor.caller},
                              {"peer", actor.peer}};
  for (const auto& [name, value] : fields) line[name] = value;
  line["request_id"] = actor.request_id;
  // Names come from tokens and clients: what is no UTF-8 is replaced.
  const std::string text =
      line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  if (write(file_, text.data(), text.size()) == static_cast<ssize_t>(text.size())) return;
  LogEvent(spdlog::level::err, "a line of the audit log was lost",
           {{"file", path_}, {"error", std::strerror(errno)}});
}

}  // namespace latticed
