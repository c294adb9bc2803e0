// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "client/cpp/library/surface.h"

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/cpp/library/mesh.h"
#include "core/codec/chunk_encoder.h"
#include "core/codec/octahedral.h"
#include "tests/client/surface_events.h"
#include "tests/support/encode_chunk.h"
#include "tests/support/status_matchers.h"

namespace latticed::client {
namespace {

using latticed::testing::StatusIs;
using testing::ApplyOk;
using testing::ApplyUpdate;
using testing::BeginEvent;
using testing::ChunkEvent;
using testing::DracoChunk;
using testing::EndEvent;
using testing::QuantisationEvent;
using testing::QuantisedChunk;
using testing::RawChunk;
using testing::TopologyEvent;

// Expects the points of chunks that begin at 10 and 20, times `step`.
void ExpectPoints(const Surface& surface, double step) {
  const auto points = surface.Decode();
  ASSERT_OK(points);
  ASSERT_EQ(points->positions.size(), 6u);
  for (size_t i = 0; i < 6; ++i) {
    const double x = (i < 3 ? 10.0 : 17.0) + static_cast<double>(i);
    EXPECT_EQ(points->positions[i],
              (Vec3d{1000 + step * x, -8 + step * 2 * x, 0.5 + step * 3 * x}));
    EXPECT_EQ(points->normals[i], (Vec3f{0, 0, 1}));
  }
}

TEST(Surface, DecodesEveryEncoding) {
  struct Case {
    v1::Encoding encoding;
    std::string first, second;
    double step;
  };
  for (const auto& [encoding, first, second, step] :
       {Case{v1::ENCODING_RAW, RawChunk(10), RawChunk(20), 1.0},
        Case{v1::ENCODING_QUANTISED, QuantisedChunk(10), QuantisedChunk(20), 0.25},
        Case{v1::ENCODING_DRACO_POINTS, DracoChunk(10), DracoChunk(20), 0.25}}) {
    SCOPED_TRACE(encoding);
    Surface surface;
    ApplyUpdate(surface, encoding, first, second);
    ExpectPoints(surface, step);
    EXPECT_EQ(surface.revision(), 7u);
  }
}

TEST(Surface, DecodesOneChunk) {
  Surface surface;
  EXPECT_THAT(surface.Decode(std::array<uint32_t, 1>{0}),
              StatusIs(absl::StatusCode::kFailedPrecondition));
  ApplyUpdate(surface, v1::ENCODING_RAW, RawChunk(10), RawChunk(20));
  EXPECT_EQ(surface.chunk_count(), 2u);
  EXPECT_EQ(surface.PatchesOf(1).first, 1u);
  EXPECT_EQ(surface.PatchesOf(1).count, 1u);
  const auto points = surface.Decode(std::array<uint32_t, 1>{1});
  ASSERT_OK(points);
  ASSERT_EQ(points->positions.size(), 3u);
  EXPECT_EQ(points->positions[0], (Vec3d{1020, 32, 60.5}));
  EXPECT_THAT(surface.Decode(std::array<uint32_t, 1>{2}),
              StatusIs(absl::StatusCode::kInvalidArgument));
}

TEST(Surface, APartialUpdateDoesNotCount) {
  Surface surface;
  ApplyUpdate(surface, v1::ENCODING_RAW, RawChunk(10), RawChunk(20));
  ApplyOk(surface, BeginEvent(2, 1, v1::ENCODING_RAW));
  ApplyOk(surface, ChunkEvent(2, 0, RawChunk(99)));
  ExpectPoints(surface, 1.0);

  // A new update discards the one that has begun.
  ApplyOk(surface, BeginEvent(3, 0, v1::ENCODING_RAW));
  const auto update = surface.Apply(EndEvent(3, 8));
  ASSERT_OK(update);
  ExpectPoints(surface, 1.0);
  EXPECT_EQ(surface.revision(), 8u);
}

TEST(Surface, ContradictionsAreDataLoss) {
  const auto data_loss = StatusIs(absl::StatusCode::kDataLoss);
  Surface surface;
  EXPECT_THAT(surface.Apply(ChunkEvent(1, 0, RawChunk(1))), data_loss);
  EXPECT_THAT(surface.Apply(EndEvent(1, 1)), data_loss);
  ApplyOk(surface, BeginEvent(1, 2, v1::ENCODING_RAW));
  EXPECT_THAT(surface.Apply(ChunkEvent(1, 0, RawChunk(1))), data_loss);  // no quantisation
  ApplyOk(surface, QuantisationEvent());
  ApplyOk(surface, ChunkEvent(1, 0, RawChunk(1)));
  EXPECT_THAT(surface.Apply(EndEvent(1, 1)), data_loss);  // one chunk of two
  ApplyOk(surface, ChunkEvent(1, 5, RawChunk(1)));
  EXPECT_THAT(surface.Apply(EndEvent(1, 1)), data_loss);  // no topology
  ApplyOk(surface, TopologyEvent());
  EXPECT_THAT(surface.Apply(EndEvent(1, 1)), data_loss);  // chunk 5 of 2
}

TEST(Surface, ChunksOfBothWritersAreDecodedTogether) {
  Surface surface;
  ApplyUpdate(surface, v1::ENCODING_DRACO_POINTS, DracoChunk(10, "latticed"),
              DracoChunk(20, "reference"));
  ExpectPoints(surface, 0.25);
}

TEST(Surface, ChunksWithoutTheNormalsOfTheirViewAreDataLoss) {
  const std::string data = QuantisedChunk(10);
  const auto vertices = QuantisedVertices::FromBytes(
      {reinterpret_cast<const uint8_t*>(data.data()), data.size()}, 3, 12, 0);
  ASSERT_OK_AND_ASSIGN(
      const auto stream,
      latticed::testing::EncodePoints(*MakeChunkEncoder("latticed"), vertices, 4095 * 0.25));
  const std::string chunk(stream.begin(), stream.end());
  for (const int normal_bits : {8, 0}) {
    Surface surface;
    ApplyOk(surface, TopologyEvent());
    v1::SceneEvent grid = QuantisationEvent();
    grid.mutable_quantisation()->set_normal_bits(normal_bits);
    ApplyOk(surface, grid);
    ApplyOk(surface, BeginEvent(1, 2, v1::ENCODING_DRACO_POINTS));
    for (const uint32_t index : {0u, 1u}) ApplyOk(surface, ChunkEvent(1, index, chunk));
    ASSERT_OK(surface.Apply(EndEvent(1, 7)));
    EXPECT_THAT(surface.Decode(), StatusIs(absl::StatusCode::kDataLoss)) << normal_bits;
  }
}

TEST(Surface, ChunksOfAWrongSizeAreDataLoss) {
  for (const auto& [encoding, data] :
       {std::pair<v1::Encoding, std::string>{v1::ENCODING_RAW, RawChunk(1) + "x"},
        {v1::ENCODING_QUANTISED, "short"},
        {v1::ENCODING_DRACO_POINTS, "DRACO"},
        {v1::ENCODING_MESHOPT, "\xa1"},
        {v1::ENCODING_CONTROL_NETS, ""}}) {
    Surface surface;
    ApplyUpdate(surface, encoding, data, data);
    EXPECT_THAT(surface.Decode(), StatusIs(absl::StatusCode::kDataLoss)) << encoding;
  }
}

TEST(Surface, DeltasMoveControlPoints) {
  Surface surface;
  v1::SceneEvent state;
  state.mutable_lattice_state()->set_structure_id(4);
  for (int i = 0; i < 24; ++i)
    state.mutable_lattice_state()->mutable_lattice()->add_control_points(i);
  ApplyOk(surface, state);
  v1::SceneEvent delta;
  delta.mutable_lattice_delta()->set_structure_id(4);
  delta.mutable_lattice_delta()->set_revision(9);
  delta.mutable_lattice_delta()->add_indices(2);
  for (const double value : {-1.0, -2.0, -3.0}) delta.mutable_lattice_delta()->add_positions(value);
  ApplyOk(surface, delta);

  const auto& points = surface.lattice().lattice().control_points();
  EXPECT_EQ(points[5], 5);
  EXPECT_EQ(points[6], -1);
  EXPECT_EQ(points[8], -3);
  EXPECT_EQ(points[9], 9);
  EXPECT_EQ(surface.lattice().revision(), 9u);
  delta.mutable_lattice_delta()->set_indices(0, 8);
  EXPECT_THAT(surface.Apply(delta), StatusIs(absl::StatusCode::kDataLoss));
}

TEST(Surface, FollowsTheFirstLatticeThatIsLeft) {
  Surface surface;
  const auto tell = [&surface](uint32_t number, const std::vector<uint32_t>& all, double x) {
    v1::SceneEvent state;
    state.mutable_lattice_state()->set_structure_id(all.size());
    state.mutable_lattice_state()->set_index(number);
    state.mutable_lattice_state()->mutable_indexes()->Add(all.begin(), all.end());
    for (int i = 0; i < 3; ++i) {
      state.mutable_lattice_state()->mutable_lattice()->add_control_points(x);
    }
    ApplyOk(surface, state);
  };
  const auto x = [&surface] { return surface.lattice().lattice().control_points(0); };
  for (const uint32_t number : {0u, 1u, 2u}) tell(number, {0, 1, 2}, number);
  EXPECT_EQ(x(), 0);
  for (const uint32_t number : {1u, 2u}) tell(number, {1, 2}, 10 + number);
  EXPECT_EQ(x(), 11);
  v1::SceneEvent delta;
  delta.mutable_lattice_delta()->set_structure_id(2);
  delta.mutable_lattice_delta()->add_indices(0);
  for (int i = 0; i < 3; ++i) delta.mutable_lattice_delta()->add_positions(20);
  delta.mutable_lattice_delta()->set_lattice(2);
  delta.mutable_lattice_delta()->set_revision(1);
  ApplyOk(surface, delta);
  EXPECT_EQ(x(), 11);
  delta.mutable_lattice_delta()->set_lattice(1);
  delta.mutable_lattice_delta()->set_revision(2);
  ApplyOk(surface, delta);
  EXPECT_EQ(x(), 20);
}

// Two chunks of one patch each, of a view with a tolerance.
v1::SceneEvent AdaptiveTopologyEvent() {
  v1::SceneEvent event = TopologyEvent();
  event.mutable_topology()->clear_pattern();
  event.mutable_topology()->clear_segments();
  event.mutable_topology()->clear_point_count();
  return event;
}

// The pattern whose edge 0 has two segments, sparser: 4 points, 2 triangles.
v1::SceneEvent PatternsEvent() {
  v1::SceneEvent event;
  v1::PatchPattern* pattern = event.mutable_patterns()->add_patterns();
  pattern->set_code(513);
  pattern->set_denominator(2);
  for (const uint32_t i : {2u, 0u, 0u, 1u, 1u, 0u, 0u, 2u, 0u, 0u, 0u, 2u}) pattern->add_points(i);
  for (const uint32_t i : {0u, 1u, 3u, 1u, 2u, 3u}) pattern->add_triangles(i);
  pattern = event.mutable_patterns()->add_patterns();
  pattern->set_denominator(1);
  for (const uint32_t i : {1u, 0u, 0u, 0u, 1u, 0u, 0u, 0u, 1u}) pattern->add_points(i);
  for (const uint32_t i : {0u, 1u, 2u}) pattern->add_triangles(i);
  return event;
}

v1::SceneEvent LevelsEvent(uint32_t index, const std::string& levels, const std::string& data) {
  v1::SceneEvent event = ChunkEvent(1, index, data);
  event.mutable_chunks()->mutable_chunks(0)->set_levels(levels);
  return event;
}

TEST(Surface, HasTheLayoutOfEachPatchByTolerance) {
  const std::string four = RawChunk(1) + RawChunk(4).substr(0, 24);
  Surface surface;
  ApplyOk(surface, AdaptiveTopologyEvent());
  ApplyOk(surface, QuantisationEvent());
  ApplyOk(surface, BeginEvent(1, 2, v1::ENCODING_RAW));
  ApplyOk(surface, PatternsEvent());
  ApplyOk(surface, LevelsEvent(0, std::string("\x01\x02", 2), four));
  ApplyOk(surface, LevelsEvent(1, std::string("\0\0", 2), RawChunk(7)));
  v1::SceneEvent end = EndEvent(1, 3);
  end.mutable_update_end()->set_certified_error(0.25);
  ApplyOk(surface, end);

  EXPECT_EQ(surface.certified_error(), 0.25);
  EXPECT_EQ(surface.PointCount(), 7u);
  const auto layouts = surface.Layouts();
  ASSERT_OK(layouts);
  ASSERT_EQ(layouts->size(), 2u);
  EXPECT_EQ((*layouts)[0].denominator, 2);
  EXPECT_EQ((*layouts)[0].point_count(), 4u);
  const auto points = surface.Decode();
  ASSERT_OK(points);
  const auto mesh = AssembleMesh(*layouts, *points);
  ASSERT_OK(mesh);
  ASSERT_EQ(mesh->positions.size(), 7u);
  EXPECT_EQ(mesh->positions[3].x, 1004);
  ASSERT_EQ(mesh->triangles.size(), 3u);
  EXPECT_EQ(mesh->triangles[2], (std::array<uint32_t, 3>{4, 5, 6})) << "of the second patch";
}

TEST(Surface, LevelsWithoutTheirPatternsAreDataLoss) {
  const auto with = [](v1::SceneEvent patterns, const std::string& levels) {
    Surface surface;
    ApplyOk(surface, AdaptiveTopologyEvent());
    ApplyOk(surface, QuantisationEvent());
    ApplyOk(surface, BeginEvent(1, 2, v1::ENCODING_RAW));
    if (auto status = surface.Apply(std::move(patterns)).status(); !status.ok()) return status;
    for (const uint32_t chunk : {0u, 1u}) {
      auto status = surface.Apply(LevelsEvent(chunk, levels, RawChunk(1))).status();
      if (!status.ok()) return status;
    }
    if (auto status = surface.Apply(EndEvent(1, 3)).status(); !status.ok()) return status;
    return surface.Decode().status();
  };
  const std::string triangle("\0\0", 2);
  EXPECT_OK(with(PatternsEvent(), triangle));
  EXPECT_THAT(with({}, triangle), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(with(PatternsEvent(), ""), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(with(PatternsEvent(), triangle + triangle), StatusIs(absl::StatusCode::kDataLoss));
  EXPECT_THAT(with(PatternsEvent(), std::string("\x01\x02", 2)),
              StatusIs(absl::StatusCode::kDataLoss))
      << "four points are announced and three came";
  v1::SceneEvent broken = PatternsEvent();
  broken.mutable_patterns()->mutable_patterns(1)->set_triangles(0, 3);
  EXPECT_THAT(with(broken, triangle), StatusIs(absl::StatusCode::kDataLoss));
  broken = PatternsEvent();
  broken.mutable_patterns()->mutable_patterns(1)->set_denominator(0);
  EXPECT_THAT(with(broken, triangle), StatusIs(absl::StatusCode::kDataLoss));
}

TEST(AssembleMesh, CarriesUvsAndGroups) {
  Surface surface;
  ApplyUpdate(surface, v1::ENCODING_RAW, RawChunk(10), RawChunk(20));
  PolygonMesh source;
  source.positions.resize(3);
  source.face_offsets = {0, 3};
  source.corner_vertices = {0, 1, 2};
  source.uvs = {{0, 0}, {1, 0}, {0, 1}};
  source.corner_uvs = {0, 1, 2};
  source.group_names = {"skin"};
  source.face_groups = {0};
  v1::TopologyPart provenance;
  for (int patch = 0; patch < 2; ++patch) {
    provenance.add_faces(0);
    for (uint32_t corner = 0; corner < 3; ++corner) provenance.add_corners(corner);
    for (const double b : {1.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.25, 0.25, 0.5})
      provenance.add_barycentrics(b);
  }

  auto mesh = AssembleMesh(surface.Layouts().value(), surface.Decode().value());
  ASSERT_OK(mesh);
  ASSERT_OK(CarryAttributes(source, surface.Layouts().value(), provenance, &*mesh));

  EXPECT_EQ(mesh->triangles, (std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_EQ(mesh->uvs[1], (Vec2f{0.5f, 0}));
  EXPECT_EQ(mesh->uvs[5], (Vec2f{0.25f, 0.5f}));
  EXPECT_EQ(mesh->triangle_groups, (std::vector<uint32_t>{0, 0}));
  provenance.set_corners(0, 3);
  EXPECT_THAT(CarryAttributes(source, surface.Layouts().value(), provenance, &*mesh),
              StatusIs(absl::StatusCode::kDataLoss));
}

}  // namespace
}  // namespace latticed::client
