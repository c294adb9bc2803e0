// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/fuzz_call.h"

#include <grpcpp/support/proto_buffer_reader.h>

#include <utility>

#include "fmt/format.h"
#include "tests/fuzz/fuzz_server.h"

namespace latticed::fuzz {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

// By the field's name, or its full name.
const std::map<std::string, std::string> kPlaceholders = {{"latticed.v1.PointSet.id", "@points"},
                                                          {"upload_id", "@upload"},
                                                          {"watch_id", "@watch"},
                                                          {"resume_token", "@resume"},
                                                          {"topology_id", "@topology"},
                                                          {"next_page_token", "@page"}};

// Calls `visit` with each set string field of the message and of those within it, except maps.
void VisitStrings(Message& message,
                  const std::function<void(Message&, const FieldDescriptor*)>& visit) {
  std::vector<const FieldDescriptor*> fields;
  const auto* const reflection = message.GetReflection();
  reflection->ListFields(message, &fields);
  for (const FieldDescriptor* field : fields) {
    if (field->is_map()) continue;
    if (field->cpp_type() == FieldDescriptor::CPPTYPE_STRING && !field->is_repeated()) {
      visit(message, field);
    } else if (field->cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
      if (!field->is_repeated()) {
        VisitStrings(*reflection->MutableMessage(&message, field), visit);
        continue;
      }
      for (int i = 0; i < reflection->FieldSize(message, field); ++i) {
        VisitStrings(*reflection->MutableRepeatedMessage(&message, field, i), visit);
      }
    }
  }
}

void Learn(Message& answer, KnownIds& ids) {
  VisitStrings(answer, [&ids](Message& message, const FieldDescriptor* field) {
    auto placeholder = kPlaceholders.find(field->name());
    if (placeholder == kPlaceholders.end()) placeholder = kPlaceholders.find(field->full_name());
    if (placeholder == kPlaceholders.end()) return;
    ids[placeholder->second] = message.GetReflection()->GetString(message, field);
  });
}

// Returns whether a placeholder was replaced. A page token is the id of a mesh or scene, perhaps the honest client's: no
// other field gets it.
bool Replace(Message& request, const KnownIds& ids) {
  bool replaced = false;
  VisitStrings(request, [&](Message& message, const FieldDescriptor* field) {
    const auto* const reflection = message.GetReflection();
    const auto id = ids.find(reflection->GetString(message, field));
    if (id == ids.end()) return;
    if (id->first == "@page" && field->name() != "page_token") return;
    reflection->SetString(&message, field, id->second);
    replaced = true;
  });
  return replaced;
}

}  // namespace

void Strand::Post(std::function<void()> work) {
  const MutexLock lock(&mutex_);
  work_.push_back(std::move(work));
}

bool Strand::RunOne(absl::Duration patience) {
  std::function<void()> work;
  {
    const MutexLock lock(&mutex_);
    const auto has_work = [this]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return !work_.empty(); };
    if (!mutex_.AwaitFor(has_work, patience)) return false;
    work = std::move(work_.front());
    work_.pop_front();
  }
  work();
  return true;
}

std::unique_ptr<Message> NewMessage(const google::protobuf::Descriptor* type) {
  auto* const factory = google::protobuf::MessageFactory::generated_factory();
  return std::unique_ptr<Message>(factory->GetPrototype(type)->New());
}

void FuzzCall::Start(const web::ServerChannel& server) {
  web::GenericCall::Request request;
  request.method = fmt::format("/{}/{}", method_->service()->full_name(), method_->name());
  request.peer = "ipv4:127.0.0.1:5000";
  call_ = web::GenericCall::Start(server, request, shared_from_this());
}

void FuzzCall::Send(std::string_view bytes) {
  const auto message = NewMessage(method_->input_type());
  const bool parsed = message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
  messages_.push_back(parsed && Replace(*message, *ids_) ? message->SerializeAsString()
                                                         : std::string(bytes));
  SendNext();
}

void FuzzCall::HalfClose() {
  closing_ = true;
  SendNext();
}

void FuzzCall::SendNext() {
  if (writing_ || closed_) return;
  if (messages_.empty()) {
    if (!closing_) return;
    closed_ = true;
    return call_->WritesDone();
  }
  writing_ = true;
  call_->Write(messages_.front());
  messages_.pop_front();
}

void FuzzCall::OnWritten() {
  writing_ = false;
  SendNext();
}

void FuzzCall::OnMessage(grpc::ByteBuffer bytes) {
  const auto answer = NewMessage(method_->output_type());
  grpc::ProtoBufferReader reader(&bytes);
  if (!answer->ParseFromZeroCopyStream(&reader)) {
    Fail(method_->full_name() + ": its answer cannot be parsed");
  }
  Learn(*answer, *ids_);
  const FieldDescriptor* const end = method_->output_type()->FindFieldByName("update_end");
  updated_ |= end != nullptr && answer->GetReflection()->HasField(*answer, end);
  call_->Read();
}

void FuzzCall::OnEnd(grpc::Status status, web::CallMetadata /*trailers*/) {
  ended_ = true;
  if (status.error_code() == grpc::StatusCode::INTERNAL ||
      status.error_code() == grpc::StatusCode::UNKNOWN) {
    Fail(fmt::format("{}: code {}, {}", method_->full_name(), static_cast<int>(status.error_code()),
                     status.error_message()));
  }
}

}  // namespace latticed::fuzz
