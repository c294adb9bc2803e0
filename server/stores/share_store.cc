// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/stores/share_store.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/base/auth/tenant.h"
#include "server/base/random_id.h"
#include "server/base/telemetry.h"
#include "server/store/records/scene_log.pb.h"

namespace latticed {
namespace {

constexpr std::string_view kPrefix = "share-";
constexpr size_t kTimeDigits = 8, kIdDigits = 16, kSecretDigits = 64;
constexpr size_t kTokenBytes = kPrefix.size() + kIdDigits + 1 + kSecretDigits;
// By how much the clocks of servers may differ.
constexpr absl::Duration kLeeway = absl::Seconds(5);
constexpr uint32_t kRetryMs = 500;

std::string NewId(absl::Time now) {
  return fmt::format("{:08x}{}", absl::ToUnixSeconds(now),
                     NewRandomId().substr(0, kIdDigits - kTimeDigits));
}

std::string_view IdOfToken(std::string_view token) {
  return token.substr(kPrefix.size(), kIdDigits);
}

absl::Time TimeOfToken(std::string_view token) {
  const std::string_view digits = IdOfToken(token).substr(0, kTimeDigits);
  int64_t seconds = 0;  // where the digits are none, the token is an old one that nobody knows
  constexpr int kHex = 16;
  std::from_chars(digits.data(), digits.data() + digits.size(), seconds, kHex);
  return absl::FromUnixSeconds(seconds);
}

std::string HeaderOf(const Share& share) {
  store::ShareHeader header;
  header.set_scene(share.scene);
  header.set_scene_create_time(absl::ToUnixNanos(share.scene_create_time));
  header.set_role(std::string(RoleName(share.role)));
  header.set_creator(share.creator);
  header.set_create_time(absl::ToUnixNanos(share.create_time));
  header.set_expire_time(absl::ToUnixNanos(share.expire_time));
  header.set_token_hash(share.token_hash);
  header.set_mesh(share.mesh);
  return header.SerializeAsString();
}

absl::StatusOr<Share> ShareFrom(const StoredEntry& entry) {
  LATTICED_RETURN_IF_ERROR(entry.damage);
  store::ShareHeader header;
  if (!header.ParseFromString(entry.header)) return absl::DataLossError("it cannot be read");
  const auto role = RoleFromName(header.role());
  if (!role.has_value()) return absl::DataLossError("it has no role");
  return Share{.id = entry.id,
               .scene = header.scene(),
               .scene_create_time = absl::FromUnixNanos(header.scene_create_time()),
               .mesh = header.mesh(),
               .role = *role,
               .creator = header.creator(),
               .create_time = absl::FromUnixNanos(header.create_time()),
               .expire_time = absl::FromUnixNanos(header.expire_time()),
               .token_hash = header.token_hash()};
}

}  // namespace

bool ShareStore::IsToken(std::string_view token) {
  return token.size() == kTokenBytes && token.starts_with(kPrefix);
}

absl::StatusOr<ShareStore::Made> ShareStore::Create(Share share, absl::Time now) {
  if (Of(share.scene).size() >= limits::kMaxSharesOfScene) {
    return error::LimitExceeded("shares of a scene", limits::kMaxSharesOfScene);
  }
  share.id = NewId(now);
  share.create_time = now;
  const std::string token =
      fmt::format("{}{}-{}{}", kPrefix, share.id, NewRandomId(), NewRandomId());
  share.token_hash = Sha256Hex(token);
  if (store_ != nullptr) {
    LATTICED_RETURN_IF_ERROR(store_->PutShare(share.id, share.scene, HeaderOf(share)));
  }
  const MutexLock lock(&mutex_);
  NoteChange(share.id);
  entries_[share.id].share = share;
  return Made{std::move(share), token};
}

absl::Status ShareStore::Revoke(std::string_view scene, std::string_view id) {
  std::stop_source end;
  {
    const MutexLock lock(&mutex_);
    const auto found = entries_.find(id);
    if (found == entries_.end() || found->second.share.scene != scene) {
      return error::NotFound("share", id);
    }
    end = found->second.end;
  }
  if (store_ != nullptr) LATTICED_RETURN_IF_ERROR(store_->DeleteShare(id));
  {
    const MutexLock lock(&mutex_);
    NoteChange(id);
    entries_.erase(std::string(id));
  }
  end.request_stop();  // ends streams, which have locks of their own
  return absl::OkStatus();
}

std::vector<Share> ShareStore::Of(std::string_view scene) const {
  std::vector<Share> shares;
  const MutexLock lock(&mutex_);
  for (const auto& [id, entry] : entries_) {
    if (entry.share.scene == scene) shares.push_back(entry.share);
  }
  std::ranges::stable_sort(shares, {}, &Share::create_time);
  return shares;
}

absl::StatusOr<Caller> ShareStore::CallerOf(std::string_view token, absl::Time now) const {
  const MutexLock lock(&mutex_);
  const auto found = entries_.find(IdOfToken(token));
  if (found == entries_.end()) {
    const absl::Time made = TimeOfToken(token);
    if (!shared() || made + kLeeway < read_time_ || made > now + kLeeway) return ShareEnded();
    return error::Unavailable("UNAVAILABLE", "this server does not know the share yet", kRetryMs);
  }
  const auto& [share, end] = found->second;
  if (Sha256Hex(token) != share.token_hash || share.expire_time <= now) return ShareEnded();
  return Caller{
      .name = fmt::format("share:{}", share.id),
      .role = share.role,
      .tenant = std::string(TenantOf(share.scene)),
      .expires = share.expire_time,
      .shared = SharedScene{share.scene, share.scene_create_time, share.mesh, end.get_token()}};
}

void ShareStore::DropScene(std::string_view scene) {
  std::vector<std::stop_source> ended;
  {
    const MutexLock lock(&mutex_);
    for (auto entry = entries_.begin(); entry != entries_.end();) {
      const auto here = entry++;
      if (here->second.share.scene != scene) continue;
      NoteChange(here->first);
      ended.push_back(here->second.end);
      entries_.erase(here);
    }
  }
  for (std::stop_source& end : ended) end.request_stop();
}

void ShareStore::NoteChange(std::string_view id) {
  if (shared()) changed_.emplace(id);
}

absl::Status ShareStore::Read(absl::Time now) {
  LATTICED_ASSIGN_OR_RETURN(const std::string mark, store_->SharesMark());
  {
    const MutexLock lock(&mutex_);
    changed_.clear();
    if (!mark.empty() && mark == mark_) {
      read_time_ = now;
      return absl::OkStatus();
    }
  }
  LATTICED_ASSIGN_OR_RETURN(const auto stored, store_->Shares());
  Entries read;
  std::map<std::string, absl::Status> damaged;
  for (const StoredEntry& entry : stored) {
    auto share = ShareFrom(entry);
    if (share.ok()) {
      read[entry.id].share = *std::move(share);
    } else {
      damaged[entry.id] = share.status();
    }
  }
  LogDamage(damaged);
  for (std::stop_source& end : Replace(std::move(read), now)) end.request_stop();
  const MutexLock lock(&mutex_);
  mark_ = mark;
  return absl::OkStatus();
}

void ShareStore::LogDamage(const std::map<std::string, absl::Status>& damaged) {
  const MutexLock lock(&mutex_);
  for (const auto& [id, status] : damaged) {
    if (!damaged_.insert(id).second) continue;
    LogEvent(spdlog::level::err, "damaged in the store",
             {{"share", id}, {"status", status.ToString()}});
  }
}

std::vector<std::stop_source> ShareStore::Replace(Entries read, absl::Time now) {
  std::vector<std::stop_source> ended;
  const MutexLock lock(&mutex_);
  read_time_ = now;
  for (const std::string& id : changed_) read.erase(id);
  for (const auto& [id, entry] : entries_) {
    if (changed_.contains(id)) {
      read[id] = entry;
    } else if (const auto again = read.find(id); again != read.end()) {
      again->second.end = entry.end;
    } else {
      ended.push_back(entry.end);
    }
  }
  entries_ = std::move(read);
  return ended;
}

void ShareStore::Tend(absl::Time now) {
  if (shared()) (void)Read(now);                             // the log tells of a store that fails
  std::vector<std::pair<std::string, std::string>> expired;  // scene, id
  {
    const MutexLock lock(&mutex_);
    for (const auto& [id, entry] : entries_) {
      if (entry.share.expire_time <= now) expired.emplace_back(entry.share.scene, id);
    }
  }
  for (const auto& [scene, id] : expired) (void)Revoke(scene, id);
}

}  // namespace latticed
