// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/latticectl/surface_mesh.h"

#include <filesystem>
#include <utility>

#include "client/cpp/latticectl/message_flags.h"
#include "client/cpp/latticectl/progress_bar.h"
#include "client/cpp/library/mesh.h"
#include "core/base/status_macros.h"

namespace latticed::client {

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
  LATTICED_ASSIGN_OR_RETURN(auto points, surface.Decode());
  LATTICED_ASSIGN_OR_RETURN(auto assembled, AssembleMesh(surface.topology(), std::move(points)));
  FetchedSurface result{.mesh = std::move(assembled),
                        .patches = surface.topology().patch_count(),
                        .bytes = surface.bytes()};
  result.mesh.units = MeshUnits{UpAxisName(mesh.up_axis()), mesh.meters_per_unit()};
  if (!mesh.has_uvs() && mesh.groups_size() == 0) return result;

  LATTICED_ASSIGN_OR_RETURN(const auto source, ParseMesh(file));
  LATTICED_ASSIGN_OR_RETURN(const auto provenance,
                            client.GetTopology(scene, surface.topology().topology_id()));
  LATTICED_RETURN_IF_ERROR(CarryAttributes(source, surface.topology(), provenance, &result.mesh));
  return result;
}

}  // namespace latticed::client
