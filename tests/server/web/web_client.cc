// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/server/web/web_client.h"

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <limits>
#include <sstream>

#include "absl/strings/ascii.h"

namespace latticed::testing {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using net::ip::tcp;

std::string Text(beast::string_view text) { return {text.data(), text.size()}; }

// Returns the address of the client's end.
std::string Connect(tcp::socket& socket, const std::string& address) {
  const size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  if (host.starts_with('[')) host = host.substr(1, host.size() - 2);
  tcp::resolver resolver(socket.get_executor());
  error_code failure;
  net::connect(socket, resolver.resolve(host, address.substr(colon + 1)), failure);
  std::ostringstream text;
  text << socket.local_endpoint(failure);
  return text.str();
}

}  // namespace

struct WebClient::Impl {
  net::io_context context;
  net::ssl::context tls_context{net::ssl::context::tls_client};
  tcp::socket socket{context};
  std::string local_address;
  std::unique_ptr<net::ssl::stream<tcp::socket&>> tls;
  beast::flat_buffer buffer;
};

WebClient::WebClient(const std::string& address, const std::string& ca,
                     const std::string& certificate)
    : impl_(std::make_unique<Impl>()) {
  impl_->local_address = Connect(impl_->socket, address);
  if (ca.empty()) return;
  impl_->tls_context.load_verify_file(ca);
  impl_->tls_context.set_verify_mode(net::ssl::verify_peer);
  if (!certificate.empty()) {
    impl_->tls_context.use_certificate_file(certificate, net::ssl::context::pem);
    impl_->tls_context.use_private_key_file(certificate, net::ssl::context::pem);
  }
  impl_->tls = std::make_unique<net::ssl::stream<tcp::socket&>>(impl_->socket, impl_->tls_context);
  error_code failure;
  impl_->tls->handshake(net::ssl::stream_base::client, failure);
}

WebClient::~WebClient() = default;

void WebClient::Send(const std::string& method, const std::string& target, const WebFields& fields,
                     const std::string& body) {
  http::request<http::string_body> request;
  request.version(11);
  request.method_string(method);
  request.target(target);
  request.set(http::field::host, "localhost");
  for (const auto& [name, value] : fields) request.set(name, value);
  request.body() = body;
  if (!body.empty() || method == "POST") request.prepare_payload();
  std::ostringstream text;
  text << request;
  (void)SendBytes(text.str());
}

WebAnswer WebClient::Receive(bool head) {
  http::response_parser<http::string_body> parser;
  parser.body_limit(std::numeric_limits<uint64_t>::max());
  parser.skip(head);
  error_code failure;
  if (impl_->tls != nullptr) {
    http::read(*impl_->tls, impl_->buffer, parser, failure);
  } else {
    http::read(impl_->socket, impl_->buffer, parser, failure);
  }
  WebAnswer answer;
  if (failure) return answer;
  answer.status = static_cast<int>(parser.get().result_int());
  for (const auto& field : parser.get()) {
    answer.fields[absl::AsciiStrToLower(Text(field.name_string()))] = Text(field.value());
  }
  answer.body = std::move(parser.get().body());
  return answer;
}

WebAnswer WebClient::Ask(const std::string& method, const std::string& target,
                         const WebFields& fields, const std::string& body) {
  Send(method, target, fields, body);
  return Receive(method == "HEAD");
}

bool WebClient::SendBytes(const std::string& bytes) {
  error_code failure;
  if (impl_->tls != nullptr) {
    net::write(*impl_->tls, net::buffer(bytes), failure);
  } else {
    net::write(impl_->socket, net::buffer(bytes), failure);
  }
  return !failure;
}

std::string WebClient::ReceiveBytes(size_t most) {
  std::string bytes(most, '\0');
  error_code failure;
  bytes.resize(impl_->socket.read_some(net::buffer(bytes), failure));
  return bytes;
}

std::string WebClient::local_address() const { return impl_->local_address; }

void WebClient::Close() {
  error_code ignored;
  impl_->socket.close(ignored);
}

std::string Frame(const std::string& message) {
  std::string frame(5, '\0');
  for (size_t i = 0; i < 4; ++i) {
    frame[1 + i] = static_cast<char>(message.size() >> (24 - 8 * i) & 0xff);
  }
  return frame + message;
}

