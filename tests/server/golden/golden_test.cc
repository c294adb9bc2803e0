// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Compares every encoding and export format with a file in golden/, so that bytes on the wire change only
// on purpose. To rewrite the files after an intended change:
//
//   LATTICED_REWRITE_GOLDEN=1 build/tests/server/golden/golden_test
//
// The mesh is a quad and a triangle, parallel to coordinate planes, in a lattice of degree 1 at rest. The
// view has 1 segment. Every number is a dyadic fraction, so nothing is rounded, whatever vector
// instructions the machine has. Normals are computed through thirds and a square root. Float normals are
// therefore compared to within 1e-6, and exports have no normals.
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "core/codec/draco_decode.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

constexpr char kMesh[] =
    "v 0.25 0.25 0.5\nv 1.25 0.25 0.5\nv 1.25 1.5 0.5\nv 0.25 1.5 0.5\n"
    "v 2.75 0.25 0.5\nv 2.75 1.25 0.5\nv 2.75 0.25 1.75\n"
    "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
    "usemtl floor\nf 1/1 2/2 3/3 4/4\nusemtl wall\nf 5/1 6/2 7/3\n";
constexpr size_t kMostBytes = 4096;

class GoldenTest : public ServerTest {
 protected:
  void SetUp() override { Start(TestOptions()); }
  void Start(Options options) {
    ASSERT_NO_FATAL_FAILURE(StartServer(std::move(options)));
    mesh_ = Upload(std::string(kMesh));
    v1::CreateSceneRequest request = SceneRequest();
    v1::Lattice& lattice = *request.add_lattices()->mutable_lattice();
    SetFrame(*lattice.mutable_frame(), {}, {4, 4, 4});
    SetAxes(*lattice.mutable_degree(), 1, 1, 1);
    SetAxes(*lattice.mutable_size(), 2, 2, 2);
    request.mutable_default_view()->set_segments(1);
    ASSERT_OK(Create(request));
  }

  // All chunks of a full update, one after the other.
  std::string Chunks(v1::Encoding encoding) {
    auto request = For<v1::GetUpdateRequest>();
    request.mutable_view()->set_encoding(encoding);
    EventLog log;
    EXPECT_OK(Update(request, log));
    std::string bytes;
    for (const auto& [index, data] : log.chunks) bytes += data;
    return bytes;
  }

  std::string Exported(v1::ExportFormat format,
                       v1::ExportGeometry geometry = v1::EXPORT_GEOMETRY_EXACT) {
    auto request = For<v1::ExportRequest>();
    request.set_format(format);
    request.set_geometry(geometry);
    request.mutable_view()->set_normals(v1::NORMAL_MODE_NONE);
    return Export(request).value();
  }

  // Returns the golden file. With LATTICED_REWRITE_GOLDEN, `bytes` is written to it first.
  static std::string Golden(const std::string& name, const std::string& bytes) {
    EXPECT_GT(bytes.size(), 0u);
    EXPECT_LT(bytes.size(), kMostBytes);
    const auto path = std::filesystem::path(LATTICED_GOLDEN_FOLDER) / name;
    if (std::getenv("LATTICED_REWRITE_GOLDEN") != nullptr) {
      std::ofstream(path, std::ios::binary) << bytes;
    }
    return Golden(name);
  }
  static std::string Golden(const std::string& name) {
    const auto path = std::filesystem::path(LATTICED_GOLDEN_FOLDER) / name;
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file.good()) << path;
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  static void ExpectSame(const std::string& name, const std::string& bytes) {
    EXPECT_TRUE(Golden(name, bytes) == bytes)
        << name << " has changed; if this is intended, see the top of this test";
  }
};

TEST_F(GoldenTest, Encodings) {
  ExpectSame("chunks.quantised", Chunks(v1::ENCODING_QUANTISED));
  ExpectSame("chunks.draco_points", Chunks(v1::ENCODING_DRACO_POINTS));
  ExpectSame("chunks.draco_mesh", Chunks(v1::ENCODING_DRACO_MESH));
  ExpectSame("chunks.meshopt", Chunks(v1::ENCODING_MESHOPT));
}

