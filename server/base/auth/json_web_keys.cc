// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/auth/json_web_keys.h"

#include <cjose/cjose.h>

#include <algorithm>
#include <cstdlib>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using Json = nlohmann::json;

constexpr size_t kLeastRsaBits = 2048;
constexpr size_t kMostAlgorithmBytes = 16;  // of an unknown algorithm, in a message

struct FreeJws {
  void operator()(cjose_jws_t* jws) const { cjose_jws_release(jws); }
};

std::string TextOf(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

// The algorithm of a key that may sign; nullopt for any other.
std::optional<std::string> AlgorithmOf(const Json& key) {
  const std::string type = TextOf(key, "kty"), use = TextOf(key, "use"), named = TextOf(key, "alg");
  std::string algorithm;
  if (type == "RSA") algorithm = "RS256";
  if (type == "EC" && TextOf(key, "crv") == "P-256") algorithm = "ES256";
  if (algorithm.empty() || (!use.empty() && use != "sig")) return std::nullopt;
  if (!named.empty() && named != algorithm) return std::nullopt;
  return algorithm;
}

// The only way to write some bytes (RFC 4648, 5, without padding). cjose ends the program at some texts that are none, and
// takes others.
bool IsBase64Url(std::string_view text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
  if (text.find_first_not_of(kDigits) != std::string_view::npos) return false;
  const size_t last = text.size() % 4;  // digits of the last bytes
  if (last == 0) return true;
  const size_t unused = last == 2 ? 0xF : 0x3;  // bits of the last digit
  return last != 1 && (kDigits.find(text.back()) & unused) == 0;
}

bool IsCompactJws(std::string_view token) {
  const size_t header = token.find('.'), claims = token.rfind('.');
  return header < claims && claims != std::string_view::npos &&
         IsBase64Url(token.substr(0, header)) &&
         IsBase64Url(token.substr(header + 1, claims - header - 1)) &&
         IsBase64Url(token.substr(claims + 1));
}

bool HasReadableNumbers(const Json& key) {
  return std::ranges::all_of(std::initializer_list<const char*>{"n", "e", "x", "y"},
                             [&](const char* name) { return IsBase64Url(TextOf(key, name)); });
}

// A member of a token's header that is a string; empty without one.
std::string HeaderText(cjose_header_t* header, const char* name) {
  const char* value = cjose_header_get(header, name, nullptr);
  return value == nullptr ? "" : value;
}

// A member of any kind.
bool HeaderHas(cjose_header_t* header, const char* name) {
  char* value = cjose_header_get_raw(header, name, nullptr);
  std::free(value);
  return value != nullptr;
}

}  // namespace

absl::StatusOr<JsonWebKeys> JsonWebKeys::FromText(std::string_view text) {
  const Json set = Json::parse(text, nullptr, false);
  const auto listed = set.is_object() ? set.find("keys") : set.end();
  if (!set.is_object() || listed == set.end() || !listed->is_array()) {
    return absl::InvalidArgumentError("is no JSON object with a list 'keys'");
  }
  if (listed->size() > kMostKeys) {
    return absl::InvalidArgumentError(fmt::format("has more than {} keys", kMostKeys));
  }
  JsonWebKeys result;
  for (const Json& key : *listed) {
    if (!key.is_object()) return absl::InvalidArgumentError("has a key that is no object");
    const auto algorithm = AlgorithmOf(key);
    if (!algorithm.has_value()) continue;
    if (key.contains("d")) {
      return absl::InvalidArgumentError("holds a private key, which belongs to who signs only");
    }
    const std::string bytes = key.dump(-1, ' ', false, Json::error_handler_t::replace);
    cjose_err problem{};
    const std::shared_ptr<cjose_jwk_t> made(
        HasReadableNumbers(key) ? cjose_jwk_import(bytes.data(), bytes.size(), &problem) : nullptr,
        cjose_jwk_release);
    if (made == nullptr) {
      return absl::InvalidArgumentError(fmt::format("key '{}' cannot be read", TextOf(key, "kid")));
    }
    if (*algorithm == "RS256" && cjose_jwk_get_keysize(made.get(), nullptr) < kLeastRsaBits) {
      return absl::InvalidArgumentError(
          fmt::format("has an RSA key of less than {} bits", kLeastRsaBits));
    }
    result.keys_.push_back({TextOf(key, "kid"), *algorithm, made});
  }
  if (!result.keys_.empty()) return result;
  return absl::InvalidArgumentError("holds no key for RS256 or ES256");
}

absl::StatusOr<const JsonWebKeys::Key*> JsonWebKeys::Find(std::string_view algorithm,
                                                          std::string_view id) const {
  const Key* found = nullptr;
  for (const Key& key : keys_) {
    if (key.algorithm != algorithm || (!id.empty() && key.id != id)) continue;
    if (found != nullptr) {
      return error::Unauthenticated(
          "the token names no key ('kid'), and several could have signed");
    }
    found = &key;
  }
  if (found != nullptr) return found;
  return error::Unauthenticated("the token's key ('kid') is not known to this server");
}

absl::StatusOr<std::string> JsonWebKeys::Verify(std::string_view token) const {
  if (token.size() > kMostTokenBytes) {
    return error::Unauthenticated(
        fmt::format("the token has {} bytes, allowed are {}", token.size(), kMostTokenBytes));
  }
  const std::unique_ptr<cjose_jws_t, FreeJws> jws(
      IsCompactJws(token) ? cjose_jws_import(token.data(), token.size(), nullptr) : nullptr);
  cjose_header_t* header = jws == nullptr ? nullptr : cjose_jws_get_protected(jws.get());
  if (header == nullptr) return error::Unauthenticated("the token is no signed JWT");
  // The header asks for what this server does not understand (RFC 7515, 4.1.11).
  if (HeaderHas(header, "crit")) return error::Unauthenticated("the token has a header 'crit'");
  const std::string algorithm = HeaderText(header, CJOSE_HDR_ALG);
  if (algorithm != "RS256" && algorithm != "ES256") {
    return error::Unauthenticated(
        fmt::format("the token's algorithm must be RS256 or ES256, and is '{}'",
                    algorithm.substr(0, kMostAlgorithmBytes)));
  }
  LATTICED_ASSIGN_OR_RETURN(const Key* key, Find(algorithm, HeaderText(header, CJOSE_HDR_KID)));
  if (!cjose_jws_verify(jws.get(), key->key.get(), nullptr)) {
    return error::Unauthenticated("the token's signature is wrong");
  }
  uint8_t* payload = nullptr;  // the token's own
  size_t size = 0;
  if (!cjose_jws_get_plaintext(jws.get(), &payload, &size, nullptr)) {
    return error::Unauthenticated("the token is no signed JWT");
  }
  return std::string(reinterpret_cast<const char*>(payload), size);
}

}  // namespace latticed
