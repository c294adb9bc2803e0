// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/session/server_meshes.h"

#include <filesystem>
#include <functional>
#include <utility>

#include "absl/time/clock.h"
#include "client/cpp/latticectl/command_line/message_flags.h"
#include "client/cpp/latticectl/output/output.h"
#include "client/cpp/latticectl/session/scene_patches.h"
#include "client/cpp/library/mesh.h"
#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"

namespace latticed::client {
namespace {

struct Tessellation {
  DecodedPoints points;
  std::vector<PatchLayout> layouts;
  double tolerance = 0, certified_error = 0;
};

absl::StatusOr<Tessellation> Decode(const Surface& surface) {
  Tessellation result{.tolerance = surface.view().tolerance(),
                      .certified_error = surface.certified_error()};
  LATTICED_ASSIGN_OR_RETURN(result.points, surface.Decode());
  LATTICED_ASSIGN_OR_RETURN(result.layouts, surface.Layouts());
  return result;
}

// The layouts refer to `patches`.
absl::StatusOr<Tessellation> Evaluate(const Surface& surface, double tolerance,
                                      ScenePatches& patches) {
  LATTICED_RETURN_IF_ERROR(patches.Evaluate(surface));
  return Tessellation{.points = patches.TakePoints(),
                      .layouts = patches.Layouts(),
                      .tolerance = tolerance,
                      .certified_error = patches.certified_error()};
}

// Where several servers share the scene, the call may have reached one that does not have it.
void DeleteWhereItIs(const std::function<absl::Status()>& call) {
  constexpr int kMostCalls = 20;
  for (int n = 0; n < kMostCalls; ++n) {
    const std::string reason = error::DetailsOf(call()).reason;
    if (reason != "SCENE_MOVED" && reason != "DRAINING") return;
    absl::SleepFor(absl::Milliseconds(50));
  }
}

}  // namespace

absl::StatusOr<v1::Mesh> Upload(Client& client, const MeshFile& file, v1::MeshHeader header,
                                Console console) {
  if (header.name().empty()) header.set_name(std::filesystem::path(file.path).filename().string());
  header.set_format(ToProto(file.format));
  ProgressBar bar(console, "upload", ProgressBar::Unit::kBytes);
  return client.UploadMesh(file.bytes, std::move(header), bar.callback());
}

absl::StatusOr<FetchedSurface> FetchSurface(Client& client, const std::string& scene,
                                            const v1::ViewOptions& view, const v1::Mesh& mesh,
                                            const MeshFile& file, Console console) {
  v1::GetUpdateRequest request;
  request.set_scene(scene);
  *request.mutable_view() = view;
  ProgressBar bar(console, "surface", ProgressBar::Unit::kNone);
  LATTICED_ASSIGN_OR_RETURN(const auto surface, client.GetUpdate(request, bar.callback()));
  ScenePatches patches(client, scene, view.tolerance());
  LATTICED_ASSIGN_OR_RETURN(auto tessellation, surface.view().encoding() == v1::ENCODING_PATCHES
                                                   ? Evaluate(surface, view.tolerance(), patches)
                                                   : Decode(surface));
  const std::vector<PatchLayout>& layouts = tessellation.layouts;
  LATTICED_ASSIGN_OR_RETURN(auto assembled, AssembleMesh(layouts, std::move(tessellation.points)));
  FetchedSurface result{.mesh = std::move(assembled),
                        .patches = surface.topology().patch_count(),
                        .bytes = surface.bytes(),
                        .tolerance = tessellation.tolerance,
                        .certified_error = tessellation.certified_error};
  result.mesh.units = MeshUnits{UpAxisName(mesh.up_axis()), mesh.meters_per_unit()};
  if (!mesh.has_uvs() && mesh.groups_size() == 0) return result;

  LATTICED_ASSIGN_OR_RETURN(const auto source, ParseMesh(file));
  LATTICED_ASSIGN_OR_RETURN(const auto provenance,
                            client.GetTopology(scene, surface.topology().topology_id()));
  LATTICED_RETURN_IF_ERROR(CarryAttributes(source, layouts, provenance, &result.mesh));
  return result;
}

// Also deletes scenes and meshes of failed calls: the server may have made them before the reply was
// lost.
TemporaryScenes::~TemporaryScenes() {
  for (const std::string& scene : scenes_to_delete_) {
    DeleteWhereItIs([&] { return client_.DeleteScene(scene); });
  }
  // Without force, a mesh stays if another client has used it for a scene meanwhile.
  for (const std::string& mesh : meshes_to_delete_) {
    (void)client_.DeleteMesh(mesh, /*force=*/false);
  }
}

absl::StatusOr<v1::Mesh> TemporaryScenes::Upload(const MeshFile& file, v1::MeshHeader header,
                                                 Console console) {
  const std::string id = Sha256Hex(file.bytes);
  if (absl::IsNotFound(client_.GetMesh(id).status())) meshes_to_delete_.push_back(id);
  auto mesh = client::Upload(client_, file, std::move(header), console);
  if (mesh.ok()) mesh_ = mesh->id();
  return mesh;
}

absl::StatusOr<v1::Scene> TemporaryScenes::Create(v1::CreateSceneRequest request) {
  scenes_to_delete_.push_back(RandomSceneId());
  request.set_scene_id(scenes_to_delete_.back());
  request.set_mesh(mesh_);
  return client_.CreateScene(std::move(request));
}

void TemporaryScenes::Keep() {
  meshes_to_delete_.clear();
  scenes_to_delete_.clear();
}

}  // namespace latticed::client
