// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The rpcs of latticed_client.h that copy meshes and scenes out of a server and into another.
#include <functional>
#include <optional>
#include <stop_token>
#include <utility>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/retries/with_retries.h"
#include "client/cpp/library/status.h"
#include "core/base/status_macros.h"

namespace latticed::client {

absl::Status Client::Backup(const v1::BackupRequest& request,
                            const std::function<absl::Status()>& begin,
                            const std::function<absl::Status(const v1::BackupPart&)>& take) {
  absl::Status own;  // of the caller's functions: no other attempt would mend it
  const absl::Status status =
      WithRetries(reachability_.get(), *channel_, stop_, [&]() -> absl::Status {
        own = begin();
        if (!own.ok()) return absl::OkStatus();
        const auto context = NewContext();
        const std::stop_callback cancel(stop_, [&context] { context->TryCancel(); });
        const auto reader = backups_->Backup(context.get(), request);
        v1::BackupPart part;
        bool has_end = false;
        while (reader->Read(&part)) {
          has_end = part.has_end();
          own = take(part);
          if (!own.ok()) {
            context->TryCancel();
            (void)reader->Finish();
            return absl::OkStatus();
          }
        }
        LATTICED_RETURN_IF_ERROR(FromGrpc(reader->Finish(), *context));
        return has_end ? absl::OkStatus() : absl::DataLossError("the server sent less than all");
      });
  return own.ok() ? status : own;
}

absl::StatusOr<v1::RestoreResponse> Client::Restore(
    const v1::RestoreOptions& options,
    const std::function<absl::StatusOr<std::optional<v1::BackupPart>>()>& next) {
  LATTICED_RETURN_IF_ERROR(GetServerInfo().status());
  const auto context = NewContext();
  const std::stop_callback cancel(stop_, [&context] { context->TryCancel(); });
  v1::RestoreResponse response;
  const auto writer = backups_->Restore(context.get(), &response);
  v1::RestoreRequest request;
  *request.mutable_options() = options;
  bool open = writer->Write(request);
  while (open) {
    auto part = next();
    if (!part.ok()) {
      context->TryCancel();
      (void)writer->Finish();
      return part.status();
    }
    if (!part->has_value()) break;
    *request.mutable_part() = **std::move(part);
    open = writer->Write(request);
  }
  if (open) writer->WritesDone();
  LATTICED_RETURN_IF_ERROR(FromGrpc(writer->Finish(), *context));
  return response;
}

}  // namespace latticed::client
