// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/grpc_web_call.h"

#include <utility>

#include "absl/time/clock.h"
#include "core/base/error.h"
#include "server/web/call_metadata.h"
#include "server/web/grpc_web_frames.h"
#include "server/web/http_answers.h"
#include "server/wire/grpc_status.h"

namespace latticed::web {
namespace {

constexpr std::string_view kMediaType = "application/grpc-web+proto";

bool IsGrpcWeb(std::string_view content_type) {
  const std::string_view type = content_type.substr(0, content_type.find(';'));
  return type == kMediaType || type == "application/grpc-web";
}

bool IsUncompressed(const HttpRequest& request) {
  const std::string_view encoding = request.Field("grpc-encoding");
  return encoding.empty() || encoding == "identity";
}

class GrpcWebCall final : public CallObserver, public std::enable_shared_from_this<GrpcWebCall> {
 public:
  GrpcWebCall(const RequestGuard& guard, std::shared_ptr<HttpExchange> exchange)
      : guard_(guard), exchange_(std::move(exchange)) {}

  void Start(const ServerChannel& server);

  void Post(std::function<void()> work) override { exchange_->Post(std::move(work)); }
  void OnHead(CallMetadata metadata) override { StartAnswer(metadata); }
  void OnMessage(grpc::ByteBuffer message) override;
  void OnWritten() override {
    writing_ = false;
    SendNext();
  }
  void OnEnd(grpc::Status status, CallMetadata trailers) override;

 private:
  void ReadBody();
  // Sends the next message of the body, unless the one before is still being written.
  void SendNext();
  void Fail(const absl::Status& status);
  void StartAnswer(const CallMetadata& metadata);

  const RequestGuard& guard_;
  const std::shared_ptr<HttpExchange> exchange_;
  std::shared_ptr<GenericCall> call_;
  FrameReader frames_;
  absl::Status failure_;  // an error found here; it cancels the rpc and becomes its status
  bool body_ended_ = false;
  bool writing_ = false;
  bool answering_ = false;
};

void GrpcWebCall::Start(const ServerChannel& server) {
  const HttpRequest& request = exchange_->request();
  const auto metadata = ToMetadata(request.fields);
  const auto deadline = DeadlineOf(request.Field("grpc-timeout"), absl::Now());
  if (!metadata.ok()) return OnEnd(ToGrpcStatus(metadata.status()), {});
  if (!deadline.ok()) return OnEnd(ToGrpcStatus(deadline.status()), {});
  if (!IsUncompressed(request)) {
    return OnEnd(ToGrpcStatus(error::Unimplemented("compression of requests")), {});
  }
  call_ = GenericCall::Start(server, {request.path, *metadata, request.peer, *deadline},
                             shared_from_this());
  exchange_->OnGone([call = call_] { call->Cancel(); });
  ReadBody();
}

void GrpcWebCall::ReadBody() {
  exchange_->Read([self = shared_from_this()](std::string_view bytes) {
    self->body_ended_ = bytes.empty();
    self->frames_.Append(bytes);
    self->SendNext();
  });
}

void GrpcWebCall::SendNext() {
  if (writing_ || !failure_.ok()) return;
  auto message = frames_.Next();
  if (!message.ok()) return Fail(message.status());
  if (message->has_value()) {
    writing_ = true;
    return call_->Write(**message);
  }
  if (!body_ended_) return ReadBody();
  if (!frames_.empty()) return Fail(error::InvalidField("body", "ends in the middle of a frame"));
  call_->WritesDone();
}

void GrpcWebCall::Fail(const absl::Status& status) {
  failure_ = status;
  call_->Cancel();
}

void GrpcWebCall::StartAnswer(const CallMetadata& metadata) {
  if (std::exchange(answering_, true)) return;
  HttpFields fields = ToFields(metadata);
  const HttpFields cors = guard_.CorsFields(exchange_->request(), fields);
  fields.push_back({"content-type", std::string(kMediaType)});
  fields.push_back({"x-content-type-options", "nosniff"});
  fields.push_back({"cache-control", "no-store"});
  Append(cors, fields);
  exchange_->Start(200, std::move(fields), std::nullopt);
}

void GrpcWebCall::OnMessage(grpc::ByteBuffer message) {
  StartAnswer({});
  OutBytes bytes = SlicesOf(message);
  bytes.insert(bytes.begin(), grpc::Slice(MessagePrefix(message.Length())));
  exchange_->Write(std::move(bytes), [call = call_] { call->Read(); });
}

void GrpcWebCall::OnEnd(grpc::Status status, CallMetadata trailers) {
  StartAnswer(trailers);
  if (!failure_.ok()) status = ToGrpcStatus(failure_);
  exchange_->Write({grpc::Slice(TrailersFrame(status, trailers))}, [] {});
  exchange_->End();
}

}  // namespace

void RunGrpcWebCall(const ServerChannel& server, const RequestGuard& guard,
                    std::shared_ptr<HttpExchange> exchange) {
  const HttpRequest& request = exchange->request();
  if (request.method != "POST") return exchange->Reply(MethodNotAllowed("POST"));
  if (!IsGrpcWeb(request.Field("content-type"))) {
    return exchange->Reply(TextAnswer(
        415, "rpcs are taken as gRPC-Web, binary: content-type application/grpc-web+proto"));
  }
  std::make_shared<GrpcWebCall>(guard, std::move(exchange))->Start(server);
}

}  // namespace latticed::web
