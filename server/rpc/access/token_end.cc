// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/access/token_end.h"

#include <utility>

#include "core/base/error.h"
#include "server/rpc/scene_stream.h"

namespace latticed {
namespace {

absl::Status TokenEnded() { return error::Unauthenticated("the token has expired ('exp')"); }

}  // namespace

absl::Status CheckTokenTime(const Caller& caller, absl::Time now) {
  return now < caller.expires ? absl::OkStatus() : TokenEnded();
}

void TokenEnd::EndWith(const Caller& caller, std::weak_ptr<SceneStream> stream) {
  if (caller.expires == absl::InfiniteFuture()) return;
  alarm_.Set(absl::ToChronoTime(caller.expires), [stream = std::move(stream)](bool expired) {
    if (!expired) return;  // the call has ended
    if (const auto open = stream.lock(); open != nullptr) open->Fail(TokenEnded());
  });
}

}  // namespace latticed
