// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Creates meshes and scenes on a server for commands, and fetches surfaces.
//
// Errors   those of the server and of files
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SERVER_MESHES_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SERVER_MESHES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/geometry/files.h"
#include "client/cpp/latticectl/output/console.h"
#include "client/cpp/library/latticed_client.h"
#include "core/mesh/triangle_mesh.h"

namespace latticed::client {

// Uploads with a progress bar. An empty name becomes the file's name.
[[nodiscard]] absl::StatusOr<v1::Mesh> Upload(Client& client, const MeshFile& file,
                                              v1::MeshHeader header, Console console);

struct FetchedSurface {
  TriangleMesh mesh;
  uint64_t patches = 0;
  uint64_t bytes = 0;          // of chunks
  double tolerance = 0;        // of the view
  double certified_error = 0;  // UpdateEnd.certified_error, or that of the program's own points
};
// Fetches one update in the view's encoding, as a mesh. With ENCODING_PATCHES the view needs a tolerance. Texture
// coordinates and groups come from `file`, the source of `mesh`.
[[nodiscard]] absl::StatusOr<FetchedSurface> FetchSurface(Client& client, const std::string& scene,
                                                          const v1::ViewOptions& view,
                                                          const v1::Mesh& mesh,
                                                          const MeshFile& file, Console console);

// Temporary scenes of a command on a shared server, and their meshes. The destructor deletes them,
// also after an error or an interruption. It deletes a mesh only if this command uploaded it.
//
//   TemporaryScenes made(client);
//   const auto mesh = made.Upload(file, {}, console);
//   const auto scene = made.Create(request);
class TemporaryScenes {
 public:
  explicit TemporaryScenes(Client& client) : client_(client) {}
  ~TemporaryScenes();
  TemporaryScenes(const TemporaryScenes&) = delete;  // a copy would delete them too
  TemporaryScenes& operator=(const TemporaryScenes&) = delete;

  // Uploads with a progress bar.
  [[nodiscard]] absl::StatusOr<v1::Mesh> Upload(const MeshFile& file, v1::MeshHeader header,
                                                Console console);
  // Creates a scene of the last uploaded mesh. Fills in scene_id and mesh.
  [[nodiscard]] absl::StatusOr<v1::Scene> Create(v1::CreateSceneRequest request);
  // Makes the destructor delete nothing.
  void Keep();

 private:
  Client& client_;
  std::string mesh_;
  std::vector<std::string> meshes_to_delete_, scenes_to_delete_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_SESSION_SERVER_MESHES_H_