GrpcWebAnswer ReadFrames(WebAnswer http) {
  GrpcWebAnswer answer;
  const std::string& body = http.body;
  for (size_t at = 0; at + 5 <= body.size();) {
    size_t bytes = 0;
    for (size_t i = 1; i < 5; ++i) bytes = bytes << 8 | static_cast<unsigned char>(body[at + i]);
    const std::string payload = body.substr(at + 5, bytes);
    if ((body[at] & 0x80) == 0) {
      answer.messages.push_back(payload);
    } else {
      std::istringstream lines(payload);
      for (std::string line; std::getline(lines, line, '\n');) {
        const size_t colon = line.find(": ");
        answer.trailers[line.substr(0, colon)] = line.substr(colon + 2, line.size() - colon - 3);
      }
      answer.code = std::stoi(answer.trailers["grpc-status"]);
    }
    at += 5 + bytes;
  }
  answer.http = std::move(http);
  return answer;
}

GrpcWebAnswer CallGrpcWeb(WebClient& client, const std::string& rpc, const std::string& body,
                          WebFields fields) {
  fields.emplace("content-type", "application/grpc-web+proto");
  return ReadFrames(client.Ask("POST", "/" + rpc, fields, body));
}

struct WebSocketClient::Impl {
  using TlsStream = net::ssl::stream<tcp::socket&>;

  // Calls `action` with the stream in use, TLS or plain.
  template <typename Action>
  auto With(Action action) {
    return tls == nullptr ? action(plain) : action(*tls);
  }

  net::io_context context;
  net::ssl::context tls_context{net::ssl::context::tls_client};
  tcp::socket socket{context};
  websocket::stream<tcp::socket&, false> plain{socket};
  std::unique_ptr<websocket::stream<TlsStream, false>> tls;
  std::string local_address;
  beast::flat_buffer buffer;
  websocket::response_type response;
};

WebSocketClient::WebSocketClient(const std::string& address, const std::string& target,
                                 const std::string& protocols, const WebFields& fields,
                                 const std::string& ca)
    : impl_(std::make_unique<Impl>()) {
  impl_->local_address = Connect(impl_->socket, address);
  error_code failure;
  if (!ca.empty()) {
    impl_->tls_context.load_verify_file(ca);
    impl_->tls_context.set_verify_mode(net::ssl::verify_peer);
    impl_->tls = std::make_unique<websocket::stream<Impl::TlsStream, false>>(impl_->socket,
                                                                             impl_->tls_context);
    impl_->tls->next_layer().handshake(net::ssl::stream_base::client, failure);
    if (failure) return;
  }
  impl_->With([&](auto& stream) {
    stream.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
      if (!protocols.empty()) request.set(http::field::sec_websocket_protocol, protocols);
      for (const auto& [name, value] : fields) request.set(name, value);
    }));
    stream.handshake(impl_->response, "localhost", target, failure);
    stream.read_message_max(size_t{4} << 20);
  });
}

WebSocketClient::~WebSocketClient() = default;

int WebSocketClient::status() const { return static_cast<int>(impl_->response.result_int()); }

std::string WebSocketClient::local_address() const { return impl_->local_address; }

std::string WebSocketClient::protocol() const {
  return Text(impl_->response[http::field::sec_websocket_protocol]);
}

bool WebSocketClient::Send(const std::string& message, bool text) {
  error_code failure;
  impl_->With([&](auto& stream) {
    stream.text(text);
    stream.write(net::buffer(message), failure);
  });
  return !failure;
}

std::optional<std::string> WebSocketClient::Read() {
  error_code failure;
  impl_->buffer.clear();
  impl_->With([&](auto& stream) { stream.read(impl_->buffer, failure); });
  if (failure) return std::nullopt;
  return beast::buffers_to_string(impl_->buffer.data());
}

int WebSocketClient::close_code() const {
  return impl_->With([](auto& stream) { return stream.reason().code; });
}

std::string WebSocketClient::close_reason() const {
  const auto reason = impl_->With([](auto& stream) { return stream.reason().reason; });
  return {reason.data(), reason.size()};
}

void WebSocketClient::Close() {
  error_code ignored;
  impl_->With([&](auto& stream) { stream.close(websocket::close_code::normal, ignored); });
}

void WebSocketClient::Break() {
  error_code ignored;
  impl_->socket.close(ignored);
}

}  // namespace latticed::testing
