// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What is no mesh is refused, in every format and for the right reason, and leaves nothing behind.
#include <cmath>
#include <limits>

#include "core/codec/chunk_encoder.h"
#include "core/codec/draco_decode.h"
#include "fmt/format.h"
#include "tests/server/mesh_files.h"
#include "tests/server/refusal.h"
#include "tests/server/test_env.h"
#include "tests/support/encode_chunk.h"

namespace latticed::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

class BadMeshesTest : public ::testing::Test {
 protected:
  int MeshCount() {
    grpc::ClientContext context;
    v1::ListMeshesResponse response;
    EXPECT_TRUE(env_.meshes().ListMeshes(&context, {}, &response).ok());
    return response.meshes_size();
  }

  grpc::Status Upload(const MeshFile& file) {
    v1::Mesh mesh;
    return env_.Upload(file.header, file.bytes, &mesh);
  }

  // MALFORMED_FILE, naming the format and the place.
  void ExpectMalformed(const MeshFile& file, const std::string& message = "") {
    SCOPED_TRACE(file.name);
    const grpc::Status status = Upload(file);
    ExpectRefusal(status, {.reason = "MALFORMED_FILE", .field = "data", .message = message});
    auto metadata = error::DetailsOf(client::FromGrpc(status)).metadata;
    const std::string format = v1::MeshFormat_Name(file.header.format());
    EXPECT_EQ("MESH_FORMAT_" + metadata["format"], format);
    EXPECT_NE(metadata["where"], "");
    EXPECT_EQ(MeshCount(), 0);
  }

  // The server goes on: it takes a good file, and forgets it again.
  void TearDown() override {
    v1::DeleteMeshRequest request;
    request.set_mesh(env_.UploadCube().id());
    grpc::ClientContext context;
    v1::DeleteMeshResponse response;
    EXPECT_TRUE(env_.meshes().DeleteMesh(&context, request, &response).ok());
    EXPECT_EQ(MeshCount(), 0);
  }

  TestEnv env_;
};

