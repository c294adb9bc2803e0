// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/deform_socket.h"

#include <array>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <optional>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/base/utf8.h"
#include "fmt/format.h"
#include "server/web/call_metadata.h"
#include "server/web/http_answers.h"
#include "server/web/http_connection.h"
#include "server/wire/grpc_status.h"

namespace latticed::web {
namespace {

namespace websocket = beast::websocket;

constexpr char kDeformMethod[] = "/latticed.v1.SceneService/Deform";
constexpr char kProtocol[] = "latticed.v1";
constexpr std::string_view kBearer = "bearer.";
constexpr std::array<std::string_view, 3> kQueryMetadata = {"latticed-scene", "latticed-request-id",
                                                            "traceparent"};
constexpr int kNormalClosure = 1'000;
constexpr int kFirstStatusCode = 4'000;
constexpr size_t kMaxReasonBytes = 123;  // RFC 6455, 5.5

class DeformSocket final : public CallObserver,
                           public Connection,
                           public std::enable_shared_from_this<DeformSocket> {
 public:
  explicit DeformSocket(Upgraded upgraded)
      : place_(std::move(upgraded.place)),
        executor_(upgraded.transport.get_executor()),
        stream_(std::in_place, std::move(upgraded.transport)),
        timeouts_(upgraded.timeouts),
        ending_(executor_),
        request_(std::move(upgraded.request)) {}

  // Answers the handshake, with `subprotocol` if it is not empty, and begins the call. If the handshake fails,
  // the connection ends.
  void Accept(const std::string& subprotocol, const ServerChannel& server,
              const CallMetadata& metadata, const std::string& peer);

  void Post(std::function<void()> work) override { net::post(executor_, std::move(work)); }
  void OnHead(CallMetadata /*metadata*/) override {}
  void OnMessage(grpc::ByteBuffer message) override;
  void OnWritten() override { ReadSocket(); }
  void OnEnd(grpc::Status status, CallMetadata /*trailers*/) override;

  // Does nothing: the server sends goaway on the call's stream and ends the call.
  void Drain() override {}
  void Abort() override {
    Post([self = shared_from_this()] { self->Drop(); });
  }

 private:
  void ReadSocket();
  void OnRead(error_code failure);
  void OnSent(error_code failure);
  void SendClose();
  void EndWithin(HttpTimeouts::Duration time);
  // Ends the connection and the call at once.
  void Drop();

  const std::shared_ptr<ConnectionSet::Place> place_;  // destroyed last: see http_connection.cc
  const Transport::executor_type executor_;
  // No compression: chunks are mostly Draco. Empty once dropped.
  std::optional<websocket::stream<Transport, false>> stream_;
  const HttpTimeouts timeouts_;
  net::steady_timer ending_;  // time limit for the client to close, too
  const beast::http::request<beast::http::string_body> request_;
  std::shared_ptr<GenericCall> call_;  // null before the handshake
  beast::flat_buffer buffer_;
  std::optional<OutBytes> sending_;
  absl::Status failure_;        // an error found here; it cancels the rpc
  bool reading_ = false;        // a read of the socket is pending
  bool client_closed_ = false;  // the server can send nothing more
  std::optional<websocket::close_reason> closing_;
};

void DeformSocket::Accept(const std::string& subprotocol, const ServerChannel& server,
                          const CallMetadata& metadata, const std::string& peer) {
  place_->Hold(shared_from_this());
  stream_->set_option(websocket::stream_base::timeout{timeouts_.head, timeouts_.silence, true});
  stream_->set_option(
      websocket::stream_base::decorator([subprotocol](websocket::response_type& response) {
        response.set(beast::http::field::server, "latticed");
        if (!subprotocol.empty()) {
          response.set(beast::http::field::sec_websocket_protocol, subprotocol);
        }
      }));
  stream_->binary(true);
  stream_->auto_fragment(false);
  stream_->read_message_max(limits::kMaxMessageBytes);
  stream_->async_accept(
      request_, [self = shared_from_this(), server, metadata, peer](error_code failure) {
        if (failure || !self->stream_.has_value()) return;
        self->call_ = GenericCall::Start(server, {kDeformMethod, metadata, peer}, self);
        self->ReadSocket();
      });
}

void DeformSocket::ReadSocket() {
  if (!stream_.has_value()) return;
  reading_ = true;
  stream_->async_read(buffer_, [self = shared_from_this()](error_code failure, size_t) {
    self->reading_ = false;
    self->OnRead(failure);
  });
}

void DeformSocket::OnRead(error_code failure) {
  if (failure == websocket::error::closed) {
    client_closed_ = true;
    if (sending_.has_value()) call_->Read();  // the message that was being sent is lost
    return call_->WritesDone();
  }
  // The connection broke, was silent for too long, or sent an invalid frame.
  if (failure || !stream_.has_value()) return call_->Cancel();
  if (stream_->got_text()) {
    failure_ = error::InvalidField("message", "must be binary, one DeformRequest a frame");
    return call_->Cancel();
  }
  const std::string message = beast::buffers_to_string(buffer_.data());
  buffer_.clear();
  call_->Write(message);
}

void DeformSocket::OnMessage(grpc::ByteBuffer message) {
  if (client_closed_) return call_->Read();
  if (!stream_.has_value()) return;
  sending_ = SlicesOf(message);
  stream_->async_write(
      BuffersOf(*sending_),
      [self = shared_from_this()](error_code failure, size_t) { self->OnSent(failure); });
}

void DeformSocket::OnSent(error_code failure) {
  // A pending read fails too, and OnRead then finds out whether the client closed the connection.
  if (failure) return reading_ ? void() : call_->Cancel();
  sending_.reset();
  if (closing_.has_value()) return SendClose();
  call_->Read();
}

void DeformSocket::OnEnd(grpc::Status status, CallMetadata /*trailers*/) {
  if (!failure_.ok()) status = ToGrpcStatus(failure_);
  std::string words;
  if (!status.ok()) {
    const std::string reason = ReasonOf(status);
    words = ValidUtf8(reason.empty() ? status.error_message()
                                     : fmt::format("{}: {}", reason, status.error_message()));
  }
  const int code = status.ok() ? kNormalClosure : kFirstStatusCode + status.error_code();
  const std::string_view cut = CutUtf8(words, kMaxReasonBytes);
  closing_.emplace(static_cast<websocket::close_code>(code),
                   beast::string_view(cut.data(), cut.size()));
  if (!sending_.has_value()) return SendClose();
  EndWithin(timeouts_.write);  // the client may take nothing, and yet not be idle
}

void DeformSocket::EndWithin(HttpTimeouts::Duration time) {
  ending_.expires_after(time);
  ending_.async_wait([weak = weak_from_this()](error_code failure) {
    const auto self = weak.lock();
    if (self != nullptr && !failure) self->Drop();
  });
}

void DeformSocket::SendClose() {
  if (!stream_.has_value()) return;
  EndWithin(timeouts_.linger);
  stream_->async_close(*closing_, [self = shared_from_this()](error_code) {});
}

// Closing the socket does not end all of the stream's operations. If the client's next frame is invalid while the
// server closes, the read waits for the close to end, and the close for the read (Boost 1.74). Both keep this object,
// until the stream is destroyed.
void DeformSocket::Drop() {
  if (!stream_.has_value()) return;
  stream_->next_layer().Close();
  if (call_ != nullptr) call_->Cancel();
  Post([self = shared_from_this()] { self->stream_.reset(); });
}

struct Offer {
  bool any = false;
  bool ours = false;
  std::string token;
};

Offer ReadOffer(const std::string& protocols) {
  Offer offer;
  for (const auto piece : absl::StrSplit(protocols, ',', absl::SkipWhitespace())) {
    const std::string protocol(absl::StripAsciiWhitespace(piece));
    offer.any = true;
    if (protocol == kProtocol) offer.ours = true;
    if (protocol.starts_with(kBearer)) {
      absl::WebSafeBase64Unescape(protocol.substr(kBearer.size()), &offer.token);
    }
  }
  return offer;
}

// Checks the token like every other value: gRPC ends the process at metadata that is not printable.
absl::StatusOr<CallMetadata> MetadataOf(const HttpRequest& request, const Offer& offer) {
  LATTICED_ASSIGN_OR_RETURN(auto parameters, QueryParameters(request.query, kQueryMetadata));
  HttpFields fields = request.fields;
  Append(parameters, fields);
  if (!offer.token.empty()) fields.push_back({"authorization", "Bearer " + offer.token});
  return ToMetadata(fields);
}

}  // namespace

void OpenDeformSocket(const ServerChannel& server, const std::shared_ptr<HttpExchange>& exchange) {
  const HttpRequest& request = exchange->request();
  if (!request.wants_upgrade) {
    HttpResponse answer = TextAnswer(426, "this address is a WebSocket");
    answer.fields.push_back({"upgrade", "websocket"});
    return exchange->Reply(std::move(answer));
  }
  const Offer offer = ReadOffer(std::string(request.Field("sec-websocket-protocol")));
  if (offer.any && !offer.ours) {
    return exchange->Reply(TextAnswer(400, "offer the subprotocol latticed.v1"));
  }
  const auto metadata = MetadataOf(request, offer);
  if (!metadata.ok()) return exchange->Reply(FailureAnswer(ToGrpcStatus(metadata.status())));
  exchange->Upgrade([&](Upgraded upgraded) {
    std::make_shared<DeformSocket>(std::move(upgraded))
        ->Accept(offer.ours ? kProtocol : "", server, *metadata, request.peer);
  });
}

}  // namespace latticed::web
