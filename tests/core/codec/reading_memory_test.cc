// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Readers of meshes ask for all memory that they allocate, before they allocate it. This program counts allocations.
#include "core/mesh/reading_memory.h"

#include <gmock/gmock.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <string>

#include "core/codec/draco_decode.h"
#include "core/mesh/mesh_io.h"
#include "draco/compression/decode.h"
#include "draco/compression/encode.h"
#include "fmt/format.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace {
std::atomic<size_t> allocated_bytes = 0, peak_bytes = 0;

void* Allocate(size_t bytes) {
  void* memory = std::malloc(bytes);
  if (memory == nullptr) throw std::bad_alloc();
  const size_t now = allocated_bytes += malloc_usable_size(memory);
  peak_bytes = std::max(peak_bytes.load(), now);
  return memory;
}
void Free(void* memory) {
  if (memory != nullptr) allocated_bytes -= malloc_usable_size(memory);
  std::free(memory);
}
}  // namespace

void* operator new(size_t bytes) { return Allocate(bytes); }
void* operator new[](size_t bytes) { return Allocate(bytes); }
void* operator new(size_t bytes, const std::nothrow_t&) noexcept { return Allocate(bytes); }
void* operator new[](size_t bytes, const std::nothrow_t&) noexcept { return Allocate(bytes); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { Free(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { Free(memory); }
void operator delete(void* memory) noexcept { Free(memory); }
void operator delete[](void* memory) noexcept { Free(memory); }
void operator delete(void* memory, size_t) noexcept { Free(memory); }
void operator delete[](void* memory, size_t) noexcept { Free(memory); }

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
TriangleMesh Grid(uint32_t n) {
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
  return mesh;
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

// A GLB file whose JSON has `extras` as well.
File GlbWith(std::string name, const TriangleMesh& mesh, const std::string& extras) {
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

// The stream again by edgebreaker, libdraco's default for meshes.
std::string Edgebreaker(const std::string& sequential) {
  draco::DecoderBuffer in;
  in.Init(sequential.data(), sequential.size());
  const auto mesh = draco::Decoder().DecodeMeshFromBuffer(&in);
  draco::Encoder encoder;
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 12);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::NORMAL, 8);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::TEX_COORD, 12);
  draco::EncoderBuffer out;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh.value(), &out).ok());
  return {out.data(), out.size()};
}

std::vector<File> Files() {
  const TriangleMesh grid = Grid(300);
  const std::string draco = *WriteDracoMesh(grid);
  return {{"grid.obj", MeshFormat::kObj, *WriteMesh(MeshFormat::kObj, grid)},
          {"grid.ply", MeshFormat::kPly, *WriteMesh(MeshFormat::kPly, grid)},
          {"grid.stl", MeshFormat::kStl, *WriteMesh(MeshFormat::kStl, grid)},
          {"grid.drc", MeshFormat::kDraco, draco},
          {"edgebreaker.drc", MeshFormat::kDraco, Edgebreaker(draco)},
          GlbWith("grid.glb", grid, "0"),
          GlbWith("numbers.glb", Grid(1), fmt::format("[{}0]", Times(300'000, "0,"))),
          GlbWith("arrays.glb", Grid(1), fmt::format("[{}0]", Times(200'000, "[0],"))),
          GlbWith("objects.glb", Grid(1), fmt::format("[{}0]", Times(100'000, "{\"a\":0},"))),
          DenseObj(),
          ObjOfGroups(),
          ObjOfGroupsWithFaces(),
          StlOfSolids(),
          {"strip.ply", MeshFormat::kPly, testing::PlyStrip(3'000'000)},
          AsciiStl()};
}

absl::StatusOr<PolygonMesh> Read(const File& file, ReadingMemory* memory) {
  return file.format == MeshFormat::kDraco ? ReadDracoMesh(file.bytes, memory)
                                           : ReadMesh(file.format, file.bytes, memory);
}

TEST(ReadingMemoryTest, IsAskedForBeforeItIsAllocatedAndIsNotFarTooMuch) {
  for (const File& file : Files()) {
    uint64_t held = 0;
    size_t beyond = 0;  // allocated at a question, above what was granted before it
    const size_t before = allocated_bytes;
    peak_bytes = before;
    ReadingMemory memory([&](uint64_t bytes) {
      beyond =
          std::max<size_t>(beyond, peak_bytes - before > held ? peak_bytes - before - held : 0);
      held = bytes;
      return absl::OkStatus();
    });
    {
      const auto mesh = Read(file, &memory);
      EXPECT_OK(mesh) << file.name;
    }
    const size_t peak = peak_bytes - before;
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
  for (const File& file : Files()) {
    const size_t before = allocated_bytes;
    peak_bytes = before;
    ReadingMemory memory([&](uint64_t bytes) {
      return bytes <= kGranted ? absl::OkStatus() : absl::ResourceExhaustedError("no more");
    });

    EXPECT_THAT(Read(file, &memory).status(),
                StatusIs(absl::StatusCode::kResourceExhausted, HasSubstr("no more")))
        << file.name;
    EXPECT_LE(peak_bytes - before, kGranted + kSlackBytes) << file.name;
  }
}

}  // namespace
}  // namespace latticed