// One triangle with `x` as its first number, in every format; Draco has it in its grid's origin.
std::vector<MeshFile> TrianglesFrom(float x) {
  const std::vector<float> positions = {x, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::vector<std::vector<int32_t>> faces = {{0, 1, 2}};
  const std::string word = fmt::format("{}", x);
  const TriangleMesh one{.positions = {{}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};
  constexpr size_t kTransformBytes = 17;  // float min[3], float range, uint8 bits, at the end
  std::string draco = WriteDracoMesh(one).value();
  draco.replace(draco.size() - kTransformBytes, sizeof(x), BytesOf(std::vector<float>{x}));
  MeshFile raw = MakeMeshFile("RAW", v1::MESH_FORMAT_RAW,
                              BytesOf(positions) + BytesOf(std::vector<uint32_t>{0, 1, 2}));
  raw.header.mutable_raw_layout()->set_vertex_count(3);
  raw.header.mutable_raw_layout()->set_face_count(1);
  raw.header.mutable_raw_layout()->set_face_size(3);
  return {
      MakeMeshFile("OBJ", v1::MESH_FORMAT_OBJ, "v " + word + " 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
      MakeMeshFile("ascii PLY", v1::MESH_FORMAT_PLY, Ply(PlyForm::kAscii, positions, faces)),
      MakeMeshFile("little-endian PLY", v1::MESH_FORMAT_PLY,
                   Ply(PlyForm::kLittleEndian, positions, faces)),
      MakeMeshFile("big-endian PLY", v1::MESH_FORMAT_PLY,
                   Ply(PlyForm::kBigEndian, positions, faces)),
      MakeMeshFile("ascii STL", v1::MESH_FORMAT_STL, AsciiStl({word + " 0 0", "1 0 0", "0 1 0"})),
      MakeMeshFile("binary STL", v1::MESH_FORMAT_STL, BinaryStl(positions)),
      MakeMeshFile("GLB", v1::MESH_FORMAT_GLB, Glb(positions, {0, 1, 2})),
      MakeMeshFile("DRACO", v1::MESH_FORMAT_DRACO, draco),
      raw,
  };
}

TEST_F(BadMeshesTest, TheTriangleItselfIsGood) {
  for (const MeshFile& file : TrianglesFrom(0.5f)) {
    SCOPED_TRACE(file.name);
    v1::Mesh mesh;
    const grpc::Status status = env_.Upload(file.header, file.bytes, &mesh);
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(mesh.faces(), 1u);
    v1::DeleteMeshRequest request;
    request.set_mesh(mesh.id());
    grpc::ClientContext context;
    v1::DeleteMeshResponse response;
    EXPECT_TRUE(env_.meshes().DeleteMesh(&context, request, &response).ok());
  }
}

TEST_F(BadMeshesTest, PositionsMustBeFinite) {
  for (const float x : {kNan, kInfinity, -kInfinity}) {
    SCOPED_TRACE(x);
    for (const MeshFile& file : TrianglesFrom(x)) ExpectMalformed(file);
  }
}

// Positions of three vertices and one face, in the formats that have indices.
std::vector<MeshFile> FilesOfFace(const std::vector<int32_t>& face) {
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
  for (const int32_t vertex : face) obj += fmt::format(" {}", vertex + 1);
  std::vector<MeshFile> files = {
      MakeMeshFile("OBJ", v1::MESH_FORMAT_OBJ, obj + "\n"),
      MakeMeshFile("ascii PLY", v1::MESH_FORMAT_PLY, Ply(PlyForm::kAscii, positions, {face})),
      MakeMeshFile("little-endian PLY", v1::MESH_FORMAT_PLY,
                   Ply(PlyForm::kLittleEndian, positions, {face})),
      MakeMeshFile("big-endian PLY", v1::MESH_FORMAT_PLY,
                   Ply(PlyForm::kBigEndian, positions, {face})),
      MakeMeshFile("GLB", v1::MESH_FORMAT_GLB,
                   Glb(positions, std::vector<uint16_t>(face.begin(), face.end()))),
  };
  MeshFile raw = MakeMeshFile(
      "RAW", v1::MESH_FORMAT_RAW,
      BytesOf(positions) + BytesOf(std::vector<uint32_t>{static_cast<uint32_t>(face.size())}) +
          BytesOf(face));
  raw.header.mutable_raw_layout()->set_vertex_count(3);
  raw.header.mutable_raw_layout()->set_face_count(1);
  raw.header.mutable_raw_layout()->set_corner_count(face.size());
  files.push_back(raw);
  return files;
}

TEST_F(BadMeshesTest, FaceIndicesMustBeInRange) {
  for (const int32_t index : {3, 65'534, -1}) {
    SCOPED_TRACE(index);
    for (const MeshFile& file : FilesOfFace({0, 1, index})) ExpectMalformed(file);
  }
  ExpectMalformed(MakeMeshFile("OBJ, before the first", v1::MESH_FORMAT_OBJ,
                               "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n"));
}

TEST_F(BadMeshesTest, FacesMustHaveThreeCorners) {
  for (const MeshFile& file : FilesOfFace({0, 1})) ExpectMalformed(file);
  for (const MeshFile& file : FilesOfFace({2})) ExpectMalformed(file);
}

TEST_F(BadMeshesTest, VerticesWithoutFacesAreNoMesh) {
  const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::vector<uint8_t> chunk(3 * 6);
  const auto points = testing::EncodePoints(*MakeReferenceEncoder(),
                                            QuantisedVertices::FromBytes(chunk, 3, 12, 0), 1.0)
                          .value();
  for (const MeshFile& file : {
           MakeMeshFile("OBJ", v1::MESH_FORMAT_OBJ, "v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
           MakeMeshFile("ascii PLY", v1::MESH_FORMAT_PLY, Ply(PlyForm::kAscii, positions, {})),
           MakeMeshFile("little-endian PLY", v1::MESH_FORMAT_PLY,
                        Ply(PlyForm::kLittleEndian, positions, {})),
           MakeMeshFile("big-endian PLY", v1::MESH_FORMAT_PLY,
                        Ply(PlyForm::kBigEndian, positions, {})),
           MakeMeshFile("ascii STL", v1::MESH_FORMAT_STL, AsciiStl({})),
           MakeMeshFile("binary STL", v1::MESH_FORMAT_STL, BinaryStl({})),
           MakeMeshFile("GLB", v1::MESH_FORMAT_GLB, Glb(positions, {})),
           MakeMeshFile("DRACO", v1::MESH_FORMAT_DRACO, std::string(points.begin(), points.end())),
       }) {
    ExpectMalformed(file);
  }
  MeshFile raw = MakeMeshFile("RAW", v1::MESH_FORMAT_RAW, BytesOf(positions));
  raw.header.mutable_raw_layout()->set_vertex_count(3);
  raw.header.mutable_raw_layout()->set_face_size(3);
  ExpectRefusal(Upload(raw), {.reason = "OUT_OF_RANGE",
                              .field = "header.raw_layout.face_count",
                              .message = "got 0, allowed is 1 to 200000000"});
}

// An end that a reader cannot tell from the file's own: a line of OBJ, the word after endsolid.
bool MayEndAt(const MeshFile& file, size_t size) {
  if (file.name == "ascii STL") return file.bytes.find("endsolid") + 8 <= size;
  const bool lines = file.name == "OBJ" || file.name == "ascii PLY";
  return lines && size + 1 == file.bytes.size();
}

TEST_F(BadMeshesTest, CutFilesAreRefused) {
  for (const MeshFile& file : CubeFiles()) {
    // Of an OBJ only its vertices: between faces it may end.
    const size_t last = file.name == "OBJ" ? file.bytes.find("f ") + 5 : file.bytes.size() - 1;
    for (const size_t part : {1u, 2u, 3u, 5u, 7u, 11u, 16u}) {
      const size_t size = last * part / 16;
      if (size == 0 || MayEndAt(file, size)) continue;
      SCOPED_TRACE(fmt::format("{} cut to {} of {} bytes", file.name, size, file.bytes.size()));
      MeshFile cut = file;
      cut.bytes.resize(size);
      cut.header.set_total_bytes(size);
      if (file.header.has_raw_layout()) {
        ExpectRefusal(Upload(cut), {.reason = "INVALID_FIELD",
                                    .field = "header.raw_layout",
                                    .message = fmt::format("describes {} bytes, total_bytes is {}",
                                                           file.bytes.size(), size)});
        EXPECT_EQ(MeshCount(), 0);
      } else {
        ExpectMalformed(cut);
      }
    }
  }
}

TEST_F(BadMeshesTest, CorruptFilesAreRefusedOrReadButNeverBreakTheServer) {
  int refused = 0;
  for (const MeshFile& file : CubeFiles()) {
    for (size_t at = 0; at < file.bytes.size(); at += 1 + file.bytes.size() / 40) {
      SCOPED_TRACE(fmt::format("{}, byte {}", file.name, at));
      MeshFile corrupt = file;
      corrupt.bytes[at] = static_cast<char>(~corrupt.bytes[at]);
      v1::Mesh mesh;
      const grpc::Status status = env_.Upload(corrupt.header, corrupt.bytes, &mesh);
      if (!status.ok()) {
        ++refused;
        ExpectRefusal(status, {.reason = "MALFORMED_FILE", .field = "data"});
        continue;
      }
      v1::DeleteMeshRequest request;
      request.set_mesh(mesh.id());
      grpc::ClientContext context;
      v1::DeleteMeshResponse response;
      EXPECT_TRUE(env_.meshes().DeleteMesh(&context, request, &response).ok());
    }
  }
  EXPECT_GT(refused, 100);
  EXPECT_EQ(MeshCount(), 0);
}

TEST_F(BadMeshesTest, BytesMustBeAsAnnouncedInEveryFormat) {
  for (const MeshFile& file : CubeFiles()) {
    SCOPED_TRACE(file.name);
    MeshFile other = file;
    other.header.set_sha256(std::string(64, '0'));
    ExpectRefusal(
        Upload(other),
        {.reason = "HASH_MISMATCH", .field = "header.sha256", .message = "the bytes have"});
    const size_t size = file.bytes.size();
    other = file;
    other.bytes += '\n';
    ExpectRefusal(Upload(other), {.reason = "SIZE_MISMATCH",
                                  .field = "data",
                                  .message = fmt::format("{} bytes came, header.total_bytes "
                                                         "announced {}",
                                                         size + 1, size)});
    other.bytes = file.bytes.substr(0, size - 1);
    ExpectRefusal(Upload(other), {.reason = "SIZE_MISMATCH",
                                  .field = "data",
                                  .message = fmt::format("{} bytes came, header.total_bytes "
                                                         "announced {}",
                                                         size - 1, size)});
    EXPECT_EQ(MeshCount(), 0);
  }
}

}  // namespace
}  // namespace latticed::testing
