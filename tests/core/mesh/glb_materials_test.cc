// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Materials and pictures of an uploaded file in the files that are written from it.
#include <nlohmann/json.hpp>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/mesh/glb_layout.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/write/write_mesh.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace latticed {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kPicture[] = "\x89PNG a picture of 23 B";

std::string Glb(const json& document, std::string binary) {
  std::string text = document.dump();
  text.resize(glb::Aligned(text.size()), ' ');
  binary.resize(glb::Aligned(binary.size()), '\0');
  const auto word = [](size_t value) { return testing::Raw(static_cast<uint32_t>(value)); };
  return word(glb::kMagic) + word(2) + word(28 + text.size() + binary.size()) + word(text.size()) +
         word(glb::kJsonChunk) + text + word(binary.size()) + word(glb::kBinaryChunk) + binary;
}

json JsonOf(const std::string& file) {
  return json::parse(file.substr(20, LoadLittleEndian<uint32_t>(&file[12])));
}
std::string BinaryOf(const std::string& file) {
  return file.substr(28 + LoadLittleEndian<uint32_t>(&file[12]));
}

// A file with a picture, a transformed texture of it, and two materials, of which the second also has a texture of
// other texture coordinates.
std::string Source() {
  const json document = json::parse(R"({
    "asset": {"version": "2.0"},
    "buffers": [{"byteLength": 31}],
    "bufferViews": [{"buffer": 0, "byteLength": 8}, {"buffer": 0, "byteOffset": 8, "byteLength": 23}],
    "images": [{"bufferView": 1, "mimeType": "image/png", "name": "bricks"}],
    "samplers": [{"wrapS": 33071}],
    "textures": [{"source": 0, "sampler": 0}],
    "materials": [
      {"name": "unused"},
      {"name": "red", "alphaMode": "MASK",
       "pbrMetallicRoughness": {
         "baseColorTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}},
         "metallicRoughnessTexture": {"index": 0, "texCoord": 1}},
       "normalTexture": {"index": 0, "extensions": {"KHR_texture_transform": {"texCoord": 2}}}}],
    "extensionsUsed": ["KHR_texture_transform", "KHR_lights_punctual"]})");
  return Glb(document, std::string(8, 'g') + std::string(kPicture, 23));
}

TEST(GlbMaterialsTest, AreWrittenWithTheirPictures) {
  const std::string source = Source();
  const auto file =
      WriteGlb(testing::SquareOfTwoGroups(), {.source = source, .source_format = MeshFormat::kGlb});
  ASSERT_OK(file);
  ASSERT_OK(ReadGlb(*file));
  const json document = JsonOf(*file);

  ASSERT_EQ(document["materials"].size(),
            3u);  // two of the source, and one of a group that it does not have
  EXPECT_EQ(document["materials"][1]["alphaMode"], "MASK");
  EXPECT_EQ(document["materials"][2]["name"], "a \"quoted\" name");
  EXPECT_EQ(document["meshes"][0]["primitives"][0]["material"], 1);
  EXPECT_EQ(document["meshes"][0]["primitives"][1]["material"], 2);
  EXPECT_EQ(document["textures"], json::parse(R"([{"source": 0, "sampler": 0}])"));
  EXPECT_EQ(document["samplers"], json::parse(R"([{"wrapS": 33071}])"));
  const json& image = document["images"][0];
  EXPECT_EQ(image["mimeType"], "image/png");
  const json& view = document["bufferViews"][image["bufferView"].get<size_t>()];
  EXPECT_EQ(view["byteOffset"].get<size_t>() % 4, 0u);
  EXPECT_EQ(BinaryOf(*file).substr(view["byteOffset"], view["byteLength"]),
            std::string(kPicture, 23));
  EXPECT_GE(document["buffers"][0]["byteLength"].get<size_t>(),
            view["byteOffset"].get<size_t>() + 23);
}

TEST(GlbMaterialsTest, TexturesOfOtherCoordinatesAndForeignExtensionsAreLeftOut) {
  const std::string source = Source();
  const auto file =
      WriteGlb(testing::SquareOfTwoGroups(), {.source = source, .source_format = MeshFormat::kGlb});
  ASSERT_OK(file);
  const json document = JsonOf(*file);
  const json& material = document["materials"][1];
  EXPECT_TRUE(material["pbrMetallicRoughness"].contains("baseColorTexture"));
  EXPECT_FALSE(material["pbrMetallicRoughness"].contains("metallicRoughnessTexture"));
  EXPECT_FALSE(material.contains("normalTexture"));
  EXPECT_EQ(document["extensionsUsed"], json::parse(R"(["KHR_texture_transform"])"));
}

