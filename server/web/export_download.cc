// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "server/web/export_download.h"

#include <grpcpp/support/proto_buffer_reader.h>

#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "core/base/error.h"
#include "core/base/limits.h"
#include "core/base/status_macros.h"
#include "core/base/utf8.h"
#include "fmt/format.h"
#include "latticed/v1/surface.pb.h"
#include "server/web/call_metadata.h"
#include "server/web/http_answers.h"
#include "server/wire/grpc_status.h"

namespace latticed::web {
namespace {

constexpr char kExportMethod[] = "/latticed.v1.SceneService/Export";

constexpr std::array<std::pair<std::string_view, v1::ExportFormat>, 7> kFormats = {
    {{"ply", v1::EXPORT_FORMAT_PLY},
     {"obj", v1::EXPORT_FORMAT_OBJ},
     {"stl", v1::EXPORT_FORMAT_STL},
     {"glb", v1::EXPORT_FORMAT_GLB},
     {"drc", v1::EXPORT_FORMAT_DRC},
     {"nets", v1::EXPORT_FORMAT_CONTROL_NETS},
     {"usda", v1::EXPORT_FORMAT_USD}}};

constexpr std::array<std::string_view, 4> kParameters = {"segments", "tolerance", "normals",
                                                         "geometry"};

absl::Status ReadSegments(const std::string& value, v1::ExportRequest& wanted) {
  int segments = 0;
  if (!absl::SimpleAtoi(value, &segments) || segments < limits::kMinSegments ||
      segments > limits::kMaxSegments) {
    return error::InvalidField("segments", fmt::format("got '{}', allowed is {} to {}", value,
                                                       limits::kMinSegments, limits::kMaxSegments));
  }
  wanted.mutable_view()->set_segments(segments);
  return absl::OkStatus();
}

absl::Status ReadTolerance(const std::string& value, v1::ExportRequest& wanted) {
  double tolerance = 0;
  if (!absl::SimpleAtod(value, &tolerance) || !std::isfinite(tolerance) || tolerance <= 0) {
    return error::InvalidField(
        "tolerance", fmt::format("got '{}', allowed are numbers above 0, in world units", value));
  }
  wanted.mutable_view()->set_tolerance(tolerance);
  return absl::OkStatus();
}

absl::Status ReadNormals(const std::string& value, v1::ExportRequest& wanted) {
  v1::NormalMode mode = v1::NORMAL_MODE_UNSPECIFIED;
  if (!v1::NormalMode_Parse("NORMAL_MODE_" + absl::AsciiStrToUpper(value), &mode)) {
    return error::InvalidField("normals",
                               fmt::format("got '{}', allowed are none, facet, smooth", value));
  }
  wanted.mutable_view()->set_normals(mode);
  return absl::OkStatus();
}

absl::Status ReadGeometry(const std::string& value, v1::ExportRequest& wanted) {
  v1::ExportGeometry geometry = v1::EXPORT_GEOMETRY_UNSPECIFIED;
  if (!v1::ExportGeometry_Parse("EXPORT_GEOMETRY_" + absl::AsciiStrToUpper(value), &geometry)) {
    return error::InvalidField(
        "geometry", fmt::format("got '{}', allowed are exact, patches, original", value));
  }
  wanted.set_geometry(geometry);
  return absl::OkStatus();
}

// What the query does not name is as in the scene's default view.
absl::Status ReadQuery(const std::string& query, v1::ExportRequest& wanted) {
  LATTICED_ASSIGN_OR_RETURN(const auto parameters, QueryParameters(query, kParameters));
  for (const auto& [name, value] : parameters) {
    const auto read = name == "segments"    ? ReadSegments
                      : name == "tolerance" ? ReadTolerance
                      : name == "normals"   ? ReadNormals
                                            : ReadGeometry;
    LATTICED_RETURN_IF_ERROR(read(value, wanted));
  }
  return absl::OkStatus();
}

bool IsNameCharacter(char c) {
  return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-' || c == '_';
}

// Content-Disposition as in RFC 6266: an ASCII name in quotes, and the true name escaped.
std::string Disposition(const std::string& file_name) {
  std::string ascii = file_name;
  for (char& c : ascii) c = IsNameCharacter(c) ? c : '_';
  return fmt::format("attachment; filename=\"{}\"; filename*=UTF-8''{}", ascii,
                     PercentEncode(file_name, IsNameCharacter));
}

class ExportDownload final : public CallObserver,
                             public std::enable_shared_from_this<ExportDownload> {
 public:
  ExportDownload(const RequestGuard& guard, std::shared_ptr<HttpExchange> exchange)
      : guard_(guard), exchange_(std::move(exchange)) {}

  void Start(const ServerChannel& server, const v1::ExportRequest& request, CallMetadata metadata);

  void Post(std::function<void()> work) override { exchange_->Post(std::move(work)); }
  void OnHead(CallMetadata metadata) override { fields_ = ToFields(metadata); }
  void OnMessage(grpc::ByteBuffer message) override;
  void OnWritten() override { call_->WritesDone(); }
  void OnEnd(grpc::Status status, CallMetadata trailers) override;

 private:
  void StartAnswer(const v1::ExportHeader& header);

  const RequestGuard& guard_;
  const std::shared_ptr<HttpExchange> exchange_;
  std::shared_ptr<GenericCall> call_;
  HttpFields fields_;
  bool answering_ = false;
};

void ExportDownload::Start(const ServerChannel& server, const v1::ExportRequest& request,
                           CallMetadata metadata) {
  call_ = GenericCall::Start(
      server, {kExportMethod, std::move(metadata), exchange_->request().peer}, shared_from_this());
  exchange_->OnGone([call = call_] { call->Cancel(); });
  call_->Write(request.SerializeAsString());
}

void ExportDownload::StartAnswer(const v1::ExportHeader& header) {
  answering_ = true;
  if (header.certified_error() > 0) {
    fields_.push_back({"latticed-certified-error", fmt::to_string(header.certified_error())});
  }
  Append(guard_.CorsFields(exchange_->request(), fields_), fields_);
  fields_.push_back({"content-type", header.media_type()});
  fields_.push_back({"content-disposition", Disposition(header.file_name())});
  fields_.push_back({"x-content-type-options", "nosniff"});
  fields_.push_back({"cache-control", "no-store"});
  exchange_->Start(200, std::move(fields_), header.bytes());
}

void ExportDownload::OnMessage(grpc::ByteBuffer message) {
  v1::ExportResponse part;
  grpc::ProtoBufferReader reader(&message);
  if (!part.ParseFromZeroCopyStream(&reader)) return call_->Cancel();
  if (part.has_header()) {
    StartAnswer(part.header());
    return call_->Read();
  }
  exchange_->Write({grpc::Slice(part.data())}, [call = call_] { call->Read(); });
}

void ExportDownload::OnEnd(grpc::Status status, CallMetadata trailers) {
  if (answering_) return status.ok() ? exchange_->End() : exchange_->Abort();
  HttpResponse answer = FailureAnswer(status);
  const HttpFields fields = ToFields(trailers);
  Append(fields, answer.fields);
  Append(guard_.CorsFields(exchange_->request(), fields), answer.fields);
  exchange_->Reply(std::move(answer));
}

}  // namespace

void RunExportDownload(const ServerChannel& server, const RequestGuard& guard,
                       const std::shared_ptr<HttpExchange>& exchange) {
  const HttpRequest& request = exchange->request();
  if (request.method != "GET") return exchange->Reply(MethodNotAllowed("GET"));
  const std::string name = request.path.substr(kExportPrefix.size());
  const size_t dot = name.rfind('.');
  v1::ExportRequest wanted;
  for (const auto& [extension, format] : kFormats) {
    if (dot != std::string::npos && name.substr(dot + 1) == extension) wanted.set_format(format);
  }
  if (wanted.format() == v1::EXPORT_FORMAT_UNSPECIFIED) {
    return exchange->Reply(TextAnswer(
        404, "exports are /export/<scene>.<format>; formats: ply, obj, stl, glb, drc, usda, nets"));
  }
  wanted.set_scene(ValidUtf8(name.substr(0, dot)));  // an invalid string is no message
  if (const auto read = ReadQuery(request.query, wanted); !read.ok()) {
    return exchange->Reply(FailureAnswer(ToGrpcStatus(read)));
  }
  auto metadata = ToMetadata(request.fields);
  if (!metadata.ok()) return exchange->Reply(FailureAnswer(ToGrpcStatus(metadata.status())));
  std::make_shared<ExportDownload>(guard, exchange)->Start(server, wanted, *std::move(metadata));
}

}  // namespace latticed::web
