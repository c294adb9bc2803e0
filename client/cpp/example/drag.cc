// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// usage: [LATTICED_SERVER=ADDRESS] drag IN.obj OUT.ply
// Uploads a mesh, lifts the top of the lattice around it by 1 in one gesture of ten steps, prints the
// size of each update, and exports the deformed surface.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "latticed/client/cpp/latticed_client.h"

namespace {

namespace v1 = latticed::v1;
using latticed::client::Client;
using latticed::client::Surface;

constexpr int kSteps = 10;

// Returns the value, or prints the error and ends the program.
template <typename T>
T OrExit(absl::StatusOr<T> result) {
  if (result.ok()) return *std::move(result);
  std::cerr << "drag: " << result.status() << '\n';
  std::exit(1);
}

v1::Mesh Upload(Client& client, const char* path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  v1::MeshHeader header;
  header.set_name(path);
  header.set_format(v1::MESH_FORMAT_OBJ);
  return OrExit(client.UploadMesh(bytes, header));
}

// Moves the top layer of control points by `height` from where it was when the gesture began.
v1::EditBatch Lift(const v1::Lattice& lattice, double height) {
  v1::EditBatch batch;
  batch.set_gesture_id("lift");
  v1::MoveControlPoints& move = *batch.add_edits()->mutable_move_control_points();
  const int layer = lattice.size().u() * lattice.size().v();
  const int top = layer * (lattice.size().w() - 1);
  for (int i = 0; i < layer; ++i) move.add_indices(static_cast<uint32_t>(top + i));
  move.mutable_offset()->set_z(height);
  return batch;
}

double Highest(const Surface& surface) {
  double highest = std::numeric_limits<double>::lowest();
  for (const auto& point : OrExit(surface.Decode()).positions) highest = std::max(highest, point.z);
  return highest;
}

void Drag(Client& client, const v1::Scene& scene) {
  v1::WatchRequest watch;
  watch.set_scene(scene.id());
  const auto stream = OrExit(client.Deform(watch));
  const Surface& surface = stream->surface();
  const v1::Lattice lattice = surface.lattice().lattice();
  std::cout << "at rest up to " << Highest(surface) << '\n';
  for (int step = 1; step <= kSteps; ++step) {
    v1::EditBatch batch = Lift(lattice, 1.0 * step / kSteps);
    if (step == kSteps) batch.set_gesture_phase(v1::GESTURE_PHASE_COMMIT);
    const uint64_t sequence = OrExit(stream->Send(std::move(batch)));
    const auto update = OrExit(stream->WaitFor(sequence));
    std::cout << "revision " << update.end.revision() << ": " << update.chunk_count << " chunks, "
              << update.bytes << " bytes, up to " << Highest(surface) << '\n';
  }
}

void Export(Client& client, const v1::Scene& scene, const char* path) {
  v1::ExportRequest request;
  request.set_scene(scene.id());
  request.set_format(v1::EXPORT_FORMAT_PLY);
  const auto file = OrExit(client.Export(request));
  std::ofstream(path, std::ios::binary) << file.bytes;
  std::cout << "written " << path << ", revision " << file.header.revision() << '\n';
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: [LATTICED_SERVER=ADDRESS] drag IN.obj OUT.ply\n";
    return 2;
  }
  const char* server = std::getenv("LATTICED_SERVER");
  const auto client = Client::Connect({.address = server == nullptr ? "127.0.0.1:50151" : server});

  v1::CreateSceneRequest request;
  request.set_mesh(Upload(*client, argv[1]).id());
  const v1::Scene scene =
      OrExit(client->CreateScene(request));  // 4 x 4 x 4 control points, degree 2
  Drag(*client, scene);
  Export(*client, scene, argv[2]);
  const absl::Status deleted = client->DeleteScene(scene.id());
  if (!deleted.ok()) std::cerr << "drag: " << deleted << '\n';
  return deleted.ok() ? 0 : 1;
}