// Each name would be looked for in all materials.
TEST(GlbMaterialsTest, ManyNamesOfExtensionsAndManyMaterialsTakeNoLongerThanToReadThem) {
  json document = JsonOf(Source());
  for (int i = 0; i < 50'000; ++i) {
    document["extensionsUsed"].push_back("KHR_texture_transform");
    document["materials"].push_back(json::object());
  }
  const std::string source = Glb(document, BinaryOf(Source()));
  const absl::Time start = absl::Now();
  const auto file =
      WriteGlb(testing::SquareOfTwoGroups(), {.source = source, .source_format = MeshFormat::kGlb});
  EXPECT_LT(absl::Now() - start, absl::Seconds(5));
  ASSERT_OK(file);
  EXPECT_EQ(JsonOf(*file)["extensionsUsed"], json::parse(R"(["KHR_texture_transform"])"));
}

TEST(GlbMaterialsTest, APictureOfSeveralImagesIsWrittenOnce) {
  json document = JsonOf(Source());
  for (int i = 0; i < 100; ++i) document["images"].push_back({{"bufferView", 1}});
  const std::string source = Glb(document, BinaryOf(Source()));
  const auto file =
      WriteGlb(testing::SquareOfTwoGroups(), {.source = source, .source_format = MeshFormat::kGlb});
  ASSERT_OK(file);
  EXPECT_EQ(JsonOf(*file)["images"].size(), 101u);
  EXPECT_EQ(JsonOf(*file)["images"][0]["bufferView"], JsonOf(*file)["images"][100]["bufferView"]);
}

// A small file could otherwise become one of gigabytes.
TEST(GlbMaterialsTest, PicturesThatOverlapAreNotKept) {
  json document = JsonOf(Source());
  std::string binary(100'000, 'x');
  document["buffers"][0]["byteLength"] = binary.size();
  for (int i = 0; i < 100; ++i) {
    document["images"].push_back({{"bufferView", document["bufferViews"].size()}});
    document["bufferViews"].push_back({{"buffer", 0}, {"byteLength", binary.size()}});
  }
  const std::string source = Glb(document, binary);
  const auto file =
      WriteGlb(testing::SquareOfTwoGroups(), {.source = source, .source_format = MeshFormat::kGlb});
  ASSERT_OK(file);
  EXPECT_LT(file->size(), 10'000u);
  EXPECT_FALSE(JsonOf(*file).contains("images"));
  EXPECT_EQ(JsonOf(*file)["materials"][0]["name"], "red");
}

TEST(GlbMaterialsTest, WhatIsWrongInTheSourceIsNotThere) {
  for (const char* images : {R"([{"bufferView": 7}])", R"([{"bufferView": -1}, 5])", "{}"}) {
    json document = JsonOf(Source());
    document["images"] = json::parse(images);
    const std::string source = Glb(document, std::string(31, 'x'));
    const auto file = WriteGlb(testing::SquareOfTwoGroups(),
                               {.source = source, .source_format = MeshFormat::kGlb});
    ASSERT_OK(file) << images;
    EXPECT_OK(ReadGlb(*file)) << images;
  }
  for (const std::string& source : {std::string("no GLB"), Glb(json::array(), "")}) {
    const auto file = WriteGlb(testing::SquareOfTwoGroups(),
                               {.source = source, .source_format = MeshFormat::kGlb});
    ASSERT_OK(file);
    EXPECT_EQ(JsonOf(*file)["materials"].size(), 2u);
  }
}

TEST(ObjMaterialsTest, LibrariesOfTheSourceAreNamed) {
  const std::string source = "# cow\nmtllib cow.mtl\r\nv 0 0 0\n#mtllib no.mtl\nmtllib b c.mtl\n";
  const PolygonMesh mesh = testing::SquareOfTwoGroups();
  const std::string text = WriteObj(mesh, {.source = source});
  EXPECT_THAT(text, HasSubstr("mtllib cow.mtl\nmtllib b c.mtl\nv "));
  EXPECT_THAT(WriteObj(mesh, {.source = source, .source_format = MeshFormat::kGlb}),
              Not(HasSubstr("mtllib")));
  std::string many = "mtllib first.mtl\n";
  while (many.size() < 1'000'000) many += "mtllib one_of_many.mtl\n";
  EXPECT_LT(WriteObj(mesh, {.source = many}).size(), 100'000u);
  EXPECT_THAT(WriteObj(mesh, {.source = many}), HasSubstr("mtllib first.mtl\n"));
}

}  // namespace
}  // namespace latticed
