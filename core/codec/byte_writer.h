// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes little-endian numbers to memory that the caller has made large enough.
#ifndef LATTICED_CORE_CODEC_BYTE_WRITER_H_
#define LATTICED_CORE_CODEC_BYTE_WRITER_H_

#include <cstdint>
#include <cstring>
#include <span>

namespace latticed {

class ByteWriter {
 public:
  explicit ByteWriter(uint8_t* at) : at_(at) {}

  uint8_t* at() const { return at_; }

  void Byte(uint32_t value) { *at_++ = static_cast<uint8_t>(value); }

  template <class T>
  void Plain(T value) {
    std::memcpy(at_, &value, sizeof(value));
    at_ += sizeof(value);
  }

  // Seven bits per byte, the lowest first. The eighth bit says that more bytes follow.
  void Varint(uint64_t value) {
    for (; value >= 0x80; value >>= 7) Byte(static_cast<uint32_t>(value & 0x7F) | 0x80);
    Byte(static_cast<uint32_t>(value));
  }

  void Bytes(std::span<const uint8_t> bytes) {
    if (!bytes.empty()) std::memcpy(at_, bytes.data(), bytes.size());
    at_ += bytes.size();
  }

 private:
  uint8_t* at_;
};

inline constexpr size_t kMostVarintBytes = 10;

}  // namespace latticed

#endif  // LATTICED_CORE_CODEC_BYTE_WRITER_H_
