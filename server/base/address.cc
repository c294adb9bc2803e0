// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/base/address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace latticed {

std::string_view WithoutPort(std::string_view peer) {
  return peer.starts_with("ip") ? peer.substr(0, peer.rfind(':')) : peer;
}

std::string IpOf(std::string_view peer) {
  if (!peer.starts_with("ip")) return "";
  constexpr size_t kScheme = std::string_view("ipv4:").size();
  std::string ip(WithoutPort(peer).substr(kScheme));
  for (const std::string_view bracket : {"%5B", "%5D", "[", "]"}) {
    if (const size_t at = ip.find(bracket); at != std::string::npos) ip.erase(at, bracket.size());
  }
  return ip;
}

std::string NetworkOf(const std::string& ip) {
  in6_addr address{};
  if (inet_pton(AF_INET6, ip.c_str(), &address) != 1 || IN6_IS_ADDR_V4MAPPED(&address)) return ip;
  constexpr size_t kNetworkBytes = 8;
  std::fill(std::begin(address.s6_addr) + kNetworkBytes, std::end(address.s6_addr), 0);
  std::array<char, INET6_ADDRSTRLEN> text{};
  inet_ntop(AF_INET6, &address, text.data(), text.size());
  return std::string(text.data()) + "/64";
}

bool IsIp(const std::string& text) {
  in6_addr address{};
  return inet_pton(AF_INET, text.c_str(), &address) == 1 ||
         inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

bool IsOfThisMachine(std::string_view peer) {
  const std::string ip = IpOf(peer);
  return ip.empty() || ip == "::1" || ip.starts_with("127.") || ip.starts_with("::ffff:127.");
}

}  // namespace latticed
