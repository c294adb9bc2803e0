// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// One HTTP request and its answer, as handlers see them: no socket, no HTTP library.
//
//   whole answer    exchange->Reply({.status = 200, .fields = {…}, .body = "…"})
//   streamed        Start(head), Write(bytes, done)…, End()     the next Write after `done` only, so
//                   that a client that does not read holds one message and stops its writer
//
// Threads  Post from anywhere; everything else, and every callback, on the connection's strand, which
//          Post reaches. After the client has gone, only OnGone's function is called.
#ifndef LATTICED_SERVER_WEB_HTTP_EXCHANGE_H_
#define LATTICED_SERVER_WEB_HTTP_EXCHANGE_H_

#include <grpcpp/support/slice.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace latticed::web {

struct HttpField {
  std::string name;  // in lower case
  std::string value;
};
using HttpFields = std::vector<HttpField>;

struct HttpRequest {
  std::string method;  // "GET"
  std::string path;    // as sent, escapes included, without the query
  std::string query;   // without the '?'
  HttpFields fields;
  std::string peer;            // address and port of the client: "ipv4:127.0.0.1:5000"
  bool secure = false;         // over TLS
  bool wants_upgrade = false;  // to a WebSocket

  // The value of the first field of that name; empty if there is none.
  [[nodiscard]] std::string_view Field(std::string_view name) const;
};

struct HttpResponse {
  int status = 200;
  HttpFields fields;
  std::string body = {};
};

// Bytes to send, one after the other; slices share what they hold.
using OutBytes = std::vector<grpc::Slice>;

struct Upgraded;  // server/web/http_connection.h

class HttpExchange {
 public:
  virtual ~HttpExchange() = default;
  [[nodiscard]] virtual const HttpRequest& request() const = 0;
  virtual void Post(std::function<void()> work) = 0;

  // Calls `done` with the next bytes of the body, none at its end; they are valid during the call.
  virtual void Read(std::function<void(std::string_view bytes)> done) = 0;

  virtual void Reply(HttpResponse response) = 0;
  // The head of an answer whose body follows, of `length` bytes or until End.
  virtual void Start(int status, HttpFields fields, std::optional<uint64_t> length) = 0;
  virtual void Write(OutBytes bytes, std::function<void()> done) = 0;
  virtual void End() = 0;
  // Breaks off an answer that cannot be completed, so that the client sees that it is incomplete.
  virtual void Abort() = 0;

  // Instead of an answer: hands over the connection, for a WebSocket.
  virtual void Upgrade(const std::function<void(Upgraded)>& take) = 0;

  // At most once, and not after End.
  virtual void OnGone(std::function<void()> gone) = 0;
};

using HttpHandler = std::function<void(std::shared_ptr<HttpExchange>)>;

}  // namespace latticed::web

#endif  // LATTICED_SERVER_WEB_HTTP_EXCHANGE_H_
