// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Readers of meshes ask for all memory that they allocate, before they allocate it. This program counts allocations.
#include "core/mesh/reading_memory.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <string>

#include "core/codec/draco_decode.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/triangle_mesh.h"
#include "core/mesh/write/write_mesh.h"
#include "fmt/format.h"
#include "tests/core/codec/draco_streams.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

using ::latticed::testing::StatusIs;
using ::testing::HasSubstr;

// Strings of errors, tables of libdraco, and steps between two questions.
constexpr size_t kSlackBytes = size_t{1} << 20;

struct File {
  std::string name;
  MeshFormat format;
  std::string bytes;
};

// An open grid of n x n quads as triangles, with normals and UVs.
PolygonMesh Grid(uint32_t n) {
  TriangleMesh mesh;
  for (uint32_t y = 0; y <= n; ++y) {
    for (uint32_t x = 0; x <= n; ++x) {
      mesh.positions.push_back({1.0 * x, 1.0 * y, 0.001 * x * y});
      mesh.normals.push_back({0, 0, 1});
      mesh.uvs.push_back({static_cast<float>(x), static_cast<float>(y)});
    }
  }
  for (uint32_t y = 0; y < n; ++y) {
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return Welded(mesh);
}

std::string Times(int count, std::string_view part) {
  std::string text;
  for (int i = 0; i < count; ++i) text += part;
  return text;
}

// Lines as short as they can be, which make the most of each byte.
File DenseObj() {
  return {"dense.obj", MeshFormat::kObj,
          Times(100'000, "v 0 0 0\n") + Times(100'000, "vt 0\n") + Times(200'000, "f 1 2 3\n") +
              "f " + Times(65'000, "9 ") + "\n" + Times(100'000, "f 1/1 2/2 3/3\n")};
}

File ObjOfGroups() {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 100'000; ++i) text += fmt::format("g {}\n", i);
  return {"groups.obj", MeshFormat::kObj, text + "f 1 2 3\n"};
}

File ObjOfGroupsWithFaces() {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 65'537; ++i) text += fmt::format("g name_of_16_{:05}\nf 1 2 3\n", i);
  return {"named groups.obj", MeshFormat::kObj, text};
}

File StlOfSolids() {
  const std::string facet =
      "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 0 1 0 vertex 0 0 1 endloop endfacet\n";
  return {"solids.stl", MeshFormat::kStl, Times(131'073, "solid\n") + facet + "endsolid"};
}

File AsciiStl() {
  std::string text = "solid a\n";
  for (int i = 0; i < 60'000; ++i) {
    text += fmt::format(
        "facet normal 0 0 1 outer loop vertex {0} 0 0 vertex {0} 1 0 vertex {0} 0 1 "
        "endloop endfacet\n",
        i);
  }
  return {"ascii.stl", MeshFormat::kStl, text + "endsolid"};
}

// A triangle, after a header of as many properties as there may be, with long names.
File PlyOfProperties() {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\n";
  for (int e = 0; e < 62; ++e) {
    text += fmt::format("element e{} 0\n", e);
    for (int p = 0; p < 1'024; ++p) text += fmt::format("property char name_of_{:024}\n", p);
  }
  return {"properties.ply", MeshFormat::kPly, text + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"};
}

// A GLB file whose JSON has `extras` as well.
File GlbWith(std::string name, const PolygonMesh& mesh, const std::string& extras) {
  std::string bytes = *WriteGlb(mesh);
  uint32_t json_bytes = 0;
  std::memcpy(&json_bytes, &bytes[12], sizeof(json_bytes));
  std::string json = bytes.substr(20, json_bytes);
  json.insert(json.find('{') + 1, fmt::format("\"extras\":{},", extras));
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string out = bytes.substr(0, 20) + json + bytes.substr(20 + json_bytes);
  const auto length = static_cast<uint32_t>(json.size()), all = static_cast<uint32_t>(out.size());
  std::memcpy(&out[12], &length, sizeof(length));
  std::memcpy(&out[8], &all, sizeof(all));
  return {std::move(name), MeshFormat::kGlb, std::move(out)};
}

std::vector<File> Files() {
  const PolygonMesh grid = Grid(300);
  const std::string draco = *WriteDracoMesh(grid);
  return {{"grid.obj", MeshFormat::kObj, *WriteMesh(MeshFormat::kObj, grid)},
          {"grid.ply", MeshFormat::kPly, *WriteMesh(MeshFormat::kPly, grid)},
          {"grid.stl", MeshFormat::kStl, *WriteMesh(MeshFormat::kStl, grid)},
          {"grid.drc", MeshFormat::kDraco, draco},
          {"edgebreaker.drc", MeshFormat::kDraco, testing::EdgebreakerStream(draco)},
          GlbWith("grid.glb", grid, "0"),
          GlbWith("numbers.glb", Grid(1), fmt::format("[{}0]", Times(300'000, "0,"))),
          GlbWith("arrays.glb", Grid(1), fmt::format("[{}0]", Times(200'000, "[0],"))),
          GlbWith("empty objects.glb", Grid(1), fmt::format("[{}0]", Times(262'144, "{},"))),
          GlbWith("objects.glb", Grid(1), fmt::format("[{}0]", Times(100'000, "{\"a\":0},"))),
          PlyOfProperties(),
          DenseObj(),
          ObjOfGroups(),
          ObjOfGroupsWithFaces(),
          StlOfSolids(),
          {"strip.ply", MeshFormat::kPly, testing::PlyStrip(3'000'000)},
          AsciiStl()};
}

std::vector<File> AllFiles() {
  std::vector<File> files = Files();
  for (auto& [name, bytes] : testing::CrowdedDracoStreams()) {
    files.push_back({name, MeshFormat::kDraco, std::move(bytes)});
  }
  return files;
}

absl::StatusOr<PolygonMesh> Read(const File& file, ReadingMemory* memory) {
  return file.format == MeshFormat::kDraco ? ReadDracoMesh(file.bytes, memory)
                                           : ReadMesh(file.format, file.bytes, memory);
}

TEST(ReadingMemoryTest, IsAskedForBeforeItIsAllocatedAndIsNotFarTooMuch) {
  for (const File& file : AllFiles()) {
    uint64_t held = 0;
    size_t beyond = 0;  // allocated at a question, above what was granted before it
    const testing::PeakMemory counted;
    ReadingMemory memory([&](uint64_t bytes) {
      beyond = std::max<size_t>(beyond, counted.peak() > held ? counted.peak() - held : 0);
      held = bytes;
      return absl::OkStatus();
    });
    {
      const auto mesh = Read(file, &memory);
      EXPECT_OK(mesh) << file.name;
    }
    const size_t peak = counted.peak();
    fmt::print("{:16} {:>11} bytes, {:>11} at the peak, {:>11} asked for: {:.2f}\n", file.name,
               file.bytes.size(), peak, held,
               static_cast<double>(held) / static_cast<double>(peak));

    EXPECT_LE(peak, held + kSlackBytes) << file.name;
    EXPECT_LE(beyond, kSlackBytes) << file.name;
    EXPECT_LE(held, 3 * peak + 2 * kSlackBytes) << file.name;
  }
}

TEST(ReadingMemoryTest, ARefusalEndsReadingWithinWhatWasGranted) {
  constexpr uint64_t kGranted = uint64_t{2} << 20;
  for (const File& file : AllFiles()) {
    const testing::PeakMemory counted;
    ReadingMemory memory([&](uint64_t bytes) {
      return bytes <= kGranted ? absl::OkStatus() : absl::ResourceExhaustedError("no more");
    });

    EXPECT_THAT(Read(file, &memory).status(),
                StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("no more")))
        << file.name;
    EXPECT_LE(counted.peak(), kGranted + kSlackBytes) << file.name;
  }
}

}  // namespace
}  // namespace latticed
