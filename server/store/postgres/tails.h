// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The ends of the logs of those scenes that this server owns, as far as it has created or read them. It is how a wrong
// lsn is noticed without asking the database, and how a broken scene takes nothing more.
//
// Threads  one: the writer's
#ifndef LATTICED_SERVER_STORE_POSTGRES_TAILS_H_
#define LATTICED_SERVER_STORE_POSTGRES_TAILS_H_

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace latticed {

struct PgTail {
  int64_t number = 0;  // of the scene's row
  uint64_t lsn = 0;    // of its last record
};

class PgTails {
 public:
  // The scene is sound, and this is its end.
  void Set(std::string_view id, PgTail tail) { scenes_[std::string(id)] = {tail, {}}; }
  void Forget(std::string_view id);
  void Clear() { scenes_.clear(); }

  // Null: this server does not own it, or has not read it.
  const PgTail* Find(std::string_view id) const;
  // Takes record `lsn` as appended. Returns the scene's number. kAborted; kFailedPrecondition, which breaks the scene;
  // what broke the scene.
  [[nodiscard]] absl::StatusOr<int64_t> Append(std::string_view id, uint64_t lsn);
  // What broke the scene, OK if nothing did. kAborted.
  [[nodiscard]] absl::Status CheckSound(std::string_view id) const;
  // It takes nothing more until Set.
  void Break(std::string_view id, const absl::Status& why);

 private:
  struct Scene {
    PgTail tail;
    absl::Status broken;
  };
  std::map<std::string, Scene, std::less<>> scenes_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORE_POSTGRES_TAILS_H_
