// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/vtk/xml_array.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/string_view.h"
#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

absl::Status IsDamaged() {
  return absl::InvalidArgumentError("has an array of points that is damaged or cut off");
}

// Bytes that follow each other, as they are or in Base64. Texts of Base64 that end with = may follow each other, too.
class ByteSource {
 public:
  ByteSource(std::string_view text, bool is_base64) : text_(text), is_base64_(is_base64) {
    if (is_base64) text_.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  }

  absl::StatusOr<std::string> Take(uint64_t count) {
    if (!is_base64_) {
      if (text_.size() < count) return IsDamaged();
      std::string bytes(text_.substr(0, count));
      text_.remove_prefix(count);
      return bytes;
    }
    if (text_.size() + ahead_.size() < count) return IsDamaged();
    while (ahead_.size() < count) {
      // A run of whole quartets, up to the first that ends with = .
      const uint64_t wanted = (count - ahead_.size() + 2) / 3 * 4;
      std::string_view run = text_.substr(0, wanted);
      if (const size_t end = run.find('='); end != std::string_view::npos) {
        run = run.substr(0, end / 4 * 4 + 4);
      }
      std::string decoded;
      if (run.empty() || run.size() % 4 != 0 ||
          !absl::Base64Unescape(absl::string_view(run.data(), run.size()), &decoded)) {
        return IsDamaged();
      }
      ahead_ += decoded;
      text_.remove_prefix(run.size());
    }
    std::string bytes = ahead_.substr(0, count);
    ahead_.erase(0, count);
    return bytes;
  }

  absl::StatusOr<uint64_t> TakeCount(const XmlCoding& coding) {
    LATTICED_ASSIGN_OR_RETURN(std::string bytes, Take(coding.count_bytes));
    if (coding.order == std::endian::little) std::reverse(bytes.begin(), bytes.end());
    uint64_t count = 0;
    for (const char c : bytes) count = count << 8 | static_cast<unsigned char>(c);
    return count;
  }

 private:
  std::string_view text_;
  bool is_base64_;
  std::string ahead_;  // decoded, not yet taken
};

absl::StatusOr<std::string> Inflated(const std::string& block, uint64_t size) {
  constexpr uint64_t kMostRatio = 1100;  // of zlib: 1,032
  if (size > kMostRatio * (block.size() + 1)) return IsDamaged();
  std::string bytes(size, '\0');
  uLongf got = size;
  const int code =
      uncompress(reinterpret_cast<Bytef*>(bytes.data()), &got,
                 reinterpret_cast<const Bytef*>(block.data()), static_cast<uLong>(block.size()));
  if (code != Z_OK || got != size) return IsDamaged();
  return bytes;
}

}  // namespace

absl::StatusOr<std::string> XmlArrayBytes(std::string_view text, bool is_base64,
                                          const XmlCoding& coding) {
  ByteSource source(text, is_base64);
  LATTICED_ASSIGN_OR_RETURN(const uint64_t first, source.TakeCount(coding));
  if (!coding.is_compressed) return source.Take(first);
  LATTICED_ASSIGN_OR_RETURN(const uint64_t whole, source.TakeCount(coding));
  LATTICED_ASSIGN_OR_RETURN(const uint64_t last, source.TakeCount(coding));
  if (first > text.size()) return IsDamaged();
  std::vector<uint64_t> sizes(first);
  for (uint64_t& size : sizes) {
    LATTICED_ASSIGN_OR_RETURN(size, source.TakeCount(coding));
  }
  std::string bytes;
  for (size_t n = 0; n < sizes.size(); ++n) {
    LATTICED_ASSIGN_OR_RETURN(const std::string block, source.Take(sizes[n]));
    const bool is_short = n + 1 == sizes.size() && last != 0;
    LATTICED_ASSIGN_OR_RETURN(const std::string plain, Inflated(block, is_short ? last : whole));
    bytes += plain;
  }
  return bytes;
}

}  // namespace latticed::client
