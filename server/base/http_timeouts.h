// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// How long a client of HTTP may leave its connection waiting; then it is closed.
//
// Threads  plain data
#ifndef LATTICED_SERVER_BASE_HTTP_TIMEOUTS_H_
#define LATTICED_SERVER_BASE_HTTP_TIMEOUTS_H_

#include <chrono>

namespace latticed {

struct HttpTimeouts {
  using Duration = std::chrono::steady_clock::duration;

  Duration head = std::chrono::seconds(10);    // for a handshake, and for the head of a request
  Duration body = std::chrono::seconds(60);    // between pieces of a body
  Duration write = std::chrono::minutes(5);    // to take what one write sends
  Duration idle = std::chrono::seconds(75);    // between requests
  Duration linger = std::chrono::seconds(5);   // to end what it sends, once it has its answer
  Duration silence = std::chrono::minutes(5);  // of a WebSocket; pings are sent at half of it
};

}  // namespace latticed

#endif  // LATTICED_SERVER_BASE_HTTP_TIMEOUTS_H_
