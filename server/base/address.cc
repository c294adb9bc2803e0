// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/address.h"

namespace latticed {

std::string_view WithoutPort(std::string_view peer) {
  return peer.starts_with("ip") ? peer.substr(0, peer.rfind(':')) : peer;
}

bool IsOfThisMachine(std::string_view peer) {
  if (!peer.starts_with("ip")) return true;
  return peer.starts_with("ipv4:127.") || peer.starts_with("ipv6:[::1]") ||
         peer.starts_with("ipv6:%5B::1%5D") || peer.starts_with("ipv6:[::ffff:127.");
}

}  // namespace latticed
