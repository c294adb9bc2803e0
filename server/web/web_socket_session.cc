// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/web_socket_session.h"

#include <boost/asio/dispatch.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/limits.h"
#include "core/base/utf8.h"

namespace latticed::web {
namespace {

namespace websocket = beast::websocket;

constexpr size_t kMaxReasonBytes = 123;  // RFC 6455, 5.5

class WebSocketSession final : public WebSocket,
                               public Connection,
                               public std::enable_shared_from_this<WebSocketSession> {
 public:
  WebSocketSession(Transport transport, std::shared_ptr<ConnectionSet::Place> place)
      : place_(std::move(place)), stream_(std::move(transport)) {}

  void Accept(const HttpTimeouts& timeouts, UpgradeRequest request, std::string subprotocol,
              std::function<void(std::shared_ptr<WebSocket>)> opened);

  void Post(std::function<void()> work) override {
    net::post(stream_.get_executor(), std::move(work));
  }
  void Read(std::function<void(Event, std::string)> done) override;
  void Write(OutBytes message, std::function<void()> done) override;
  void Close(uint16_t code, const std::string& reason) override;
  void OnGone(std::function<void()> gone) override { on_gone_ = std::move(gone); }

  // Its stream is told, and ends it.
  void Drain() override {}
  void Abort() override {
    Post([self = shared_from_this()] {
      self->stream_.next_layer().Close();
      self->Gone();
    });
  }

 private:
  void OnRead(error_code failure, const std::function<void(Event, std::string)>& done);
  void SendClose();
  void Gone();

  const std::shared_ptr<ConnectionSet::Place> place_;  // destroyed last: see http_connection.cc
  websocket::stream<Transport, false> stream_;         // no compression: chunks are Draco's
  beast::flat_buffer buffer_;
  OutBytes writing_;
  bool read_pending_ = false, write_pending_ = false;
  std::optional<websocket::close_reason> closing_;
  std::function<void()> on_gone_;
};

void WebSocketSession::Accept(const HttpTimeouts& timeouts, UpgradeRequest request,
                              std::string subprotocol,
                              std::function<void(std::shared_ptr<WebSocket>)> opened) {
  place_->Hold(shared_from_this());
  websocket::stream_base::timeout timeout{timeouts.head, timeouts.silence, true};
  stream_.set_option(timeout);
  stream_.set_option(websocket::stream_base::decorator(
      [subprotocol = std::move(subprotocol)](websocket::response_type& response) {
        response.set(beast::http::field::server, "latticed");
        if (!subprotocol.empty()) {
          response.set(beast::http::field::sec_websocket_protocol, subprotocol);
        }
      }));
  stream_.binary(true);
  stream_.auto_fragment(false);
  stream_.read_message_max(limits::kMaxMessageBytes);
  const auto kept = std::make_shared<UpgradeRequest>(std::move(request));
  stream_.async_accept(
      *kept, [self = shared_from_this(), kept, opened = std::move(opened)](error_code failure) {
        if (!failure) opened(self);
      });
}

void WebSocketSession::Read(std::function<void(Event, std::string)> done) {
  read_pending_ = true;
  stream_.async_read(buffer_, [self = shared_from_this(), done = std::move(done)](
                                  error_code failure, size_t) { self->OnRead(failure, done); });
}

void WebSocketSession::OnRead(error_code failure,
                              const std::function<void(Event, std::string)>& done) {
  read_pending_ = false;
  if (failure == websocket::error::closed) return done(Event::kClosed, "");
  if (failure) {
    done(Event::kGone, "");
    return Gone();
  }
  if (stream_.got_text()) {
    buffer_.clear();
    return done(Event::kTextMessage, "");
  }
  std::string message = beast::buffers_to_string(buffer_.data());
  buffer_.clear();
  done(Event::kMessage, std::move(message));
}

void WebSocketSession::Write(OutBytes message, std::function<void()> done) {
  writing_ = std::move(message);
  write_pending_ = true;
  std::vector<net::const_buffer> buffers;
  for (const std::string_view piece : writing_.pieces) {
    buffers.emplace_back(piece.data(), piece.size());
  }
  stream_.async_write(
      buffers, [self = shared_from_this(), done = std::move(done)](error_code failure, size_t) {
        self->write_pending_ = false;
        self->writing_ = {};
        // A read that is under way tells more: whether it was closed, or broke.
        if (failure) return self->read_pending_ ? void() : self->Gone();
        if (self->closing_.has_value()) return self->SendClose();
        done();
      });
}

void WebSocketSession::Close(uint16_t code, const std::string& reason) {
  if (closing_.has_value()) return;
  const std::string words = ValidUtf8(reason);
  const std::string_view cut = CutUtf8(words, kMaxReasonBytes);
  closing_.emplace(static_cast<websocket::close_code>(code),
                   beast::string_view(cut.data(), cut.size()));
  if (!write_pending_) SendClose();
}

void WebSocketSession::SendClose() {
  on_gone_ = nullptr;
  stream_.async_close(*closing_, [self = shared_from_this()](error_code) {});
}

void WebSocketSession::Gone() {
  if (const auto gone = std::exchange(on_gone_, nullptr)) gone();
}

}  // namespace

void AcceptWebSocket(Transport transport, std::shared_ptr<ConnectionSet::Place> place,
                     const HttpTimeouts& timeouts, UpgradeRequest request, std::string subprotocol,
                     std::function<void(std::shared_ptr<WebSocket>)> opened) {
  std::make_shared<WebSocketSession>(std::move(transport), std::move(place))
      ->Accept(timeouts, std::move(request), std::move(subprotocol), std::move(opened));
}

}  // namespace latticed::web
