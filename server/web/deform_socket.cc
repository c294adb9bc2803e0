// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/deform_socket.h"

#include <array>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_split.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "server/web/call_metadata.h"
#include "server/web/http_answers.h"
#include "server/web/query_parameters.h"
#include "server/web/web_socket.h"
#include "server/wire/grpc_status.h"

namespace latticed::web {
namespace {

constexpr char kDeformMethod[] = "/latticed.v1.SceneService/Deform";
constexpr char kProtocol[] = "latticed.v1";
constexpr std::string_view kBearer = "bearer.";
constexpr std::array<std::string_view, 3> kQueryMetadata = {"latticed-scene", "latticed-request-id",
                                                            "traceparent"};
constexpr uint16_t kNormalClosure = 1'000;
constexpr uint16_t kFirstStatusCode = 4'000;

class DeformSocket final : public CallObserver, public std::enable_shared_from_this<DeformSocket> {
 public:
  explicit DeformSocket(std::shared_ptr<WebSocket> socket) : socket_(std::move(socket)) {}

  void Start(const ServerChannel& server, CallMetadata metadata, std::string peer);

  void OnHead(CallMetadata /*metadata*/) override {}
  void OnMessage(grpc::ByteBuffer message) override;
  void OnWritten() override { ReadSocket(); }
  void OnEnd(grpc::Status status, CallMetadata /*trailers*/) override;

 private:
  void ReadSocket();
  void OnSocket(WebSocket::Event event, const std::string& message);

  const std::shared_ptr<WebSocket> socket_;
  std::shared_ptr<GenericCall> call_;
  absl::Status failure_;        // found here; the rpc is then cancelled
  bool client_closed_ = false;  // nothing more can be sent
  bool sending_ = false;
};

void DeformSocket::Start(const ServerChannel& server, CallMetadata metadata, std::string peer) {
  call_ = GenericCall::Start(server, {kDeformMethod, std::move(metadata), std::move(peer)}, socket_,
                             shared_from_this());
  call_->Read();
  ReadSocket();
}

void DeformSocket::ReadSocket() {
  socket_->Read([self = shared_from_this()](WebSocket::Event event, const std::string& message) {
    self->OnSocket(event, message);
  });
}

void DeformSocket::OnSocket(WebSocket::Event event, const std::string& message) {
  switch (event) {
    case WebSocket::Event::kMessage:
      return call_->Write(message);
    case WebSocket::Event::kTextMessage:
      failure_ = error::InvalidField("message", "must be binary, one DeformRequest a frame");
      return call_->Cancel();
    case WebSocket::Event::kClosed:
      client_closed_ = true;
      if (sending_) call_->Read();  // what was being sent has come to nothing
      return call_->WritesDone();
    case WebSocket::Event::kGone:
      return call_->Cancel();
  }
}

void DeformSocket::OnMessage(grpc::ByteBuffer message) {
  if (client_closed_) return call_->Read();
  sending_ = true;
  socket_->Write(ToOutBytes("", message), [self = shared_from_this()] {
    self->sending_ = false;
    self->call_->Read();
  });
}

void DeformSocket::OnEnd(grpc::Status status, CallMetadata /*trailers*/) {
  if (!failure_.ok()) status = ToGrpcStatus(failure_);
  if (status.ok()) return socket_->Close(kNormalClosure, "");
  const std::string reason = ReasonOf(status);
  socket_->Close(static_cast<uint16_t>(kFirstStatusCode + status.error_code()),
                 reason.empty() ? status.error_message()
                                : fmt::format("{}: {}", reason, status.error_message()));
}

// What the query says of the call, among what the browser's own fields say.
absl::StatusOr<CallMetadata> MetadataOf(const HttpRequest& request) {
  LATTICED_ASSIGN_OR_RETURN(auto parameters, QueryParameters(request.query, kQueryMetadata));
  HttpFields fields = request.fields;
  Append(parameters, fields);
  return ToMetadata(fields);
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
  auto metadata = MetadataOf(request);
  if (!metadata.ok()) return exchange->Reply(FailureAnswer(ToGrpcStatus(metadata.status())));
  if (!offer.token.empty()) metadata->emplace_back("authorization", "Bearer " + offer.token);
  exchange->Upgrade(
      offer.ours ? kProtocol : "", [server, metadata = *std::move(metadata),
                                    peer = request.peer](std::shared_ptr<WebSocket> socket) {
        std::make_shared<DeformSocket>(std::move(socket))->Start(server, metadata, peer);
      });
}

}  // namespace latticed::web
