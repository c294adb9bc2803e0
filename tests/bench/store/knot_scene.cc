// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/store/knot_scene.h"

#include "core/mesh/sample_meshes.h"
#include "core/mesh/write/write_mesh.h"
#include "fmt/format.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

constexpr uint32_t kAcross = 8;

}  // namespace

std::string UploadKnot(client::Client& client) {
  v1::MeshHeader header;
  header.set_format(v1::MESH_FORMAT_OBJ);
  return Checked(client.UploadMesh(WriteObj(Checked(MakeSampleMesh("knot"))), header)).id();
}

void CreateKnotScene(client::Client& client, const std::string& mesh, const std::string& scene) {
  v1::CreateSceneRequest request;
  request.set_scene_id(scene);
  request.set_mesh(mesh);
  v1::LatticeAxes& size = *request.add_lattices()->mutable_fit()->mutable_size();
  size.set_u(kAcross);
  size.set_v(kAcross);
  size.set_w(kAcross);
  CheckOk(client.CreateScene(request).status());
}

}  // namespace latticed::bench
