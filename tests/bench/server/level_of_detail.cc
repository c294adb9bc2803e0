// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// level_of_detail HOST:PORT MAX_BYTES_PER_SECOND
//
// Drags every second control point of a scene of 17,119 patches, so that all chunks change, at 60
// edits per second. Measures what a watcher gets over the link to the server: complete updates per
// second while dragging, and the time from the last edit to full detail. It does so for a gesture
// that is committed, and for edits that just stop. Fails if the final chunks differ in a byte from
// GetUpdate's, below 20 updates per second, or above 300 ms. level_of_detail.sh makes the link.
#include <grpcpp/grpcpp.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/cpp/library/latticed_client.h"
#include "core/base/mutex.h"
#include "core/mesh/write/write_mesh.h"
#include "fmt/format.h"
#include "latticed/v1/scene.grpc.pb.h"
#include "server/wire/converters.h"
#include "tests/bench/exact_mesh.h"

namespace latticed::bench {
namespace {

constexpr size_t kPatches = 17'119;
constexpr double kLeastUpdatesPerSecond = 20;
constexpr absl::Duration kMostUntilFullDetail = absl::Milliseconds(300);
constexpr absl::Duration kEditInterval = absl::Microseconds(16'667);
constexpr absl::Duration kWarmUp = absl::Seconds(1), kMeasured = absl::Seconds(4);

using Chunks = std::map<uint32_t, std::string>;

void Require(bool held, std::string_view what) {
  if (held) return;
  fmt::print(stderr, "level_of_detail: {}\n", what);
  std::exit(1);
}

void CheckOk(const absl::Status& status) { Require(status.ok(), status.ToString()); }

struct Update {
  absl::Time time;
  v1::UpdateEnd end;
  int segments = 0;
  size_t bytes = 0;
};

// A Deform stream. A thread receives its events and acknowledges updates.
class Watch {
 public:
  Watch(v1::SceneService::Stub& stub, v1::WatchRequest request) : stream_(stub.Deform(&context_)) {
    v1::DeformRequest open;
    *open.mutable_watch() = std::move(request);
    Send(open);
    reader_ = std::thread([this] { Read(); });
  }
  ~Watch() {
    context_.TryCancel();
    reader_.join();
  }

  void Send(const v1::DeformRequest& request) {
    const MutexLock lock(&write_mutex_);
    stream_->Write(request);
  }
  // Waits for full detail of the edit with this sequence number.
  Update WaitForFullDetail(uint64_t sequence) {
    const MutexLock lock(&mutex_);
    const auto here = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      if (updates_.empty()) return ended_;
      const v1::UpdateEnd& end = updates_.back().end;
      const bool all = end.full_detail() && end.applied_sequence() == sequence &&
                       end.revision() == end.head_revision();
      return all || ended_;
    };
    Require(mutex_.AwaitFor(here, absl::Seconds(30)) && !ended_, "full detail never came");
    return updates_.back();
  }
  std::vector<Update> Between(absl::Time begin, absl::Time end) {
    const MutexLock lock(&mutex_);
    std::vector<Update> some;
    for (const Update& update : updates_) {
      if (update.time >= begin && update.time < end) some.push_back(update);
    }
    return some;
  }
  Chunks chunks() {
    const MutexLock lock(&mutex_);
    return chunks_;
  }

 private:
  void Read() {
    v1::SceneEvent event;
    Update update;
    while (stream_->Read(&event)) {
      if (event.has_update_begin()) {
        update = {};
        update.segments = event.update_begin().view().segments();
        staged_.clear();
      }
      for (const v1::Chunk& chunk : event.chunks().chunks()) {
        update.bytes += chunk.data().size();
        staged_[chunk.index()] = chunk.data();
      }
      if (!event.has_update_end()) continue;
      update.time = absl::Now();
      update.end = event.update_end();
      v1::DeformRequest ack;
      ack.mutable_control()->set_acked_update_id(update.end.update_id());
      Send(ack);
      const MutexLock lock(&mutex_);
      for (auto& [index, data] : staged_) chunks_[index] = std::move(data);
      updates_.push_back(update);
    }
    const MutexLock lock(&mutex_);
    ended_ = true;
  }

  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::DeformRequest, v1::SceneEvent>> stream_;
  Mutex write_mutex_;
  Mutex mutex_;
  std::vector<Update> updates_ ABSL_GUARDED_BY(mutex_);
  Chunks chunks_ ABSL_GUARDED_BY(mutex_);
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
  Chunks staged_;  // used by the reader thread only
  std::thread reader_;
};

class LevelOfDetailRun {
 public:
  LevelOfDetailRun(const std::string& address, uint64_t max_bytes_per_second)
      : channel_(grpc::CreateChannel(address, grpc::InsecureChannelCredentials())),
        stub_(v1::SceneService::NewStub(channel_)) {
    const auto plan = MakeExactPlan(kPatches, {2, 2, 2});
    CheckOk(plan.status());
    client::Client client(channel_, "");
    v1::MeshHeader header;
    header.set_format(v1::MESH_FORMAT_OBJ);
    const auto mesh = client.UploadMesh(WriteObj(*(*plan)->mesh), header);
    CheckOk(mesh.status());
    const Lattice lattice{(*plan)->structure, IdentityControlPoints((*plan)->structure)};
    points_ = static_cast<uint32_t>(lattice.control_points.size());
    reach_ = 0.05 * lattice.structure.frame.edges[0].x;
    v1::CreateSceneRequest create;
    create.set_mesh(mesh->id());
    *create.add_lattices()->mutable_lattice() = ToProto(lattice);
    const auto scene = client.CreateScene(create);
    CheckOk(scene.status());
    Require(scene->patches() == kPatches, fmt::format("{} patches", scene->patches()));
    watch_.set_scene(scene->id());
    watch_.set_editor_id(client::RandomEditorId());
    watch_.mutable_view()->set_max_bytes_per_second(max_bytes_per_second);
  }

