// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Bytes that are no mesh are refused, in every format and for the right reason, and nothing of them is kept.
#include <cmath>

#include "fmt/format.h"
#include "tests/server/meshes/mesh_files.h"
#include "tests/server/support/server_test.h"

namespace latticed::testing {
namespace {

class BadMeshesTest : public SmallServerTest {
 protected:
  using SmallServerTest::Upload;
  absl::Status Upload(const MeshFile& file) { return Upload(file.header, file.bytes); }

  // Expects MALFORMED_FILE with the format and the place in the file.
  void ExpectMalformed(const MeshFile& file, const std::string& message = "") {
    SCOPED_TRACE(file.name);
    const absl::Status status = Upload(file);
    ExpectRefusal(status, {.reason = "MALFORMED_FILE", .field = "data", .message = message});
    auto metadata = error::DetailsOf(status).metadata;
    const std::string format = v1::MeshFormat_Name(file.header.format());
    EXPECT_EQ("MESH_FORMAT_" + metadata["format"], format);
    EXPECT_NE(metadata["where"], "");
    EXPECT_EQ(MeshCount(), 0);
  }

  std::string UploadOf(const MeshFile& file) {
    v1::Mesh mesh;
    EXPECT_OK(Upload(file.header, file.bytes, &mesh));
    return mesh.id();
  }

  // The server still takes a good file and deletes it again.
  void TearDown() override {
    EXPECT_OK(DeleteMesh(Upload(CubeObj())));
    EXPECT_EQ(MeshCount(), 0);
  }
};

// tests/core/mesh and tests/core/codec have more cases for each reader.
TEST_F(BadMeshesTest, OtherFilesAreRefusedInEveryFormat) {
  const std::string junk =
      "this is no mesh at all, whatever the format; 84 bytes and more of it ....."
      "..............................";
  for (const auto format : {v1::MESH_FORMAT_OBJ, v1::MESH_FORMAT_PLY, v1::MESH_FORMAT_STL,
                            v1::MESH_FORMAT_GLB, v1::MESH_FORMAT_DRACO}) {
    ExpectMalformed(MakeMeshFile(v1::MeshFormat_Name(format), format, junk));
  }
}

// Three vertices, the first at (x, 0, 0), and one face.
MeshFile RawFace(float x, const std::vector<uint32_t>& face) {
  const auto corners = static_cast<uint32_t>(face.size());
  MeshFile raw = MakeMeshFile("RAW", v1::MESH_FORMAT_RAW,
                              BytesOf(std::vector<float>{x, 0, 0, 1, 0, 0, 0, 1, 0}) +
                                  BytesOf(std::vector<uint32_t>{corners}) + BytesOf(face));
  raw.header.mutable_raw_layout()->set_vertex_count(3);
  raw.header.mutable_raw_layout()->set_face_count(1);
  raw.header.mutable_raw_layout()->set_corner_count(corners);
  return raw;
}

TEST_F(BadMeshesTest, RawArraysAreChecked) {
  ASSERT_OK(DeleteMesh(UploadOf(RawFace(0, {0, 1, 2})))) << "this one is good";
  for (const float x : {std::nanf(""), HUGE_VALF, -HUGE_VALF}) {
    ExpectMalformed(RawFace(x, {0, 1, 2}), "finite");
  }
  for (const uint32_t index : {3u, 65'534u, ~0u}) {
    ExpectMalformed(RawFace(0, {0, 1, index}), "vertex index");
  }
  ExpectMalformed(RawFace(0, {0, 1}), "at least 3");
  ExpectMalformed(RawFace(0, {2}), "at least 3");
  MeshFile points = RawFace(0, {});
  points.header.mutable_raw_layout()->clear_face_count();
  points.header.mutable_raw_layout()->set_face_size(3);
  ExpectRefusal(Upload(points), {.reason = "OUT_OF_RANGE",
                                 .field = "header.raw_layout.face_count",
                                 .message = "got 0, allowed is 1 to 200000000"});
}

// Whether a cut leaves a valid file: text without its last newline, an STL cut after "endsolid".
bool MayEndAt(const MeshFile& file, size_t size) {
  if (file.name == "ascii STL") return file.bytes.find("endsolid") + 8 <= size;
  const bool lines = file.name == "OBJ" || file.name == "ascii PLY";
  return lines && size + 1 == file.bytes.size();
}

TEST_F(BadMeshesTest, CutFilesAreRefused) {
  for (const MeshFile& file : CubeFiles()) {
    // An OBJ is cut before the end of its first face: after a face it may end.
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
      const absl::Status status = Upload(corrupt.header, corrupt.bytes, &mesh);
      if (!status.ok()) {
        ++refused;
        ExpectRefusal(status, {.reason = "MALFORMED_FILE", .field = "data"});
        continue;
      }
      EXPECT_OK(DeleteMesh(mesh.id()));
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
    for (const std::string& bytes : {file.bytes + '\n', file.bytes.substr(0, size - 1)}) {
      ExpectRefusal(Upload(file.header, bytes),
                    {.reason = "SIZE_MISMATCH",
                     .field = "data",
                     .message = fmt::format("received {} bytes, header.total_bytes is {}",
                                            bytes.size(), size)});
    }
    EXPECT_EQ(MeshCount(), 0);
  }
}

}  // namespace
}  // namespace latticed::testing
