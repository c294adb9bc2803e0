// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bytes on their way to a socket: pieces that are not copied, and what keeps them alive.
#ifndef LATTICED_SERVER_WEB_OUT_BYTES_H_
#define LATTICED_SERVER_WEB_OUT_BYTES_H_

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace grpc {
class ByteBuffer;
}

namespace latticed::web {

struct OutBytes {
  std::vector<std::string_view> pieces;
  std::shared_ptr<const void> owner;  // of what `pieces` point at

  [[nodiscard]] size_t size() const;
};

[[nodiscard]] OutBytes ToOutBytes(std::string text);
// `prefix`, then the message.
[[nodiscard]] OutBytes ToOutBytes(std::string prefix, const grpc::ByteBuffer& message);

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_OUT_BYTES_H_
