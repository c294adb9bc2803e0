// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#ifndef LATTICED_CLIENT_DECODER_BYTE_READER_H_
#define LATTICED_CLIENT_DECODER_BYTE_READER_H_

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace latticed::decoder {

// Reads little-endian numbers. After a read past the end, ok() is false, and that read and all later ones give 0.
class ByteReader {
 public:
  ByteReader() = default;
  ByteReader(const uint8_t* at, size_t size) : at_(at), end_(at + size) {}

  bool ok() const { return ok_; }
  const uint8_t* at() const { return at_; }
  size_t left() const { return static_cast<size_t>(end_ - at_); }
  void Fail() {
    ok_ = false;
    at_ = end_;
  }

  // Returns where the bytes begin, null if there are not so many.
  const uint8_t* Skip(uint64_t count) {
    if (count > left()) {
      Fail();
      return nullptr;
    }
    const uint8_t* const begin = at_;
    at_ += count;
    return begin;
  }
  uint32_t Byte() {
    const uint8_t* const byte = Skip(1);
    return byte == nullptr ? 0 : *byte;
  }
  template <class T>
  T Plain() {
    T value{};
    if (const uint8_t* const bytes = Skip(sizeof(T))) std::memcpy(&value, bytes, sizeof(T));
    return value;
  }
  // Seven bits a byte, the lowest first, 32 bits at most.
  uint32_t Varint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const uint32_t byte = Byte();
      value |= uint64_t{byte & 0x7F} << shift;
      if (byte < 0x80) {
        if (value >> 32 != 0) Fail();
        return ok_ ? static_cast<uint32_t>(value) : 0;
      }
    }
    Fail();
    return 0;
  }

 private:
  const uint8_t* at_ = nullptr;
  const uint8_t* end_ = nullptr;
  bool ok_ = true;
};

}  // namespace latticed::decoder

#endif  // LATTICED_CLIENT_DECODER_BYTE_READER_H_
