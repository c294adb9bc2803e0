// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Delivery of finished chunks by the real server over loopback, on one stream, to a client that
// parses nothing. The view's vertices exist already, so nothing is evaluated.
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "client/cpp/library/latticed_client.h"
#include "core/mesh/write/write_mesh.h"
#include "fmt/format.h"
#include "server/in_process.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr char kMethod[] = "/latticed.v1.SceneService/GetUpdate";
constexpr size_t kChunkMessage = size_t{64} << 10;  // smaller messages carry no chunks

void SetAxes(int value, v1::LatticeAxes& axes) {
  axes.set_u(value);
  axes.set_v(value);
  axes.set_w(value);
}

// A server with one scene, 27 MB of raw vertices, and a stream that keeps its view evaluated.
class Delivery {
 public:
  Delivery() {
    server_ = Checked(InProcessServer::Start({.backend = "cpu", .log_level = "warn"}));
    channel_ = server_->channel();
    client::Client client(channel_, "");
    v1::MeshHeader header;
    header.set_format(v1::MESH_FORMAT_OBJ);
    const auto mesh = Checked(client.UploadMesh(WriteObj(*SmallScenario(2).plan->mesh), header));
    v1::CreateSceneRequest create;
    create.set_mesh(mesh.id());
    auto* fit = create.add_lattices()->mutable_fit();
    SetAxes(7, *fit->mutable_size());
    SetAxes(2, *fit->mutable_degree());
    const auto scene = Checked(client.CreateScene(create));
    request_.set_scene(scene.id());
    request_.mutable_view()->set_encoding(v1::ENCODING_RAW);
    request_.mutable_view()->set_normals(v1::NORMAL_MODE_FACET);
    v1::WatchRequest watch;
    watch.set_scene(scene.id());
    *watch.mutable_view() = request_.view();
    watch_ = Checked(client.Deform(watch));
  }

  // Reads one whole update. Counts time and bytes after its first message of chunks.
  struct Read {
    double seconds = 0;
    size_t bytes = 0;
  };
  Read ReadUpdate() {
    grpc::ClientContext context;
    grpc::CompletionQueue queue;
    auto call = grpc::GenericStub(channel_).PrepareCall(&context, kMethod, &queue);
    call->StartCall(nullptr);
    Next(queue);
    call->WriteLast(Serialised(), grpc::WriteOptions(), nullptr);
    Next(queue);
    Read read;
    Clock::time_point first;
    grpc::ByteBuffer message;
    for (call->Read(&message, nullptr); Next(queue); call->Read(&message, nullptr)) {
      if (first != Clock::time_point()) {
        read.bytes += message.Length();
      } else if (message.Length() > kChunkMessage) {
        first = Clock::now();
      }
    }
    read.seconds = std::chrono::duration<double>(Clock::now() - first).count();
    grpc::Status status;
    call->Finish(&status, nullptr);
    Next(queue);
    if (!status.ok()) CheckOk(absl::InternalError(status.error_message()));
    return read;
  }

 private:
  static bool Next(grpc::CompletionQueue& queue) {
    void* tag = nullptr;
    bool ok = false;
    return queue.Next(&tag, &ok) && ok;
  }

  grpc::ByteBuffer Serialised() const {
    const grpc::Slice slice(request_.SerializeAsString());
    return {&slice, 1};
  }

  std::unique_ptr<InProcessServer> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<client::DeformStream> watch_;  // keeps the view evaluated
  v1::GetUpdateRequest request_;
};

void RawChunks(benchmark::State& state) {
  Delivery delivery;
  delivery.ReadUpdate();
  size_t bytes = 0;
  double seconds = 0;
  for (auto _ : state) {
    const Delivery::Read read = delivery.ReadUpdate();
    state.SetIterationTime(read.seconds);
    bytes += read.bytes;
    seconds += read.seconds;
  }
  state.counters["GB_s"] = static_cast<double>(bytes) * 1e-9 / seconds;
}

}  // namespace

void RegisterDeliveryBenches() {
  benchmark::RegisterBenchmark("delivery/raw-chunks", RawChunks)
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime()
      ->Iterations(20)
      ->Repetitions(5);
}

}  // namespace latticed::bench
