// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// An export takes no more memory than ExportMemoryBytes asks for it. This program counts allocations.
#include "core/cpu/cpu_backend.h"
#include "fmt/format.h"
#include "server/engine/exports/surface_export.h"
#include "tests/server/scenes/export_input.h"
#include "tests/support/counted_allocations.h"
#include "tests/support/status_matchers.h"
#include "tests/support/test_meshes.h"

namespace latticed {
namespace {

// Small surfaces may ask for more than three times what they take.
constexpr size_t kLeastBytes = size_t{2} << 20;
constexpr std::optional<MeshFormat> kFormats[] = {
    MeshFormat::kObj,   MeshFormat::kPly, MeshFormat::kStl, MeshFormat::kGlb,
    MeshFormat::kDraco, MeshFormat::kUsd, std::nullopt};

// A grid of cells x cells quads whose coordinates have 17 digits and an exponent. `groups`: with UVs of 9 digits, and
// each face in a group of its own.
std::shared_ptr<const PolygonMesh> UglyGrid(int cells, bool groups) {
  auto mesh = std::make_shared<PolygonMesh>(testing::FlatGrid(cells, 1.0 / 3));
  for (Vec3d& p : mesh->positions) p = -1.2345678901234567e-9 * p;
  if (!groups) return mesh;
  for (const Vec3d p : mesh->positions) {
    mesh->uvs.push_back({static_cast<float>(p.x) / -3e-9f, static_cast<float>(p.y) / -7e9f});
  }
  mesh->corner_uvs = mesh->corner_vertices;
  for (size_t f = 0; f < mesh->face_count(); ++f) {
    mesh->group_names.push_back(fmt::format("a group with a name of some length: \"{}\"", f));
    mesh->face_groups.push_back(static_cast<uint32_t>(f));
  }
  return mesh;
}

class ExportMemoryTest : public ::testing::Test {
 protected:
  void Make(std::shared_ptr<const PolygonMesh> mesh, double jitter = 1e-10) {
    auto input = testing::MakeExportInput(render_backend_, std::move(mesh), {2, 2, 2}, jitter);
    ASSERT_OK(input);
    input_ = *std::move(input);
  }

  void ExpectBounded(const std::string& name, const ExportSpec& spec) {
    const uint64_t asked = ExportMemoryBytes(*input_.state->plan, spec);
    const testing::PeakMemory counted;
    const auto file = ExportSurface(input_, spec, NeverStop);
    ASSERT_OK(file);
    const size_t peak = counted.peak();
    fmt::print("{:>12} {:5} {:>11} bytes, {:>11} at the peak, {:>11} asked for: {:.2f}\n", name,
               ExportExtension(spec.format), file->bytes.size(), peak, asked,
               static_cast<double>(asked) / static_cast<double>(peak));

    EXPECT_LE(peak, asked) << name;
    // Draco's memory is nearly all by records, of which a mesh may have one for each corner.
    const size_t most = spec.format == MeshFormat::kDraco ? 5 : 3;
    EXPECT_LE(asked, most * peak + kLeastBytes) << name;
  }

  void ExpectAllBounded(const std::string& name, int segments) {
    for (const auto format : kFormats) {
      for (const NormalMode normals : {NormalMode::kNone, NormalMode::kSmooth}) {
        const bool smooth = normals == NormalMode::kSmooth;
        ExpectBounded(name + (smooth ? ", n" : ""),
                      {.format = format, .segments = segments, .normals = normals});
        if (!format.has_value()) continue;
        ExpectBounded(name + (smooth ? ", patches, n" : ", patches"),
                      {.format = format,
                       .segments = segments,
                       .normals = normals,
                       .geometry = ExportGeometry::kPatches});
        ExpectBounded(
            name + (smooth ? ", original, n" : ", original"),
            {.format = format, .normals = normals, .geometry = ExportGeometry::kOriginal});
      }
    }
  }

  std::unique_ptr<Backend> backend_ = MakeCpuBackend({.threads = 1});
  RenderBackend render_backend_{backend_.get(), std::make_shared<MemoryBudget>(uint64_t{1} << 30)};
  RenderInput input_;
};

TEST_F(ExportMemoryTest, OfManySegments) {
  Make(UglyGrid(40, false));
  ExpectAllBounded("10 segments", 10);
}

// The segments limit the points, so that the view has nearly as many as it may have.
TEST_F(ExportMemoryTest, OfATolerance) {
  Make(std::make_shared<const PolygonMesh>(testing::TorusMesh(40, 30)), 0.2);
  for (const auto format : kFormats) {
    if (!format.has_value()) continue;
    const double tolerance =
        format == MeshFormat::kDraco ? 1.2e-4 : 1e-6;  // above the rounding of 16 bits
    for (const NormalMode normals : {NormalMode::kNone, NormalMode::kSmooth}) {
      ExpectBounded("tolerance",
                    {.format = format, .segments = 8, .tolerance = tolerance, .normals = normals});
    }
  }
}

TEST_F(ExportMemoryTest, OfOneSegment) {
  Make(UglyGrid(200, false));
  ExpectAllBounded("1 segment", 1);
}

TEST_F(ExportMemoryTest, OfASmallSurface) {
  Make(UglyGrid(1, false));
  ExpectAllBounded("small", 1);
}

// Its normals and its quantised positions have no pattern that Draco could use.
TEST_F(ExportMemoryTest, OfAWildSurface) {
  Make(UglyGrid(100, false), 1e-2);
  ExpectAllBounded("wild", 3);
}

// What an uploaded file adds: its JSON, its pictures, the lines that name material libraries.
TEST_F(ExportMemoryTest, OfMaterialsOfTheUpload) {
  Make(UglyGrid(10, true));
  std::string text =
      R"({"buffers":[{"byteLength":3000000}],"bufferViews":[{"buffer":0,"byteLength":3000000}],)"
      R"("images":[{"bufferView":0}],"textures":[{"source":0}],"materials":[{"name":"a"})";
  while (text.size() < 400'000) text += R"(,{"emissiveFactor":[1e9,1e9,1e9]})";
  text += "]}";
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto word = [](size_t value) {
    const auto number = static_cast<uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&number), sizeof(number));
  };
  const std::string picture(3'000'000, 'p');
  const std::string glb = "glTF" + word(2) + word(28 + text.size() + picture.size()) +
                          word(text.size()) + "JSON" + text + word(picture.size()) +
                          std::string("BIN\0", 4) + picture;
  std::string obj;
  while (obj.size() < 4'000'000) obj += "mtllib a library with a name of some length.mtl\n";
  for (const auto& [format, upload] : {std::pair{MeshFormat::kGlb, glb}, {MeshFormat::kObj, obj}}) {
    const ExportSpec spec{.format = format,
                          .geometry = ExportGeometry::kOriginal,
                          .upload = std::make_shared<const std::string>(upload)};
    const uint64_t asked = ExportMemoryBytes(*input_.state->plan, spec);
    const testing::PeakMemory counted;
    const auto file = ExportSurface(input_, spec, NeverStop);
    ASSERT_OK(file);
    EXPECT_LE(counted.peak(), asked) << MeshFormatName(format);
    EXPECT_GT(file->bytes.size(), format == MeshFormat::kGlb ? picture.size() : 0);
  }
}

TEST_F(ExportMemoryTest, OfUvsAndGroups) {
  Make(UglyGrid(60, true));
  ExpectAllBounded("groups", 4);
}

}  // namespace
}  // namespace latticed
