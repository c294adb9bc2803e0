// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// A file as a PartStream has it: a message with the header, then its bytes in messages of
// limits::kMaxPartBytes. Export, DownloadMesh.
//
// Threads  one at a time
#ifndef LATTICED_SERVER_RPC_FILE_PARTS_H_
#define LATTICED_SERVER_RPC_FILE_PARTS_H_

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/limits.h"
#include "server/rpc/part_stream.h"

namespace latticed {

// The bytes from `offset` on, which is not beyond their end. What they are of is kept until the
// stream is done, with its room.
template <typename Message, typename Header>
NextPart<Message> FileParts(Header header, std::shared_ptr<const std::string> bytes,
                            size_t offset = 0) {
  return [header = std::optional(std::move(header)), bytes = std::move(bytes),
          offset]() mutable -> absl::StatusOr<std::optional<Message>> {
    Message part;
    if (header.has_value()) {
      *part.mutable_header() = *std::exchange(header, std::nullopt);
      return part;
    }
    if (offset == bytes->size()) return std::nullopt;
    const size_t size = std::min(limits::kMaxPartBytes, bytes->size() - offset);
    part.set_data(bytes->data() + offset, size);
    offset += size;
    return part;
  };
}

}  // namespace latticed

#endif  // LATTICED_SERVER_RPC_FILE_PARTS_H_
