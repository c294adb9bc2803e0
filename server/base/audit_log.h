// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Who did what, as lines of JSON that are appended to --audit-log.
//
//   {"time":"2026-11-27T19:12:23.123Z","event":"scene_created","tenant":"acme","caller":"ada","scene":"cow",
//    "mesh":"9f…","request_id":"4f…"}
//
// Events: mesh_created, mesh_deleted, mesh_restored, scene_created, scene_deleted, scene_edited, scene_restored. A caller's
// edits of a scene are one line, when no more have come for kSilence, or the server ends: with their number, and the time of
// the first and the last.
//
// A line is written by one call, so lines of several servers that share a file do not mix. A line that cannot be written is told
// in the server's log, and the call that it is about goes on.
//
// Threads  safe
#ifndef LATTICED_SERVER_BASE_AUDIT_LOG_H_
#define LATTICED_SERVER_BASE_AUDIT_LOG_H_

#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace latticed {

// Who, and by which call.
struct AuditActor {
  std::string tenant, caller, peer, request_id;
};
// Names and values, in the order of the line.
using AuditFields = std::vector<std::pair<std::string, std::string>>;

class AuditLog {
 public:
  static constexpr absl::Duration kSilence = absl::Minutes(1);

  // Without a path nothing is noted.
  explicit AuditLog(std::string path) : path_(std::move(path)) {}
  ~AuditLog();
  AuditLog(const AuditLog&) = delete;  // it owns a file
  AuditLog& operator=(const AuditLog&) = delete;

  // Opens the file, which is made if it is not there and which only its owner may read; again after it was moved.
  // kInvalidArgument naming it.
  [[nodiscard]] absl::Status Open() ABSL_LOCKS_EXCLUDED(mutex_);
  void Note(const char* event, const AuditActor& actor, const AuditFields& fields, absl::Time now)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // An edit that was applied. `scene` is the scene's id.
  void NoteEdit(const AuditActor& actor, const std::string& scene, absl::Time now)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Writes the lines of edits that nothing has followed since `time`. Called once a second.
  void WriteEditsBefore(absl::Time time) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Edits {
    AuditActor actor;  // of the first one
    uint64_t count = 0;
    absl::Time first, last;
  };
  using Editor = std::tuple<std::string, std::string, std::string>;  // tenant, scene, caller
  void Write(const char* event, const AuditActor& actor, const AuditFields& fields, absl::Time now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string path_;
  Mutex mutex_;
  int file_ ABSL_GUARDED_BY(mutex_) = -1;
  std::map<Editor, Edits> edits_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_AUDIT_LOG_H_
