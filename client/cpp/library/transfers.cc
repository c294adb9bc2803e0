// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The rpcs of latticed_client.h that stream one way: uploads, updates, topologies, patch plans, exports. All are
// repeated after a broken connection.
#include <algorithm>
#include <functional>
#include <optional>
#include <stop_token>
#include <utility>

#include "client/cpp/library/latticed_client.h"
#include "client/cpp/library/patches/plan_from_proto.h"
#include "client/cpp/library/retries/with_retries.h"
#include "client/cpp/library/status.h"
#include "core/base/limits.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"

namespace latticed::client {
namespace {

void Report(const Progress& progress, uint64_t done, uint64_t total) {
  if (progress) progress(done, total);
}

void AppendPart(const v1::TopologyPart& part, v1::TopologyPart* whole) {
  whole->set_patch_count(part.patch_count());
  whole->mutable_faces()->MergeFrom(part.faces());
  whole->mutable_corners()->MergeFrom(part.corners());
  whole->mutable_barycentrics()->MergeFrom(part.barycentrics());
  whole->mutable_on_lattice_face()->MergeFrom(part.on_lattice_face());
}

}  // namespace

absl::StatusOr<v1::Mesh> Client::UploadMesh(std::string_view bytes, v1::MeshHeader header,
                                            const Progress& progress) {
  header.set_total_bytes(bytes.size());
  header.set_sha256(Sha256Hex(bytes));
  // A Mesh does not hold its RawLayout, so a client cannot see whether the layouts are the same.
  if (header.format() != v1::MESH_FORMAT_RAW) {
    if (auto present = GetMesh(header.sha256());
        present.ok() && present->format() == header.format()) {
      Report(progress, bytes.size(), bytes.size());
      return present;
    }
  }
  v1::Mesh mesh;
  LATTICED_RETURN_IF_ERROR(WithRetries(reachability_.get(), *channel_, stop_, [&] {
    const auto context = NewContext();
    std::optional<std::stop_callback<std::function<void()>>> cancel(
        std::in_place, stop_, [&context] { context->TryCancel(); });
    const auto writer = meshes_->UploadMesh(context.get(), &mesh);
    v1::UploadMeshRequest request;
    *request.mutable_header() = header;
    bool open = writer->Write(request);
    for (size_t sent = 0; open && sent < bytes.size();) {
      const std::string_view part = bytes.substr(sent, limits::kMaxPartBytes);
      if (sent + part.size() == bytes.size()) cancel.reset();  // the server may keep the mesh now
      request.set_data(part.data(), part.size());
      open = writer->Write(request);
      sent += part.size();
      Report(progress, sent, bytes.size());
    }
    if (open) writer->WritesDone();
    return FromGrpc(writer->Finish(), *context);
  }));
  return mesh;
}

template <typename Request, typename Message>
absl::Status Client::Receive(StreamMethod<v1::SceneService::Stub, Request, Message> method,
                             const Request& request, const std::function<void()>& begin,
                             const std::function<absl::Status(Message&&)>& take) {
  return WithRetries(reachability_.get(), *channel_, stop_, [&]() -> absl::Status {
    begin();
    const auto context = NewContext(request.scene());
    const std::stop_callback cancel(stop_, [&context] { context->TryCancel(); });
    const auto reader = (scenes_.get()->*method)(context.get(), request);
    absl::Status taken;
    for (Message message; taken.ok() && reader->Read(&message); message.Clear()) {
      taken = take(std::move(message));
    }
    if (!taken.ok()) context->TryCancel();
    const absl::Status end = FromGrpc(reader->Finish(), *context);
    return taken.ok() ? end : taken;
  });
}

absl::StatusOr<Surface> Client::GetUpdate(const v1::GetUpdateRequest& request,
                                          const Progress& progress) {
  constexpr uint64_t kProgressSteps = 1000;
  Surface surface;
  LATTICED_RETURN_IF_ERROR((Receive<v1::GetUpdateRequest, v1::SceneEvent>(
      &v1::SceneService::Stub::GetUpdate, request, [&] { surface = {}; },
      [&](v1::SceneEvent&& event) {
        const absl::Status status = surface.Apply(std::move(event)).status();
        Report(progress, static_cast<uint64_t>(surface.progress() * double{kProgressSteps}),
               kProgressSteps);
        return status;
      })));
  if (!surface.complete()) return absl::DataLossError("the server sent no complete update");
  return surface;
}

absl::StatusOr<v1::TopologyPart> Client::GetTopology(const std::string& scene,
                                                     const std::string& topology_id) {
  v1::GetTopologyRequest request;
  request.set_scene(scene);
  request.set_topology_id(topology_id);
  v1::TopologyPart whole;
  LATTICED_RETURN_IF_ERROR((Receive<v1::GetTopologyRequest, v1::TopologyPart>(
      &v1::SceneService::Stub::GetTopology, request, [&] { whole.Clear(); },
      [&](v1::TopologyPart&& part) {
        AppendPart(part, &whole);
        return absl::OkStatus();
      })));
  whole.set_topology_id(topology_id);
  if (static_cast<uint64_t>(whole.faces_size()) != whole.patch_count()) {
    return absl::DataLossError("the server sent less than the whole topology");
  }
  return whole;
}

absl::StatusOr<std::shared_ptr<const PatchPlan>> Client::GetPatchPlan(
    const std::string& scene, const std::string& topology_id, v1::NormalMode normals) {
  v1::GetPatchPlanRequest request;
  request.set_scene(scene);
  request.set_topology_id(topology_id);
  request.set_normals(normals);
  PatchPlanMessages messages;
  LATTICED_RETURN_IF_ERROR((Receive<v1::GetPatchPlanRequest, v1::PatchPlanPart>(
      &v1::SceneService::Stub::GetPatchPlan, request, [&] { messages = {}; },
      [&](v1::PatchPlanPart&& part) { return messages.Add(std::move(part)); })));
  LATTICED_ASSIGN_OR_RETURN(auto plan, messages.Finish());
  return std::make_shared<const PatchPlan>(std::move(plan));
}

absl::StatusOr<Client::ExportedFile> Client::Export(const v1::ExportRequest& request,
                                                    const Progress& progress) {
  ExportedFile file;
  LATTICED_RETURN_IF_ERROR((Receive<v1::ExportRequest, v1::ExportResponse>(
      &v1::SceneService::Stub::Export, request, [&] { file = {}; },
      [&](v1::ExportResponse&& response) {
        if (response.has_header()) file.header = response.header();
        if (response.has_data()) file.bytes += response.data();
        Report(progress, file.bytes.size(), file.header.bytes());
        return absl::OkStatus();
      })));
  if (file.bytes.size() != file.header.bytes()) {
    return absl::DataLossError(fmt::format("an export of {} bytes ended after {}",
                                           file.header.bytes(), file.bytes.size()));
  }
  return file;
}

}  // namespace latticed::client
