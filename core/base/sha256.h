// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// SHA-256 of a stream of bytes, as lower-case hex: the id of an uploaded mesh; and the HMAC (RFC 2104) of it.
#ifndef LATTICED_CORE_BASE_SHA256_H_
#define LATTICED_CORE_BASE_SHA256_H_

#include <openssl/evp.h>

#include <memory>
#include <string>
#include <string_view>

namespace latticed {

class Sha256 {
 public:
  Sha256();

  void Update(std::string_view bytes);
  // The digest of all updates, 64 hex digits. Ends the stream: call once.
  [[nodiscard]] std::string FinishHex();

 private:
  struct Free {
    void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
  };
  std::unique_ptr<EVP_MD_CTX, Free> context_;
};

// The digest of bytes that are in one piece.
[[nodiscard]] std::string Sha256Hex(std::string_view bytes);
// Who knows `key` made this text: 64 hex digits.
[[nodiscard]] std::string HmacSha256Hex(std::string_view key, std::string_view text);
// Whether `text` is a digest as these functions write it.
[[nodiscard]] bool IsSha256Hex(std::string_view text);

}  // namespace latticed

#endif  // LATTICED_CORE_BASE_SHA256_H_