// One control point is moved, which bends quad and triangle. What a stream says of it: patterns, then levels and data.
TEST_F(GoldenTest, AViewWithATolerance) {
  ASSERT_OK(Apply(MoveOne("ann", 1, 7, {0, 0, 2})));
  for (const auto& [name, encoding] : {std::pair{"tolerance.quantised", v1::ENCODING_QUANTISED},
                                       {"tolerance.draco_mesh", v1::ENCODING_DRACO_MESH}}) {
    auto request = For<v1::GetUpdateRequest>();
    v1::ViewOptions& view = *request.mutable_view();
    view.set_encoding(encoding);
    view.set_tolerance(0.003);
    view.set_segments(4);
    view.set_position_bits(12);
    view.set_normals(v1::NORMAL_MODE_NONE);
    EventLog log;
    ASSERT_OK(Update(request, log));
    std::string bytes;
    for (const auto& [code, pattern] : log.patterns) bytes += pattern.SerializeAsString();
    for (const auto& [index, data] : log.chunks) bytes += log.levels.at(index) + data;

    EXPECT_EQ(log.patterns.size(), 2u) << "the triangle bends less";
    ExpectSame(name, bytes);
  }
}

TEST_F(GoldenTest, RawEncoding) {
  const std::string bytes = Chunks(v1::ENCODING_RAW);
  const std::string golden = Golden("chunks.raw", bytes);
  ASSERT_EQ(bytes.size(), golden.size());
  ASSERT_EQ(bytes.size(), 9 * 6 * sizeof(float));  // three patches of three points
  for (size_t at = 0; at < bytes.size(); at += sizeof(float)) {
    float got = 0, expected = 0;
    std::memcpy(&got, &bytes[at], sizeof(float));
    std::memcpy(&expected, &golden[at], sizeof(float));
    EXPECT_NEAR(got, expected, 1e-6) << "byte " << at;
  }
}

TEST_F(GoldenTest, Exports) {
  ExpectSame("export.ply", Exported(v1::EXPORT_FORMAT_PLY));
  ExpectSame("export.obj", Exported(v1::EXPORT_FORMAT_OBJ));
  ExpectSame("export.stl", Exported(v1::EXPORT_FORMAT_STL));
  ExpectSame("export.glb", Exported(v1::EXPORT_FORMAT_GLB));
  ExpectSame("export.drc", Exported(v1::EXPORT_FORMAT_DRC));
  ExpectSame("export.usda", Exported(v1::EXPORT_FORMAT_USD));
  ExpectSame("original.obj", Exported(v1::EXPORT_FORMAT_OBJ, v1::EXPORT_GEOMETRY_ORIGINAL));
}

// With --encoder reference, libdraco writes the streams, of the same integers.
class ReferenceEncoderTest : public GoldenTest {
 protected:
  void SetUp() override {
    Options options = TestOptions();
    options.encoder = "reference";
    Start(options);
  }

  static DecodedIntegers Integers(const std::string& stream) {
    auto integers =
        DecodeDracoChunkIntegers({reinterpret_cast<const uint8_t*>(stream.data()), stream.size()});
    EXPECT_OK(integers);
    return integers.ok() ? *std::move(integers) : DecodedIntegers{};
  }
};

TEST_F(ReferenceEncoderTest, HoldsTheSameIntegers) {
  for (const auto& [name, encoding] : {std::pair{"chunks.draco_points", v1::ENCODING_DRACO_POINTS},
                                       {"chunks.draco_mesh", v1::ENCODING_DRACO_MESH}}) {
    const std::string theirs = Chunks(encoding), ours = Golden(name);

    EXPECT_FALSE(theirs == ours) << name << " is not libdraco's";
    EXPECT_EQ(Integers(theirs).positions, Integers(ours).positions) << name;
    EXPECT_EQ(Integers(theirs).normals, Integers(ours).normals) << name;
    EXPECT_EQ(Integers(theirs).positions.size(), 27u) << "three patches of three points";
  }
}

}  // namespace
}  // namespace latticed::testing
