// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Views with a tolerance, through the stub: triangles within the certified error of EvaluatePoints, patterns once a
// stream, the same bytes after any edits as in a new update.
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "client/cpp/library/mesh.h"
#include "client/cpp/library/surface.h"
#include "fmt/format.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr uint32_t kSeed = 2014;
constexpr double kTolerance = 2e-3;  // the mesh is about 1 wide
constexpr v1::Encoding kEncodings[] = {v1::ENCODING_DRACO_POINTS, v1::ENCODING_DRACO_MESH,
                                       v1::ENCODING_RAW, v1::ENCODING_QUANTISED,
                                       v1::ENCODING_MESHOPT};

class ToleranceStreamTest : public SceneStreamTest {
 protected:
  static void SetTolerance(v1::ViewOptions& view, double tolerance = kTolerance) {
    view.set_tolerance(tolerance);
    view.set_segments(32);
  }
  v1::WatchRequest WatchBy(double tolerance, const std::string& editor = "alice") const {
    v1::WatchRequest watch = Watch(editor);
    SetTolerance(*watch.mutable_view(), tolerance);
    return watch;
  }
  v1::GetUpdateRequest UpdateBy(double tolerance, v1::Encoding encoding) const {
    auto request = For<v1::GetUpdateRequest>();
    SetTolerance(*request.mutable_view(), tolerance);
    request.mutable_view()->set_encoding(encoding);
    return request;
  }

  // Moves every control point at random, so that no patch is flat.
  void Bend() {
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> uniform(-0.1, 0.1);
    for (uint32_t point = 0; point < 125; ++point) {
      ASSERT_OK(Apply(Move(point + 1, point, uniform(random), "bender")));
    }
  }

