// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "latticed/v1/backup.grpc.pb.h"
#include "server/base/version.h"
#include "server/rpc/backup/backup_source.h"
#include "server/rpc/backup/restore_stream.h"
#include "server/rpc/method.h"
#include "server/rpc/server_env.h"
#include "server/rpc/services.h"
#include "server/stores/callers.h"

namespace latticed {
namespace {

using BackupContext = grpc::CallbackServerContext;

// A start, the items with their data, an end.
class BackupParts {
 public:
  explicit BackupParts(BackupSource source) : source_(std::move(source)) {}

  absl::StatusOr<std::optional<v1::BackupPart>> Next() {
    if (is_ended_) return std::nullopt;
    v1::BackupPart part;
    if (parts_ == 0) {
      part.mutable_start()->set_format(kBackupFormat);
      part.mutable_start()->set_server_version(std::string(Version()));
    } else if (sent_ < header().size() + content().size()) {
      TakeData(*part.mutable_data());
    } else {
      LATTICED_RETURN_IF_ERROR(TakeItem(part));
    }
    ++parts_;
    return part;
  }

 private:
  std::string_view header() const { return copy_.header; }
  std::string_view content() const {
    return copy_.content == nullptr ? std::string_view() : std::string_view(*copy_.content);
  }

  // Of the header and the content together.
  void TakeData(std::string& data) {
    const size_t in_header = std::min(sent_, header().size());
    data = header().substr(in_header, limits::kMaxPartBytes);
    const size_t in_content = sent_ - in_header;
    data += content().substr(in_content, limits::kMaxPartBytes - data.size());
    sent_ += data.size();
  }

  absl::Status TakeItem(v1::BackupPart& part) {
    copy_ = {};  // its memory is free before the next one's is taken
    sent_ = 0;
    LATTICED_ASSIGN_OR_RETURN(auto next, source_.Next());
    if (next.has_value()) {
      copy_ = *std::move(next);
      *part.mutable_item() = copy_.item;
    } else {
      part.mutable_end()->set_parts(parts_);
      is_ended_ = true;
    }
    return absl::OkStatus();
  }

  BackupSource source_;
  BackupCopy copy_;
  size_t sent_ = 0;  // bytes of copy_
  uint64_t parts_ = 0;
  bool is_ended_ = false;
};

absl::StatusOr<NextPart<v1::BackupPart>> OpenBackup(const CallContext& context,
                                                    const v1::BackupRequest& request) {
  BackupSource source(&context.env, context.call.caller.tenant, context.call.account->memory);
  LATTICED_RETURN_IF_ERROR(source.Open({request.scenes().begin(), request.scenes().end()}));
  return [parts = std::make_shared<BackupParts>(std::move(source))] { return parts->Next(); };
}

// Every rpc of the service: name, role, handler.
constexpr PartMethod kBackup{Rpc{"BackupService/Backup", Role::kRead}, OpenBackup, Parts::kRead,
                             Lane::kLong};
constexpr Rpc kRestore{"BackupService/Restore", Role::kEdit};

// Every rpc takes and gives bytes (server/wire/message_bytes.h).
using B = v1::BackupService;
using BackupServiceBase =
    B::WithRawCallbackMethod_Backup<B::WithRawCallbackMethod_Restore<B::Service>>;

class BackupServiceImpl final : public BackupServiceBase {
 public:
  explicit BackupServiceImpl(ServerEnv* env) : env_(env) {}

  grpc::ServerWriteReactor<grpc::ByteBuffer>* Backup(BackupContext* context,
                                                     const grpc::ByteBuffer* request) override {
    return kBackup.Run(env_, context, request);
  }
  grpc::ServerReadReactor<grpc::ByteBuffer>* Restore(BackupContext* context,
                                                     grpc::ByteBuffer* reply) override {
    return NewRestoreStream(kRestore, env_, context, reply);
  }

 private:
  ServerEnv* const env_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeBackupService(ServerEnv* env) {
  return std::make_unique<BackupServiceImpl>(env);
}

}  // namespace latticed
