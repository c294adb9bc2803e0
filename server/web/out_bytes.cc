// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/out_bytes.h"

#include <grpcpp/support/byte_buffer.h>

#include <utility>

namespace latticed::web {

size_t OutBytes::size() const {
  size_t bytes = 0;
  for (const std::string_view piece : pieces) bytes += piece.size();
  return bytes;
}

OutBytes ToOutBytes(std::string text) {
  const auto kept = std::make_shared<const std::string>(std::move(text));
  return {{*kept}, kept};
}

OutBytes ToOutBytes(std::string prefix, const grpc::ByteBuffer& message) {
  struct Kept {
    std::string prefix;
    std::vector<grpc::Slice> slices;
  };
  const auto kept = std::make_shared<Kept>();
  kept->prefix = std::move(prefix);
  (void)message.Dump(&kept->slices);  // fails for compressed messages only, which a channel undoes
  OutBytes result{{kept->prefix}, kept};
  for (const grpc::Slice& slice : kept->slices) {
    result.pieces.emplace_back(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  return result;
}

}  // namespace latticed::web
