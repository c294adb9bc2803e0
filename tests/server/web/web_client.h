// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Blocking clients of --http over real sockets: requests, gRPC-Web calls, a WebSocket.
#ifndef LATTICED_TESTS_SERVER_WEB_WEB_CLIENT_H_
#define LATTICED_TESTS_SERVER_WEB_WEB_CLIENT_H_

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace latticed::testing {

using WebFields = std::map<std::string, std::string>;  // names in lower case

struct WebAnswer {
  int status = 0;  // 0: the connection broke
  WebFields fields;
  std::string body;
};

class WebClient {
 public:
  // Host is "localhost" unless the fields of a request say otherwise. For TLS: `ca` is the PEM file of
  // the server's issuer, `certificate` a PEM file with the client's certificate and key.
  explicit WebClient(const std::string& address, const std::string& ca = "",
                     const std::string& certificate = "");
  ~WebClient();

  WebAnswer Ask(const std::string& method, const std::string& target, const WebFields& fields = {},
                const std::string& body = "");
  WebAnswer Get(const std::string& target, const WebFields& fields = {}) {
    return Ask("GET", target, fields);
  }
  // host:port of the client's end.
  std::string local_address() const;
  // The two halves of Ask.
  void Send(const std::string& method, const std::string& target, const WebFields& fields,
            const std::string& body);
  WebAnswer Receive(bool head = false);
  // Raw bytes without HTTP: false and "" once the other side has closed.
  bool SendBytes(const std::string& bytes);
  std::string ReceiveBytes(size_t most);
  void Close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// `message` as a frame of gRPC-Web.
[[nodiscard]] std::string Frame(const std::string& message);

struct GrpcWebAnswer {
  WebAnswer http;
  std::vector<std::string> messages;
  WebFields trailers;
  int code = -1;  // grpc-status
};
[[nodiscard]] GrpcWebAnswer ReadFrames(WebAnswer http);
// An rpc whose request may be empty, as CallGrpcWeb takes it.
inline constexpr char kInfo[] = "latticed.v1.ServerService/GetServerInfo";
[[nodiscard]] GrpcWebAnswer CallGrpcWeb(WebClient& client, const std::string& rpc,
                                        const std::string& body, WebFields fields = {});

class WebSocketClient {
 public:
  // `protocols` as in Sec-WebSocket-Protocol; `ca` as for WebClient.
  WebSocketClient(const std::string& address, const std::string& target,
                  const std::string& protocols = "latticed.v1", const WebFields& fields = {},
                  const std::string& ca = "");
  ~WebSocketClient();

  int status() const;  // 101 when it is open
  std::string local_address() const;
  std::string protocol() const;
  bool Send(const std::string& message, bool text = false);
  std::optional<std::string> Read();  // nothing at the end
  // The code of the close frame; 0 when the connection broke.
  int close_code() const;
  std::string close_reason() const;
  // Close sends a close frame, as a page does. Break just closes the connection.
  void Close();
  void Break();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latticed::testing

#endif  // LATTICED_TESTS_SERVER_WEB_WEB_CLIENT_H_
