// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// zlib streams (RFC 1950).
//
// Threads  pure functions
#ifndef LATTICED_CORE_PATCHES_ZLIB_STREAM_H_
#define LATTICED_CORE_PATCHES_ZLIB_STREAM_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace latticed {

// Errors: kResourceExhausted without memory.
[[nodiscard]] absl::StatusOr<std::string> Deflate(std::string_view bytes);

// Errors: kInvalidArgument naming `field` if the stream is damaged, or does not hold exactly `size` bytes.
[[nodiscard]] absl::StatusOr<std::string> Inflate(std::string_view field, std::string_view stream,
                                                  size_t size);

}  // namespace latticed

#endif  // LATTICED_CORE_PATCHES_ZLIB_STREAM_H_
