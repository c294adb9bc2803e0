// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/access/token_end.h"

#include "core/base/error.h"
#include "server/rpc/scene_stream.h"

namespace latticed {
namespace {

absl::Status EndOf(const Caller& caller) {
  return caller.shared.has_value() ? ShareEnded()
                                   : error::Unauthenticated("the token has expired ('exp')");
}

}  // namespace

absl::Status CheckTokenTime(const Caller& caller, absl::Time now) {
  const bool ended = caller.shared.has_value() && caller.shared->ended.stop_requested();
  return ended || now >= caller.expires ? EndOf(caller) : absl::OkStatus();
}

void TokenEnd::EndWith(const Caller& caller, const std::weak_ptr<SceneStream>& stream) {
  const auto end = [stream, status = EndOf(caller)] {
    const auto open = stream.lock();
    if (open == nullptr) return;
    const absl::Status deleted = open->scene().ended();
    open->Fail(deleted.ok() ? status : deleted);
  };
  if (caller.shared.has_value()) share_end_.emplace(caller.shared->ended, end);
  if (caller.expires == absl::InfiniteFuture()) return;
  alarm_.Set(absl::ToChronoTime(caller.expires), [end](bool expired) {
    if (expired) end();  // else the call has ended
  });
}

}  // namespace latticed
