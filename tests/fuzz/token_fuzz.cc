// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What says who calls. The first byte chooses what the rest is:
//
//   T  a token as a stranger sends it: nobody is admitted by it; and where a share's token has another byte
//   S  where a signed token has another byte, 16 bits, and that byte: nobody is admitted by it
//   C  the header and the claims of a JSON web token, with an end of line between them, which are then signed: it is refused,
//      or its caller is as jwt_verifier.h says
//   K  a set of keys (JWKS): it is refused, or verifies no token of others
//   F  a token file: it is refused, or admits no token that it does not name
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/time/clock.h"
#include "core/base/sha256.h"
#include "server/base/auth/authenticator.h"
#include "server/base/auth/json_web_keys.h"
#include "server/base/auth/jwt_verifier.h"
#include "server/base/auth/tenant.h"
#include "server/stores/share_store.h"
#include "tests/server/access/token_maker.h"

namespace {

using latticed::Caller;
using latticed::JsonWebKeys;
using latticed::testing::TokenMaker;

struct Server {
  TokenMaker rsa{"RS256", "rsa"}, ec{"ES256", "ec"};
  JsonWebKeys keys = *JsonWebKeys::FromText(latticed::testing::KeySet({rsa.Jwk(), ec.Jwk()}));
  latticed::JwtVerifier verifier{keys, "https://id.example", "latticed"};
  latticed::ShareStore shares{nullptr};
  absl::Time now = absl::Now();
  std::string share_token =
      shares.Create({.scene = "acme/cow", .expire_time = absl::InfiniteFuture()}, now)->token;
  std::string signed_token = ec.Sign(latticed::testing::GoodClaims(now + absl::Hours(1)));
};
Server& TheServer() {
  static auto* const server = new Server;
  return *server;
}

void Require(bool holds) {
  if (!holds) std::abort();
}

void TryToken(const Server& server, const std::string& token) {
  (void)latticed::BearerToken(token);
  Require(!server.verifier.CallerOf(token, server.now).ok());
  if (!latticed::ShareStore::IsToken(token)) return;
  Require(!server.shares.CallerOf(token, server.now).ok() || token == server.share_token);
}

// A token of this server, with a byte changed where the stranger says.
void TryForgery(const Server& server, std::string token, const std::string& at) {
  if (at.size() < 3) return;
  const auto byte = [&](size_t i) { return static_cast<uint8_t>(at[i]); };
  char& changed = token[(byte(0) + 256u * byte(1)) % token.size()];
  if (changed == at[2]) return;
  changed = at[2];
  TryToken(server, token);
}

void TryClaims(const Server& server, const std::string& text) {
  const size_t end = std::min(text.find('\n'), text.size());
  const std::string claims = end == text.size() ? "" : text.substr(end + 1);
  const auto caller =
      server.verifier.CallerOf(server.ec.SignText(text.substr(0, end), claims), server.now);
  if (!caller.ok()) return;
  Require(!caller->name.empty() && caller->name.size() <= 255);
  Require(std::ranges::none_of(caller->name, [](char c) { return c >= 0 && c < ' '; }));
  Require(caller->tenant.empty() || latticed::IsTenantName(caller->tenant));
  Require(!caller->shared.has_value());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const Server& server = TheServer();
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0]) {
    case 'T':
      TryToken(server, text);
      TryForgery(server, server.share_token, text);
      break;
    case 'S':
      TryForgery(server, server.signed_token, text);
      break;
    case 'C':
      TryClaims(server, text);
      break;
    case 'K':
      if (const auto keys = JsonWebKeys::FromText(text); keys.ok()) {
        Require(!keys->Verify(server.signed_token).ok());
      }
      break;
    case 'F':
      if (const auto tokens = latticed::Authenticator::FromText(text); tokens.ok()) {
        // The fuzzer sees what is compared, so it finds out the hash of a token and writes it down.
        const std::string hash = latticed::Sha256Hex(server.signed_token);
        const bool is_named = absl::AsciiStrToLower(text).find(hash) != std::string::npos;
        Require(!tokens->Authenticate("Bearer " + server.signed_token, server.now).ok() ||
                is_named);
      }
      break;
    default:
      break;
  }
  return 0;
}
