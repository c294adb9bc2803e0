// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scene that a command makes for itself on a server that it shares, and the mesh in it: both
// are deleted again at the end, also after an error or an interruption. Of a mesh only the one that
// this command brought.
//
//   TemporaryScene made(client);
//   const auto mesh = made.Upload(file, {}, console);
//   const auto scene = made.Create(request);
//
// Errors   the server's
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LATTICECTL_TEMPORARY_SCENE_H_
#define LATTICED_CLIENT_CPP_LATTICECTL_TEMPORARY_SCENE_H_

#include <string>

#include "absl/status/statusor.h"
#include "client/cpp/latticectl/console.h"
#include "client/cpp/latticectl/files.h"
#include "client/cpp/library/latticed_client.h"

namespace latticed::client {

class TemporaryScene {
 public:
  explicit TemporaryScene(Client& client) : client_(client) {}
  ~TemporaryScene();
  TemporaryScene(const TemporaryScene&) = delete;  // deletes once
  TemporaryScene& operator=(const TemporaryScene&) = delete;

  // With a progress bar.
  [[nodiscard]] absl::StatusOr<v1::Mesh> Upload(const MeshFile& file, v1::MeshHeader header,
                                                Console console);
  // Of the uploaded mesh: scene_id and mesh are filled in.
  [[nodiscard]] absl::StatusOr<v1::Scene> Create(v1::CreateSceneRequest request);
  // Neither is deleted: the scene is there to stay.
  void Keep();

 private:
  Client& client_;
  std::string mesh_;
  std::string mesh_to_delete_, scene_to_delete_;  // empty: none
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LATTICECTL_TEMPORARY_SCENE_H_
