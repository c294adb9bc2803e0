// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Shares of scenes. Each has a token, with which whoever has it may use one scene, until the share expires or is revoked.
//
//   token   share-<id>-<64 hex digits>   the digits are random; only the SHA-256 of the token is kept
//   id      the Unix time in seconds and 32 random bits, 8 hex digits each
//
// A share belongs to a scene as it was made: a scene that is made later with the same id is not shared.
//
// What is done here counts at once. Where servers share a store, each reads the others' shares in Tend. A token that is
// younger than the last reading may be that of a share that this server does not know yet: its caller is told to try
// again.
//
// Errors   the store's
// Threads  safe; no lock is held while the store is waited for
#ifndef LATTICED_SERVER_STORES_SHARE_STORE_H_
#define LATTICED_SERVER_STORES_SHARE_STORE_H_

#include <cstdint>
#include <map>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "server/base/auth/caller.h"
#include "server/store/store.h"

namespace latticed {

struct Share {
  std::string id;
  std::string scene;             // its key: server/base/auth/tenant.h
  absl::Time scene_create_time;  // which scene of that key
  std::string mesh;              // the key of its mesh
  Role role = Role::kRead;
  std::string creator;  // a caller's name; may be empty
  absl::Time create_time, expire_time;
  std::string token_hash;  // hex
};

class ShareStore {
 public:
  // `store` may be null; else it outlives this.
  explicit ShareStore(Store* store) : store_(store) {}

  [[nodiscard]] static bool IsToken(std::string_view token);

  struct Made {
    Share share;
    std::string token;
  };
  // Sets id, create_time and token_hash of `share`. kResourceExhausted, reason LIMIT_EXCEEDED; kNotFound: the store has no
  // such scene.
  [[nodiscard]] absl::StatusOr<Made> Create(Share share, absl::Time now)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // kNotFound.
  [[nodiscard]] absl::Status Revoke(std::string_view scene, std::string_view id)
      ABSL_LOCKS_EXCLUDED(mutex_);
  // Oldest first.
  [[nodiscard]] std::vector<Share> Of(std::string_view scene) const ABSL_LOCKS_EXCLUDED(mutex_);
  // Who calls with `token`, of which IsToken is true. kUnauthenticated; kUnavailable: nobody knows yet.
  [[nodiscard]] absl::StatusOr<Caller> CallerOf(std::string_view token, absl::Time now) const
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Ends the shares of a scene that was deleted. The store has deleted their rows with the scene's.
  void DropScene(std::string_view scene) ABSL_LOCKS_EXCLUDED(mutex_);
  // Reads what the store has. Shares that are damaged are logged and left out.
  [[nodiscard]] absl::Status Read(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);
  // Deletes shares that have expired, and reads what other servers did. What fails is tried again by the next call, about
  // a second later.
  void Tend(absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  struct Entry {
    Share share;
    std::stop_source end;  // of the streams that the share opened
  };
  using Entries = std::map<std::string, Entry, std::less<>>;

  bool shared() const { return store_ != nullptr && store_->shared(); }
  // This server has made, revoked or dropped the share: what was read of it just now may be older.
  void NoteChange(std::string_view id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Logs those that it has not logged before.
  void LogDamage(const std::map<std::string, absl::Status>& damaged) ABSL_LOCKS_EXCLUDED(mutex_);
  // Takes over what the store has. Returns the ends of the shares that it has not.
  std::vector<std::stop_source> Replace(Entries read, absl::Time now) ABSL_LOCKS_EXCLUDED(mutex_);

  Store* const store_;
  mutable Mutex mutex_;
  Entries entries_ ABSL_GUARDED_BY(mutex_);  // by id
  // Ids of NoteChange since Read began.
  std::set<std::string, std::less<>> changed_ ABSL_GUARDED_BY(mutex_);
  std::set<std::string, std::less<>> damaged_ ABSL_GUARDED_BY(mutex_);
  std::string mark_ ABSL_GUARDED_BY(mutex_);  // of the last reading
  absl::Time read_time_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
};

}  // namespace latticed

#endif  // LATTICED_SERVER_STORES_SHARE_STORE_H_
