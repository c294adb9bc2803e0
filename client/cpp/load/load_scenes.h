// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// The scenes of a load on a server that it shares, deleted at its end with the meshes that it
// brought.
//
// Errors   the server's
// Threads  one at a time
#ifndef LATTICED_CLIENT_CPP_LOAD_LOAD_SCENES_H_
#define LATTICED_CLIENT_CPP_LOAD_LOAD_SCENES_H_

#include <memory>
#include <vector>

#include "client/cpp/latticectl/temporary_scene.h"
#include "client/cpp/load/scene_load.h"

namespace latticed::client {

class LoadScenes {
 public:
  explicit LoadScenes(Client& client) : client_(client) {}
  LoadScenes(const LoadScenes&) = delete;  // deletes once
  LoadScenes& operator=(const LoadScenes&) = delete;
  // The last one goes first: a mesh goes with the scene that brought it, when no other has it.
  ~LoadScenes() {
    while (!made_.empty()) made_.pop_back();
  }

  // One scene more, of a mesh that may be there already.
  [[nodiscard]] absl::Status Make(MeshFile mesh, const v1::CreateSceneRequest& request,
                                  Console console);
  const std::vector<LoadScene>& scenes() const { return scenes_; }

 private:
  Client& client_;
  std::vector<std::unique_ptr<TemporaryScene>> made_;
  std::vector<LoadScene> scenes_;
};

}  // namespace latticed::client

#endif  // LATTICED_CLIENT_CPP_LOAD_LOAD_SCENES_H_