  // The largest distance between random points of the triangles and the exact surface at the same barycentrics.
  double LargestDistance(const client::Surface& surface) {
    auto request = For<v1::GetTopologyRequest>();
    request.set_topology_id(surface.topology().topology_id());
    std::vector<v1::TopologyPart> parts;
    EXPECT_OK(ReadAll(&Scenes::GetTopology, request, &parts));
    EXPECT_EQ(parts.size(), 1u);
    const v1::TopologyPart& origin = parts.at(0);
    const auto layouts = surface.Layouts().value();
    const auto points = surface.Decode().value();
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> uniform(0, 1);
    double largest = 0;
    std::vector<Vec3d> chords;
    auto wanted = For<v1::EvaluatePointsRequest>();
    const auto compare = [&] {
      v1::EvaluatePointsResponse exact;
      EXPECT_OK(Call(&Scenes::EvaluatePoints, wanted, &exact));
      for (size_t i = 0; i < chords.size(); ++i) {
        const int at = 3 * static_cast<int>(i);
        const Vec3d position{exact.positions(at), exact.positions(at + 1), exact.positions(at + 2)};
        largest = std::max(largest, Norm(position - chords[i]));
      }
      chords.clear();
      wanted.clear_surface_points();
    };
    size_t first = 0;
    for (size_t patch = 0; patch < layouts.size(); ++patch) {
      const client::PatchLayout& layout = layouts[patch];
      for (size_t t = 0; t < layout.triangles.size(); t += 3) {
        double x = uniform(random), y = uniform(random);
        if (x + y > 1) x = 1 - x, y = 1 - y;
        const double weight[3] = {1 - x - y, x, y};
        Vec3d chord;
        double at[3] = {};
        for (size_t c = 0; c < 3; ++c) {
          const size_t point = layout.triangles[t + c];
          chord += weight[c] * points.positions[first + point];
          for (size_t k = 0; k < 3; ++k) {
            at[k] += weight[c] * layout.points[3 * point + k] / layout.denominator;
          }
        }
        chords.push_back(chord);
        *wanted.mutable_surface_points()->add_points() =
            SurfacePointOf(origin, static_cast<int>(patch), at);
        if (chords.size() == 4'096) compare();
      }
      first += layout.point_count();
    }
    if (!chords.empty()) compare();
    return largest;
  }
  static v1::SurfacePoint SurfacePointOf(const v1::TopologyPart& origin, int patch,
                                         const double* at) {
    v1::SurfacePoint point;
    point.set_face(origin.faces(patch));
    for (int k = 0; k < 3; ++k) {
      point.add_corners(origin.corners(3 * patch + k));
      double barycentric = 0;
      for (int c = 0; c < 3; ++c) {
        barycentric += at[c] * origin.barycentrics(9 * patch + 3 * c + k);
      }
      point.add_barycentrics(std::clamp(barycentric, 0.0, 1.0));
    }
    return point;
  }
  static client::Surface SurfaceOf(const EventLog& log) {
    client::Surface surface;
    for (const v1::SceneEvent& event : log.events) EXPECT_OK(surface.Apply(event));
    return surface;
  }
  // The stream has the same surface as a new update of the same view.
  void ExpectSameAsNew(const EventLog& log) {
    EventLog now;
    ASSERT_OK(Update(UpdateBy(kTolerance, v1::ENCODING_QUANTISED), now));
    EXPECT_TRUE(log.chunks == now.chunks);
    EXPECT_TRUE(log.levels == now.levels);
    EXPECT_EQ(log.ends.back().certified_error(), now.ends.back().certified_error());
  }
};

TEST_F(ToleranceStreamTest, TrianglesOfEveryEncodingAreWithinTheCertifiedError) {
  Bend();
  for (const v1::Encoding encoding : kEncodings) {
    for (const double tolerance : {2e-2, 2e-3, 2e-4}) {
      SCOPED_TRACE(fmt::format("{}, {}, seed {}", v1::Encoding_Name(encoding), tolerance, kSeed));
      EventLog log;
      ASSERT_OK(Update(UpdateBy(tolerance, encoding), log));

      const v1::Topology& topology = log.topologies.at(0);
      EXPECT_EQ(topology.segments(), 0);
      EXPECT_EQ(topology.point_count(), 0u);
      EXPECT_EQ(topology.triangle_count(), 0u);
      EXPECT_FALSE(topology.has_pattern());
      EXPECT_EQ(log.begins.at(0).view().tolerance(), tolerance);
      const double certified = log.ends.at(0).certified_error();
      EXPECT_GT(certified, 0);
      EXPECT_LE(certified, tolerance);
      const double largest = LargestDistance(SurfaceOf(log));
      EXPECT_LE(largest, certified);
      EXPECT_GT(largest, certified / 1'000) << "the surface is curved";
    }
  }
}

TEST_F(ToleranceStreamTest, ADracoMeshHasTheTrianglesOfThePatterns) {
  Bend();
  EventLog log;
  ASSERT_OK(Update(UpdateBy(kTolerance, v1::ENCODING_DRACO_MESH), log));
  const client::Surface surface = SurfaceOf(log);

  const auto mesh = client::AssembleMesh(surface.Layouts().value(), surface.Decode().value());

  ASSERT_OK(mesh);
  EXPECT_EQ(mesh->positions.size(), surface.PointCount());
  size_t triangles = 0;
  const auto layouts = surface.Layouts().value();
  for (const auto& layout : layouts) triangles += layout.triangle_count();
  EXPECT_EQ(mesh->triangles.size(), triangles);
  EXPECT_GT(log.patterns.size(), 5u) << "patches differ";
}

TEST_F(ToleranceStreamTest, TheTopologyIsTheSameForEveryTolerance) {
  EventLog coarse, fine, uniform;
  ASSERT_OK(Update(UpdateBy(1e-2, v1::ENCODING_RAW), coarse));
  ASSERT_OK(Update(UpdateBy(1e-3, v1::ENCODING_RAW), fine));
  ASSERT_OK(Update(4, kScene, &uniform));

  EXPECT_EQ(coarse.topologies.at(0).topology_id(), fine.topologies.at(0).topology_id());
  EXPECT_NE(coarse.topologies.at(0).topology_id(), uniform.topologies.at(0).topology_id());
  EXPECT_EQ(uniform.ends.at(0).certified_error(), 0);
}

TEST_F(ToleranceStreamTest, EditsGiveTheBytesOfANewUpdate) {
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  DeformClient client(*scenes_, WatchBy(kTolerance));
  client.ReadUntilRevision(0);
  size_t sent = 0;
  for (uint64_t i = 1; i <= 40; ++i) {
    ASSERT_TRUE(client.Send(Move(i, static_cast<uint32_t>(random() % 125), uniform(random))));
    client.ReadUntilRevision(i);
    sent += client.log.begins.back().chunk_count();
    SCOPED_TRACE(fmt::format("edit {}, seed {}", i, kSeed));
    ExpectSameAsNew(client.log);
  }
  EXPECT_LT(sent, 40 * client.log.chunks.size()) << "not all chunks change with each edit";
}

// EventLog fails the test if a stream sends a pattern twice, or none before its first use.
TEST_F(ToleranceStreamTest, PatternsComeAgainOnTheNextStream) {
  Bend();
  EventLog first;
  {
    WatchClient watcher(*scenes_, WatchBy(kTolerance));
    watcher.ReadUpdates(1);
    first = watcher.log;
    v1::ControlWatchRequest finer;
    SetTolerance(*finer.mutable_view(), kTolerance / 8);
    ASSERT_OK(Control(watcher, finer));
    watcher.ReadUpdates(2);
    EXPECT_GT(watcher.log.patterns.size(), first.patterns.size());
    ASSERT_OK(Control(watcher, [] {
      v1::ControlWatchRequest again;
      SetTolerance(*again.mutable_view());
      return again;
    }()));
    watcher.ReadUpdates(3);
    EXPECT_TRUE(watcher.log.chunks == first.chunks);
    EXPECT_TRUE(watcher.log.levels == first.levels);
  }
  WatchClient again(*scenes_, WatchBy(kTolerance));
  again.ReadUpdates(1);

  EXPECT_EQ(again.log.patterns.size(), first.patterns.size());
}

TEST_F(ToleranceStreamTest, AResumedStreamSendsOnlyWhatChanged) {
  Bend();
  v1::WatchRequest watch = WatchBy(kTolerance);
  EventLog before;
  {
    WatchClient watcher(*scenes_, watch);
    watcher.ReadUpdates(1);
    before = watcher.log;
  }
  ASSERT_OK(Apply(Move(1, 0, 0.01)));
  watch.set_resume_token(before.ends.back().resume_token());
  WatchClient resumed(*scenes_, watch);
  resumed.ReadUpdates(1);

  EXPECT_TRUE(resumed.log.hello.resumed());
  EXPECT_LT(resumed.log.begins.back().chunk_count(), before.chunks.size());
  EventLog whole = before;
  for (const auto& [index, data] : resumed.log.chunks) whole.chunks[index] = data;
  for (const auto& [index, levels] : resumed.log.levels) whole.levels[index] = levels;
  whole.ends = resumed.log.ends;
  ExpectSameAsNew(whole);
}

TEST_F(ToleranceStreamTest, ATokenOfAnotherToleranceResumesNothing) {
  WatchClient watcher(*scenes_, WatchBy(kTolerance));
  watcher.ReadUpdates(1);
  v1::WatchRequest watch = WatchBy(2 * kTolerance);
  watch.set_resume_token(watcher.log.ends.back().resume_token());
  WatchClient other(*scenes_, watch);
  other.ReadUpdates(1);

  EXPECT_FALSE(other.log.hello.resumed());
}

TEST_F(ToleranceStreamTest, PositionBitsLeaveTwoThirdsToCurvature) {
  EventLog log;
  ASSERT_OK(Update(UpdateBy(kTolerance, v1::ENCODING_QUANTISED), log));
  const int bits = log.begins.at(0).view().position_bits();
  ASSERT_GT(bits, 9);
  ASSERT_LT(bits, 16);
  EXPECT_EQ(log.quantisations.at(0).bits(), bits);
  // Half the diagonal of a cell of the grid. The float32 points have a small part too.
  const double rounding = std::sqrt(3.0) / 2 * log.quantisations.at(0).step();
  EXPECT_LT(rounding, kTolerance / 3);
  EXPECT_GT(2 * rounding, 0.99 * kTolerance / 3) << "a bit less would do";
}

TEST_F(ToleranceStreamTest, PositionBitsThatCannotMeetItAreRefused) {
  EventLog log, none, fewest;
  ASSERT_OK(Update(UpdateBy(kTolerance, v1::ENCODING_QUANTISED), log));
  // One bit less than is chosen doubles the rounding to two thirds at most. That still meets the tolerance.
  const int least = log.begins.at(0).view().position_bits() - 1;

  v1::GetUpdateRequest request = UpdateBy(kTolerance, v1::ENCODING_QUANTISED);
  request.mutable_view()->set_position_bits(least - 1);
  ExpectRefusal(Update(request, none), {.reason = "OUT_OF_RANGE",
                                        .field = "view.position_bits",
                                        .message = fmt::format("got {}, a tolerance of {} needs {}",
                                                               least - 1, kTolerance, least)});
  request.mutable_view()->set_position_bits(least);
  ASSERT_OK(Update(request, fewest));
  EXPECT_EQ(fewest.quantisations.at(0).bits(), least);
  EXPECT_LE(fewest.ends.at(0).certified_error(), kTolerance);
}

// Segments allow as many points as they would give, and the certified error says what that costs.
TEST_F(ToleranceStreamTest, SegmentsLimitThePoints) {
  Bend();
  const uint64_t patches = Get().patches();
  auto request = UpdateBy(2e-4, v1::ENCODING_QUANTISED);
  request.mutable_view()->set_segments(2);
  EventLog log;
  ASSERT_OK(Update(request, log));

  const client::Surface surface = SurfaceOf(log);
  EXPECT_LE(surface.PointCount(), 6 * patches);
  EXPECT_GT(log.ends.at(0).certified_error(), 2e-4);
  EXPECT_LE(LargestDistance(surface), log.ends.at(0).certified_error());
}

TEST_F(ToleranceStreamTest, MaxPointsDoubleItWhileEditsCome) {
  Bend();
  EventLog whole;
  ASSERT_OK(Update(UpdateBy(2e-4, v1::ENCODING_QUANTISED), whole));
  const uint64_t points = SurfaceOf(whole).PointCount(), most = points / 2;
  v1::WatchRequest watch = WatchBy(2e-4);
  watch.mutable_view()->set_max_points(most);
  DeformClient client(*scenes_, watch);
  client.ReadUpdates(1);
  const uint64_t revision = client.log.ends.back().revision();
  uint64_t sequence = 0;
  while (client.log.ends.back().full_detail()) {
    ASSERT_LT(++sequence, 1'000u) << "detail never falls";
    ASSERT_TRUE(client.Send(Move(sequence, 62, sequence % 2 == 0 ? 0.01 : -0.01)));
    client.ReadUntilRevision(revision + sequence);
  }

  EXPECT_LE(SurfaceOf(client.log).PointCount(), most);
  EXPECT_GT(client.log.ends.back().certified_error(), 2e-4);
  client.ReadUntil([&] { return client.log.ends.back().full_detail(); });
  EXPECT_LE(client.log.ends.back().certified_error(), 2e-4);
}

TEST_F(ToleranceStreamTest, ADefaultViewHasIt) {
  v1::CreateSceneRequest request = SceneRequest("by-tolerance");
  request.mutable_default_view()->set_tolerance(kTolerance);
  v1::Scene scene;
  ASSERT_OK(Create(request, &scene));
  EXPECT_EQ(scene.default_view().tolerance(), kTolerance);
  EXPECT_EQ(scene.default_view().position_bits(), 0) << "chosen when a view is asked for";

  EventLog log, uniform;
  ASSERT_OK(Update(For<v1::GetUpdateRequest>("by-tolerance"), log));
  ASSERT_OK(Update(3, "by-tolerance", &uniform));
  EXPECT_LE(log.ends.at(0).certified_error(), kTolerance);
  EXPECT_GT(log.begins.at(0).view().position_bits(), 0);
  EXPECT_EQ(uniform.topologies.at(0).segments(), 3) << "segments alone ask for a uniform view";
  EXPECT_EQ(uniform.begins.at(0).view().tolerance(), 0);
  EXPECT_EQ(uniform.begins.at(0).view().position_bits(), 12);
}

TEST_F(ToleranceStreamTest, AllPipelinesHaveIt) {
  for (const v1::Pipeline pipeline :
       {v1::PIPELINE_GEMM, v1::PIPELINE_GEMM12, v1::PIPELINE_CONTROL_NET}) {
    v1::CreateSceneRequest create = SceneRequest(fmt::format("by-products-{}", int{pipeline}));
    create.mutable_diagnostics()->set_pipeline(pipeline);
    ASSERT_OK(Create(create));
    auto request = UpdateBy(kTolerance, v1::ENCODING_RAW);
    request.set_scene(create.scene_id());
    EventLog log;
    ASSERT_OK(Update(request, log));
    EXPECT_GT(log.ends.at(0).certified_error(), 0);
    EXPECT_LE(log.ends.at(0).certified_error(), kTolerance);
  }
}

}  // namespace
}  // namespace latticed::testing