  // Drags in one gesture, or by edits without one. Returns whether both limits are kept.
  bool Drag(bool gesture) {
    Watch watch(*stub_, watch_);
    watch.WaitForFullDetail(sequence_);
    const absl::Time begin = absl::Now();
    const absl::Time end = begin + kWarmUp + kMeasured;
    absl::Time next = begin;
    while (next < end) {
      watch.Send(Edit(gesture, v1::GESTURE_PHASE_UPDATE));
      next += kEditInterval;
      absl::SleepFor(next - absl::Now());
    }
    const absl::Time last = absl::Now();
    watch.Send(Edit(gesture, v1::GESTURE_PHASE_COMMIT));
    const Update full = watch.WaitForFullDetail(sequence_);

    const std::vector<Update> updates = watch.Between(begin + kWarmUp, end);
    Require(!updates.empty(), "no update while dragging");
    size_t bytes = 0;
    for (const Update& update : updates) bytes += update.bytes;
    const double rate = static_cast<double>(updates.size()) / absl::ToDoubleSeconds(kMeasured);
    const absl::Duration until_full = full.time - last;
    fmt::print(
        "{:20} {:5.1f} updates/s at {} segments, {:4} KB each; full detail ({} segments, {} KB) "
        "{:3.0f} ms after the last edit\n",
        gesture ? "committed gesture:" : "edits that stop:", rate, updates.back().segments,
        bytes / updates.size() / 1000, full.segments, full.bytes / 1000,
        absl::ToDoubleMilliseconds(until_full));
    Require(watch.chunks() == Fresh(), "the surface is not what GetUpdate gives");
    return rate >= kLeastUpdatesPerSecond && until_full <= kMostUntilFullDetail;
  }

 private:
  // Moves every second control point to and fro.
  v1::DeformRequest Edit(bool gesture, v1::GesturePhase phase) {
    v1::DeformRequest request;
    v1::EditBatch& batch = *request.mutable_edit();
    batch.set_structure_id(1);
    batch.set_sequence(++sequence_);
    if (gesture) {
      batch.set_gesture_id("drag");
      batch.set_gesture_phase(phase);
    }
    auto& move = *batch.add_edits()->mutable_move_control_points();
    for (uint32_t i = 1; i < points_; i += 2) move.add_indices(i);
    const double swing = std::sin(0.1 * static_cast<double>(sequence_));
    move.mutable_offset()->set_z(gesture ? reach_ * swing : 0.1 * reach_ * swing);
    return request;
  }
  Chunks Fresh() {
    grpc::ClientContext context;
    v1::GetUpdateRequest request;
    request.set_scene(watch_.scene());
    const auto reader = stub_->GetUpdate(&context, request);
    Chunks chunks;
    v1::SceneEvent event;
    while (reader->Read(&event)) {
      for (const v1::Chunk& chunk : event.chunks().chunks()) chunks[chunk.index()] = chunk.data();
    }
    Require(reader->Finish().ok(), "GetUpdate failed");
    return chunks;
  }

  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::SceneService::Stub> stub_;
  v1::WatchRequest watch_;
  uint32_t points_ = 0;
  double reach_ = 0;
  uint64_t sequence_ = 0;
};

int Main(int argc, char** argv) {
  uint64_t rate = 0;
  const std::string_view number = argc == 3 ? argv[2] : "";
  std::from_chars(number.data(), number.data() + number.size(), rate);
  Require(rate > 0, "usage: level_of_detail HOST:PORT MAX_BYTES_PER_SECOND");
  LevelOfDetailRun run(argv[1], rate);
  const bool gesture = run.Drag(/*gesture=*/true);
  const bool edits = run.Drag(/*gesture=*/false);
  if (gesture && edits) return 0;
  fmt::print("missed: {} updates/s, full detail within {} ms\n", kLeastUpdatesPerSecond,
             absl::ToInt64Milliseconds(kMostUntilFullDetail));
  return 1;
}

}  // namespace
}  // namespace latticed::bench

int main(int argc, char** argv) { return latticed::bench::Main(argc, argv); }
