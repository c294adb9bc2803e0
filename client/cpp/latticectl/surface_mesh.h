// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Uploads a mesh file, and fetches a deformed surface.
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_SURFACE_MESH_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_SURFACE_MESH_H_

#include <string>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/files.h"
#include "client/cpp/latticectl/latticectl_app.h"
#include "client/cpp/library/latticed_client.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed::client {

// Shows a progress bar. An empty name becomes the file's.
[[nodiscard]] absl::StatusOr<v1::Mesh> Upload(Client& client, const MeshFile& file,
                                              v1::MeshHeader header, Console console);

struct FetchedSurface {
  TriangleMesh mesh;
  uint64_t patches = 0;
  uint64_t bytes = 0;  // of chunk data
};
// One update in the view's encoding, as a mesh. Texture coordinates and groups come from `file`,
// the source of `mesh`.
[[nodiscard]] absl::StatusOr<FetchedSurface> FetchSurface(Client& client, const std::string& scene,
                                                          const v1::ViewOptions& view,
                                                          const v1::Mesh& mesh,
                                                          const MeshFile& file, Console console);

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_SURFACE_MESH_H_
