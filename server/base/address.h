// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Addresses of peers as gRPC writes them: "ipv4:127.0.0.1:5000", "ipv6:[::1]:5000", "unix:".
//
// Threads  pure functions
#ifndef LATTICED_SERVER_BASE_ADDRESS_H_
#define LATTICED_SERVER_BASE_ADDRESS_H_

#include <string>
#include <string_view>

namespace latticed {

// "ipv4:127.0.0.1" of "ipv4:127.0.0.1:5000".
[[nodiscard]] std::string_view WithoutPort(std::string_view peer);
// "127.0.0.1" or "::1" of such peers; empty for others.
[[nodiscard]] std::string IpOf(std::string_view peer);
// What counts as one address: an IPv4 address, or the network of 64 bits of an IPv6 address, "2001:db8::/64". Text
// that is no address stays.
[[nodiscard]] std::string NetworkOf(const std::string& ip);
// Whether the text is an IPv4 or IPv6 address.
[[nodiscard]] bool IsIp(const std::string& text);
// Whether the peer is on this machine: loopback, a Unix socket, or this process.
[[nodiscard]] bool IsOfThisMachine(std::string_view peer);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_ADDRESS_H_
