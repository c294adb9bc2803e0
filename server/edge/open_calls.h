// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How many calls connections have open, by gRPC's own books (channelz). Calls of which nothing but
// the head has come are among them, of which no handler and no interceptor is told.
#ifndef LATTICED_SERVER_EDGE_OPEN_CALLS_H_
#define LATTICED_SERVER_EDGE_OPEN_CALLS_H_

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
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

// What channelz calls a connection; kNoSocket: it knows of none.
using SocketNumber = intptr_t;
inline constexpr SocketNumber kNoSocket = 0;

class OpenCalls {
 public:
  // Learns of the connections of every server of the process: of those that came since the last
  // call, and of all where the last time of that is a second ago. One may have got its number before
  // another, and be listed after it.
  void List();
  // As of the last List.
  [[nodiscard]] SocketNumber NumberOf(const Connection& connection) const;
  // Those that take memory, whether a handler knows of them or not; nullopt where gRPC knows no
  // connection of that number any more. 20 to 100 us.
  [[nodiscard]] static std::optional<int64_t> Of(SocketNumber number);

 private:
  std::multimap<uint16_t, SocketNumber> sockets_;  // by the port of the peer
  SocketNumber next_ = 0;                          // above all that are listed
  std::chrono::steady_clock::time_point all_again_;
};

}  // namespace latticed

#endif  // LATTICED_SERVER_EDGE_OPEN_CALLS_H_
