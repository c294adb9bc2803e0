// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "core/patches/zlib_stream.h"

#include <zlib.h>

#include "core/base/error.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// On patch plans, level 9 takes twice as long as 6 and saves 0.3 % of the bytes; level 1 takes half as long, for 3 % more.
constexpr int kLevel = 6;

const Bytef* Input(std::string_view bytes) { return reinterpret_cast<const Bytef*>(bytes.data()); }
Bytef* Output(std::string& bytes) { return reinterpret_cast<Bytef*>(bytes.data()); }

}  // namespace

absl::StatusOr<std::string> Deflate(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string stream(size, '\0');
  if (compress2(Output(stream), &size, Input(bytes), bytes.size(), kLevel) != Z_OK) {
    return error::AllocationFailed("zlib");
  }
  stream.resize(size);
  return stream;
}

absl::StatusOr<std::string> Inflate(std::string_view field, std::string_view stream, size_t size) {
  std::string bytes(size, '\0');
  uLongf got = size, used = stream.size();
  const int code = uncompress2(Output(bytes), &got, Input(stream), &used);
  if (code == Z_MEM_ERROR) return error::AllocationFailed("zlib");
  if (code != Z_OK || got != size || used != stream.size()) {
    return error::InvalidField(field, fmt::format("is not a zlib stream of {} bytes", size));
  }
  return bytes;
}

}  // namespace latticed
