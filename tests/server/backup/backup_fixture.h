// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Backups and restores through the real stub, as parts in memory.
#ifndef LATTICED_TESTS_SERVER_BACKUP_BACKUP_FIXTURE_H_
#define LATTICED_TESTS_SERVER_BACKUP_BACKUP_FIXTURE_H_

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/sha256.h"
#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "latticed/v1/backup.grpc.pb.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {

using BackupParts = std::vector<v1::BackupPart>;

// An item with all of its data.
struct BackedUp {
  v1::BackupItem item;
  std::string data;

  std::string header() const { return data.substr(0, item.header_bytes()); }
  std::string content() const { return data.substr(item.header_bytes()); }
};

inline std::vector<BackedUp> ItemsOf(const BackupParts& parts) {
  std::vector<BackedUp> items;
  for (const v1::BackupPart& part : parts) {
    if (part.has_item()) items.push_back({part.item(), ""});
    if (part.has_data()) items.back().data += part.data();
  }
  return items;
}

// With the sizes and the checksum that fit, as an attacker makes them too.
inline void Fit(BackedUp& of) {
  of.item.set_content_bytes(of.data.size() - of.item.header_bytes());
  const std::string zero(1, '\0');
  const std::string& id = of.item.has_mesh() ? of.item.mesh() : of.item.scene();
  of.item.set_sha256(Sha256Hex(id + zero + fmt::to_string(of.item.records()) + zero + of.data));
}

inline BackupParts PartsOf(const std::vector<BackedUp>& items) {
  BackupParts parts(1);
  parts[0].mutable_start()->set_format(1);
  for (const BackedUp& of : items) {
    *parts.emplace_back().mutable_item() = of.item;
    constexpr size_t kPartBytes = 100'000;
    for (size_t at = 0; at < of.data.size(); at += kPartBytes) {
      parts.emplace_back().set_data(of.data.substr(at, kPartBytes));
    }
  }
  const uint64_t before = parts.size();
  parts.emplace_back().mutable_end()->set_parts(before);
  return parts;
}

class BackupFixture : public SceneFixture {
 protected:
  std::unique_ptr<v1::BackupService::Stub> Backups() const {
    return v1::BackupService::NewStub(server_->channel());
  }
  absl::StatusOr<BackupParts> Backup(const std::vector<std::string>& scenes = {},
                                     const Metadata& metadata = {}) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    for (const auto& [name, value] : metadata) context.AddMetadata(name, value);
    v1::BackupRequest request;
    request.mutable_scenes()->Add(scenes.begin(), scenes.end());
    const auto stub = Backups();
    const auto reader = stub->Backup(&context, request);
    BackupParts parts;
    v1::BackupPart part;
    while (reader->Read(&part)) parts.push_back(part);
    const absl::Status status = client::FromGrpc(reader->Finish());
    if (!status.ok()) return status;
    return parts;
  }
  absl::StatusOr<v1::RestoreResponse> Restore(const BackupParts& parts, bool skip_existing = false,
                                              const Metadata& metadata = {}) {
    grpc::ClientContext context;
    context.set_deadline(std::chrono::system_clock::now() + std::chrono::minutes(1));
    for (const auto& [name, value] : metadata) context.AddMetadata(name, value);
    v1::RestoreResponse response;
    const auto stub = Backups();
    const auto writer = stub->Restore(&context, &response);
    v1::RestoreRequest request;
    request.mutable_options()->set_skip_existing(skip_existing);
    bool open = writer->Write(request);
    for (const v1::BackupPart& part : parts) {
      if (!open) break;
      *request.mutable_part() = part;
      open = writer->Write(request);
    }
    writer->WritesDone();
    const absl::Status status = client::FromGrpc(writer->Finish());
    if (!status.ok()) return status;
    return response;
  }
  // Starts a server with nothing in it on `store`, which may be null.
  void StartEmpty(const std::shared_ptr<Store>& store, Options options = {}) {
    server_.reset();
    StartServerOn(MakeCpuBackend({.threads = 1}), std::move(options), store);
  }
  v1::EditBatch RedoMine(const std::string& editor, uint64_t sequence) {
    v1::EditBatch batch = UndoMine(editor, sequence);
    batch.mutable_edits(0)->mutable_redo();
    return batch;
  }
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_BACKUP_BACKUP_FIXTURE_H_
