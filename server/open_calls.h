// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How many calls connections have open, by gRPC's own books (channelz). Calls of which nothing but
// the head has come are among them, of which no handler and no interceptor is told.
#ifndef LATTICED_SERVER_OPEN_CALLS_H_
#define LATTICED_SERVER_OPEN_CALLS_H_

#include <cstdint>
#include <map>
#include <string>

namespace latticed {

struct Endpoint {
  std::string address;  // 4 or 16 bytes in network order; IPv4 by way of IPv6 has 4
  uint16_t port = 0;
  bool operator==(const Endpoint&) const = default;
  // "ipv4:127.0.0.1:40530", as the log of calls has it.
  [[nodiscard]] std::string Name() const;
};

// The two ends of a TCP connection; ports are 0 where there is none.
struct Connection {
  Endpoint local, remote;
  bool operator==(const Connection&) const = default;
  [[nodiscard]] static Connection Of(int socket);
};

class OpenCalls {
 public:
  // Lists the connections of every server of the process: 30 us where there is one.
  OpenCalls();
  // Those that take memory, whether a handler knows of them or not. 20 to 100 us; 0 for a connection
  // that has ended, or came after the list.
  [[nodiscard]] int64_t Of(const Connection& connection) const;

 private:
  std::multimap<uint16_t, intptr_t> sockets_;  // channelz's numbers, by the port of the peer
};

}  // namespace latticed

#endif  // LATTICED_SERVER_OPEN_CALLS_H_
