// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Addresses of peers as gRPC writes them: "ipv4:127.0.0.1:5000", "ipv6:[::1]:5000", "unix:".
//
// Threads  pure functions
#ifndef LATTICED_SERVER_BASE_ADDRESS_H_
#define LATTICED_SERVER_BASE_ADDRESS_H_

#include <string_view>

namespace latticed {

// "ipv4:127.0.0.1" of "ipv4:127.0.0.1:5000".
[[nodiscard]] std::string_view WithoutPort(std::string_view peer);
// Whether the peer is on this machine: loopback, a Unix socket, or this process.
[[nodiscard]] bool IsOfThisMachine(std::string_view peer);

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_ADDRESS_H_
