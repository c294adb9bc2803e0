// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bytes of whole updates at 10 segments: of our writer, and of libdraco on the same points in the
// same order, for two samples and the models in $LATTICED_SHARED/models under a jittered lattice.
// Every stream of ours is decoded and compared. Counters:
//
//   bytes_point, libdraco_bytes_point  over all chunks
//   percent                            how many more bytes ours take
//   chunks, larger, larger_bytes       all; those where ours takes more, and how much more there
//   tagged_chunks                      where libdraco picks its tagged scheme for an attribute
//   more_at_tagged, more_elsewhere     how many more bytes ours take in those, and in the others
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/codec/draco_decode.h"
#include "core/codec/draco_writer.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/sample_meshes.h"
#include "fmt/format.h"
#include "tests/bench/benches.h"
#include "tests/bench/scenario.h"

namespace latticed::bench {
namespace {

using Stream = std::vector<uint8_t>;

constexpr int kSegments = 10;

struct Model {
  std::string name;
  std::filesystem::path path;  // empty: a sample
};

struct Sums {
  size_t points = 0, ours = 0, libdraco = 0;
  size_t chunks = 0, larger = 0, larger_bytes = 0, tagged_chunks = 0;
  int64_t more_at_tagged = 0, more_elsewhere = 0;
};

PolygonMesh Load(const Model& model) {
  absl::StatusOr<PolygonMesh> mesh;
  if (model.path.empty()) {
    mesh = MakeSampleMesh(model.name);
  } else {
    std::ifstream file(model.path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    mesh = ReadMesh(MeshFormat::kObj, bytes);
  }
  CheckOk(mesh.status());
  return *std::move(mesh);
}

// Of the model that was asked for last.
const Scenario& ScenarioOf(const Model& model) {
  static auto* scenario = new std::optional<Scenario>;
  if (!scenario->has_value() || (*scenario)->name != model.name) {
    scenario->reset();
    *scenario = MakeScenario(model.name, std::make_shared<const PolygonMesh>(Load(model)),
                             {5, 5, 5}, {2, 2, 2});
  }
  return **scenario;
}

bool HoldsIntegers(const Stream& stream, const QuantisedVertices& v) {
  const auto decoded = DecodeDracoChunkIntegers(stream);
  if (!decoded.ok()) return false;
  const auto normal = [&](const uint8_t* plane, size_t p) {
    return v.normal_bits <= 8 ? plane[p] : plane[2 * p] | uint32_t{plane[2 * p + 1]} << 8;
  };
  for (size_t p = 0; p < v.point_count; ++p) {
    const uint32_t* position = &decoded->positions[3 * p];
    const uint32_t* its_normal = &decoded->normals[2 * p];
    if (position[0] != v.x[p] || position[1] != v.y[p] || position[2] != v.z[p] ||
        its_normal[0] != normal(v.s, p) || its_normal[1] != normal(v.t, p)) {
      return false;
    }
  }
  return true;
}

// Whether libdraco picked its tagged scheme for positions or normals of a cloud. A head takes 17
// bytes and 6 an attribute; prediction, its transform and whether symbols are coded come before the
// scheme; the dequantisation of positions, 17 bytes, comes last.
bool HasTaggedSymbols(const Stream& stream, const Stream& without_normals) {
  constexpr size_t kHead = 17, kAttribute = 6, kCoded = 2, kScheme = 3, kDequantisation = 17;
  const size_t positions = kHead + 2 * kAttribute;
  const size_t normals = positions + without_normals.size() - kHead - kAttribute - kDequantisation;
  const auto is_tagged = [&](size_t at) {
    return stream[at + kCoded] == 1 && stream[at + kScheme] == 0;
  };
  return is_tagged(positions) || is_tagged(normals);
}

void Add(const QuantisedVertices& vertices, const Stream& ours, double range, Sums& sums) {
  static const auto* reference = MakeReferenceEncoder().release();
  QuantisedVertices positions = vertices;
  positions.normal_bits = 0;
  const auto theirs = reference->EncodePoints(vertices, range);
  CheckOk(theirs.status());
  const auto without_normals = reference->EncodePoints(positions, range);
  CheckOk(without_normals.status());
  const bool tagged = HasTaggedSymbols(*theirs, *without_normals);
  const int64_t more = static_cast<int64_t>(ours.size()) - static_cast<int64_t>(theirs->size());
  sums.points += vertices.point_count;
  sums.ours += ours.size();
  sums.libdraco += theirs->size();
  ++sums.chunks;
  if (more > 0) ++sums.larger, sums.larger_bytes += static_cast<size_t>(more);
  if (tagged) ++sums.tagged_chunks;
  (tagged ? sums.more_at_tagged : sums.more_elsewhere) += more;
}

// A group of chunks at a time, as a backend has it.
absl::StatusOr<Sums> Count(const Scenario& scenario, const ViewSpec& spec) {
  const auto view = MakeView(scenario, Pipeline::kFused, spec, 1);
  const DracoWriter writer;
  Sums sums;
  for (size_t first = 0; first < scenario.all_chunks.size(); first += writer.batch()) {
    const size_t count = std::min(writer.batch(), scenario.all_chunks.size() - first);
    std::vector<Stream> bytes(count), streams(count);
    std::vector<QuantisedVertices> vertices;
    for (size_t i = 0; i < count; ++i) {
      const uint32_t chunk = scenario.all_chunks[first + i];
      const size_t points = ChunkPoints(*scenario.plan, chunk, spec.segments);
      bytes[i].resize(points * BytesPerPoint(spec));
      CheckOk(view->Read(chunk, bytes[i]));
      vertices.push_back(
          QuantisedVertices::FromBytes(bytes[i], points, spec.position_bits, spec.normal_bits));
    }
    CheckOk(writer.Encode(vertices, scenario.box.range, nullptr, streams));
    for (size_t i = 0; i < count; ++i) {
      if (!HoldsIntegers(streams[i], vertices[i])) {
        return absl::InternalError(fmt::format("chunk {} decodes to other integers", first + i));
      }
      Add(vertices[i], streams[i], scenario.box.range, sums);
    }
  }
  return sums;
}

void Compare(benchmark::State& state, const Model& model, const ViewSpec& spec) {
  absl::StatusOr<Sums> sums;
  for (auto _ : state) sums = Count(ScenarioOf(model), spec);
  if (!sums.ok()) {
    state.SkipWithError(std::string(sums.status().message()).c_str());
    return;
  }
  const auto ours = static_cast<double>(sums->ours), theirs = static_cast<double>(sums->libdraco);
  const auto points = static_cast<double>(sums->points);
  state.counters["bytes_point"] = ours / points;
  state.counters["libdraco_bytes_point"] = theirs / points;
  state.counters["percent"] = 100 * (ours / theirs - 1);
  state.counters["chunks"] = static_cast<double>(sums->chunks);
  state.counters["larger"] = static_cast<double>(sums->larger);
  state.counters["larger_bytes"] = static_cast<double>(sums->larger_bytes);
  state.counters["tagged_chunks"] = static_cast<double>(sums->tagged_chunks);
  state.counters["more_at_tagged"] = static_cast<double>(sums->more_at_tagged);
  state.counters["more_elsewhere"] = static_cast<double>(sums->more_elsewhere);
}

void RegisterModel(const Model& model) {
  for (const auto& [normals, name] :
       {std::pair{NormalMode::kFacet, "facet"}, {NormalMode::kSmooth, "smooth"}}) {
    for (const auto& [position_bits, normal_bits] :
         {std::pair{11, 8}, {12, 8}, {14, 10}, {16, 12}}) {
      const ViewSpec spec{.segments = kSegments,
                          .normals = normals,
                          .position_bits = position_bits,
                          .normal_bits = normal_bits};
      benchmark::RegisterBenchmark(
          fmt::format("codec/bytes/{}/{}/{}-{}", model.name, name, position_bits, normal_bits)
              .c_str(),
          [=](benchmark::State& state) { Compare(state, model, spec); })
          ->Iterations(1)
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace

void RegisterCodecBytesBenches() {
  for (const char* sample : {"knot", "vase"}) RegisterModel({sample, {}});
  const char* shared = std::getenv("LATTICED_SHARED");
  const auto folder = std::filesystem::path(shared == nullptr ? "../shared" : shared) / "models";
  for (const char* name : {"fandisk", "rocker-arm", "spot", "stanford-bunny", "teapot"}) {
    const auto path = folder / fmt::format("{}.obj", name);
    if (std::filesystem::exists(path)) RegisterModel({name, path});
  }
}

}  // namespace latticed::bench
