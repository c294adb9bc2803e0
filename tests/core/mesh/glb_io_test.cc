// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/mesh_io.h"

#include <limits>
#include <nlohmann/json.hpp>

#include "core/mesh/little_endian.h"
#include "core/mesh/write/write_mesh.h"
#include "tests/core/mesh/mesh_fixtures.h"

namespace latticed {
namespace {

using ::latticed::testing::IsMalformed;
using ::latticed::testing::Raw;
using ::nlohmann::json;
using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

std::string Glb(std::string text, std::string binary) {
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string body = Raw(static_cast<uint32_t>(text.size())) + "JSON" + text;
  if (!binary.empty()) {
    body += Raw(static_cast<uint32_t>(binary.size())) + std::string("BIN\0", 4) + binary;
  }
  return "glTF" + Raw(uint32_t{2}) + Raw(static_cast<uint32_t>(12 + body.size())) + body;
}

std::string Floats(const std::vector<float>& values) {
  std::string bytes;
  for (float value : values) bytes += Raw(value);
  return bytes;
}

// One node with one triangle (0,0,0) (1,0,0) (0,1,0), normals along z, indices in ushort. Each test
// changes the part that it tests.
struct Triangle {
  json document = json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"name": "tri", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2}]}],
    "accessors": [
      {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
      {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC3"},
      {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 72}, {"buffer": 0, "byteOffset": 72, "byteLength": 6}],
    "buffers": [{"byteLength": 78}]})");
  std::string binary = Floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 1}) +
                       Raw(uint16_t{0}) + Raw(uint16_t{1}) + Raw(uint16_t{2});

  json& primitive() { return document["meshes"][0]["primitives"][0]; }
  absl::StatusOr<PolygonMesh> Read() const { return ReadGlb(Glb(document.dump(), binary)); }
};

// The same with six points and without indices.
Triangle SixPoints(const std::vector<float>& coordinates) {
  Triangle file;
  file.binary = Floats(coordinates);
  file.document["bufferViews"] = json::parse(R"([{"buffer": 0, "byteLength": 72}])");
  file.document["buffers"][0]["byteLength"] = 72;
  file.document["accessors"] =
      json::parse(R"([{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"}])");
  file.primitive() = json::parse(R"({"attributes": {"POSITION": 0}})");
  return file;
}

TEST(GlbReaderTest, OneTriangle) {
  ASSERT_OK_AND_ASSIGN(const auto mesh, Triangle().Read());
  EXPECT_THAT(testing::CornerPositions(mesh),
              ElementsAre(Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}));
  EXPECT_EQ(testing::CornerNormals(mesh), (std::vector<Vec3f>(3, Vec3f{0, 0, 1})));
  EXPECT_THAT(mesh.group_names, ElementsAre("tri"));
}

TEST(GlbReaderTest, NodeTransformsAreComposed) {
  Triangle file;
  file.document["nodes"] = json::parse(
      R"([{"children": [1], "translation": [10, 0, 0]},
          {"mesh": 0, "scale": [2, 3, 4], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]}])");
  ASSERT_OK_AND_ASSIGN(const auto mesh, file.Read());
  const std::vector<Vec3d> corners = testing::CornerPositions(mesh);
  EXPECT_LT(Norm(corners[1] - Vec3d{10, 2, 0}), 1e-12);  // a quarter turn takes x to y, y to -x
  EXPECT_LT(Norm(corners[2] - Vec3d{7, 0, 0}), 1e-12);
}

TEST(GlbReaderTest, NormalsGoByTheInverseTranspose) {
  Triangle file;
  file.binary.replace(36, 36, Floats({0.6f, 0, 0.8f, 0.6f, 0, 0.8f, 0.6f, 0, 0.8f}));
  file.document["nodes"][0]["matrix"] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1};
  ASSERT_OK_AND_ASSIGN(const auto mesh, file.Read());
  EXPECT_EQ(testing::CornerPositions(mesh)[1], (Vec3d{7, 6, 7}));
  const Vec3d wanted = Vec3d{0.3, 0, 0.8} / std::sqrt(0.73);
  EXPECT_LT(Norm(ToDouble(testing::CornerNormals(mesh)[0]) - wanted), 1e-6);
}

TEST(GlbReaderTest, MirroredNodesKeepFacesAndNormalsOnOneSide) {
  Triangle file;
  file.document["nodes"][0]["scale"] = {-1, 1, 1};
  ASSERT_OK_AND_ASSIGN(const auto mesh, file.Read());
  const std::vector<Vec3d> corners = testing::CornerPositions(mesh);
  EXPECT_EQ(Cross(corners[1] - corners[0], corners[2] - corners[0]), (Vec3d{0, 0, 1}));
  EXPECT_EQ(testing::CornerNormals(mesh)[0], (Vec3f{0, 0, 1}));
}

TEST(GlbReaderTest, ListsStripsFansAndNoIndices) {
  Triangle file = SixPoints({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0, 1, 2, 0});
  ASSERT_OK_AND_ASSIGN(const auto list, file.Read());
  EXPECT_THAT(list.corner_vertices, ElementsAre(0, 1, 2, 3, 4, 5));
  file.primitive()["mode"] = 5;
  ASSERT_OK_AND_ASSIGN(const auto strip, file.Read());
  EXPECT_EQ(strip.face_count(), 4u);
  const auto corners = testing::CornerPositions(strip);
  for (size_t c = 0; c < corners.size(); c += 3) {  // all have the same orientation
    EXPECT_EQ(Cross(corners[c + 1] - corners[c], corners[c + 2] - corners[c]), (Vec3d{0, 0, 1}));
  }
  file.primitive()["mode"] = 6;
  ASSERT_OK_AND_ASSIGN(const auto fan, file.Read());
  EXPECT_EQ(fan.face_count(), 4u);
  for (size_t c = 0; c < 12; c += 3) EXPECT_EQ(testing::CornerPositions(fan)[c], (Vec3d{0, 0, 0}));
  file.primitive()["mode"] = 1;
  EXPECT_THAT(file.Read(), IsMalformed("no faces"));  // lines
}

TEST(GlbReaderTest, VerticesDoubledAtSeamsAreOne) {
  ASSERT_OK_AND_ASSIGN(const auto mesh,
                       SixPoints({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0}).Read());
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
}

// The first and the fourth point have one place and one weight; the third and the fifth have one place and two weights. The
// second primitive has none, so its vertices have the weight 1.
TEST(GlbReaderTest, WeightsKeepVerticesApart) {
  Triangle file = SixPoints({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0});
  file.binary += Floats({0, 0.5f, 1, 0, 0.25f, 0.75f});
  file.document["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 72}, {"byteLength", 24}});
  file.document["buffers"][0]["byteLength"] = 96;
  file.document["accessors"].push_back(
      {{"bufferView", 1}, {"componentType", 5126}, {"count", 6}, {"type", "SCALAR"}});
  file.document["meshes"][0]["primitives"].push_back(file.primitive());
  file.primitive()["attributes"]["_WEIGHT"] = 1;
  ASSERT_OK_AND_ASSIGN(const auto mesh, file.Read());
  EXPECT_THAT(mesh.corner_vertices, ElementsAre(0, 1, 2, 0, 3, 4, 5, 6, 2, 5, 2, 7));
  EXPECT_THAT(mesh.weights, ElementsAre(0, 0.5f, 1, 0.25f, 0.75f, 1, 1, 1));

  file.document["accessors"][1]["count"] = 5;
  EXPECT_THAT(file.Read(), IsMalformed("different counts"));
}

TEST(GlbReaderTest, QuantisedAttributesAndByteIndices) {
  Triangle file;
  file.binary.clear();
  for (int16_t x : {0, 0, 0, 0, 32767, 0, 0, 0, 0, -32768, 0, 0})
    file.binary += Raw(x);  // 8 bytes apart
  for (uint8_t uv : {0, 255, 255, 0, 51, 0}) file.binary += Raw(uv);
  for (uint8_t i : {2, 1, 0}) file.binary += Raw(i);
  file.document["bufferViews"] = json::parse(
      R"([{"buffer": 0, "byteLength": 24, "byteStride": 8}, {"buffer": 0, "byteOffset": 24, "byteLength": 9}])");
  file.document["buffers"][0]["byteLength"] = 33;
  file.document["accessors"] = json::parse(
      R"([{"bufferView": 0, "componentType": 5122, "normalized": true, "count": 3, "type": "VEC3"},
          {"bufferView": 1, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC2"},
          {"bufferView": 1, "byteOffset": 6, "componentType": 5121, "count": 3, "type": "SCALAR"}])");
  file.document["extensionsRequired"] = {"KHR_mesh_quantization"};
  file.primitive() =
      json::parse(R"({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2})");
  ASSERT_OK_AND_ASSIGN(const auto mesh, file.Read());
  EXPECT_THAT(testing::CornerPositions(mesh),
              ElementsAre(Vec3d{0, -1, 0}, Vec3d{1, 0, 0}, Vec3d{0, 0, 0}));
  EXPECT_THAT(testing::CornerUvs(mesh), ElementsAre(Vec2f{0.2f, 1}, Vec2f{1, 1}, Vec2f{0, 0}));
}

TEST(GlbReaderTest, ImagesExtrasAndOtherPartsAreNotLookedAt) {
  Triangle file;
  file.document["images"] = json::parse(R"([{"uri": "/etc/passwd"}, {"bufferView": 99}])");
  file.document["textures"] = json::parse(R"([{"source": 7}])");
  file.document["materials"] = json::parse(
      R"([{"name": "wood", "pbrMetallicRoughness": {"baseColorTexture": {"index": 9}}}])");
  file.document["extras"] = {{"anything", {1, 2, 3}}};
  file.document["animations"] = "not even an array";
  file.document["skins"] = json::parse(R"([{"joints": [55]}])");
  file.primitive()["material"] = 0;
  ASSERT_OK_AND_ASSIGN(const auto mesh, file.Read());
  EXPECT_THAT(mesh.group_names, ElementsAre("wood"));
}

TEST(GlbReaderTest, BadContainers) {
  const Triangle file;
  const std::string good = Glb(file.document.dump(), file.binary);
  EXPECT_THAT(ReadGlb(""), IsMalformed("byte 0: the header is cut off"));
  EXPECT_THAT(ReadGlb("glTG" + good.substr(4)),
              IsMalformed("byte 0: it does not start with 'glTF'"));
  std::string version = good;
  version[4] = 1;
  EXPECT_THAT(ReadGlb(version), IsMalformed("byte 4: version 1; only 2 is known"));
  std::string type = good;
  type[16] = 'X';
  EXPECT_THAT(ReadGlb(type), IsMalformed("byte 12: a chunk of another type"));
  for (size_t size = 0; size < good.size(); ++size) {
    EXPECT_THAT(ReadGlb(std::string_view(good).substr(0, size)), IsMalformed("GLB")) << size;
    if (size < 12) continue;
    std::string shorter = good.substr(0, size);  // with a header that agrees
    shorter.replace(8, 4, Raw(static_cast<uint32_t>(size)));
    EXPECT_THAT(ReadGlb(shorter), IsMalformed("GLB")) << size;
  }
}

TEST(GlbReaderTest, BadJson) {
  EXPECT_THAT(ReadGlb(Glb("{", "")), IsMalformed("not a JSON object"));
  EXPECT_THAT(ReadGlb(Glb("[]", "")), IsMalformed("not a JSON object"));
  EXPECT_THAT(ReadGlb(Glb("{}", "")), IsMalformed("no faces"));
  EXPECT_THAT(ReadGlb(Glb(std::string(100'000, '['), "")), IsMalformed("nested deeper than 64"));
  std::string deep = "{\"nodes\":";
  for (int i = 0; i < 100'000; ++i) deep += "{\"extras\":";
  EXPECT_THAT(ReadGlb(Glb(deep, "")), IsMalformed("nested deeper than 64"));
}

// Sets the value at a JSON pointer and expects a refusal.
struct BadGlb {
  const char* pointer;
  const char* value;
  const char* message;
};
class BadGlbTest : public ::testing::TestWithParam<BadGlb> {};
INSTANTIATE_TEST_SUITE_P(
    All, BadGlbTest,
    ::testing::Values(
        BadGlb{"/scene", "3", "scene: there are 1 scenes"},
        BadGlb{"/scenes/0/nodes/0", "9", "nodes[9]: there are 1 nodes"},
        BadGlb{"/scenes/0/nodes/1", "0", "nodes[0]: it has two parents"},
        BadGlb{"/nodes/0/children", "[0]", "nodes[0]: it has two parents"},
        BadGlb{"/nodes/0/mesh", "4", "nodes[0]: mesh 4; there are 1"},
        BadGlb{"/nodes/0/mesh", "-7", "nodes[0]: mesh -7; there are 1"},
        BadGlb{"/nodes/0/translation", "[1e300, 0, 0]", "farther than 1e+15"},
        BadGlb{"/nodes/0/scale", "[1e200, 1e200, 1e200]", "farther than 1e+15"},
        BadGlb{"/meshes/0/primitives/0/attributes/POSITION", "9", "accessors[9]: there are 3"},
        BadGlb{"/meshes/0/primitives/0/attributes/POSITION", "2",
               "accessors[2]: 3 components are needed"},
        BadGlb{"/meshes/0/primitives/0/attributes/NORMAL", "-2", "accessors[-2]: there are 3"},
        BadGlb{"/meshes/0/primitives/0/indices", "12", "GLB"},
        BadGlb{"/meshes/0/primitives/0/indices", "0", "accessors[0]: 1 components are needed"},
        BadGlb{"/accessors/0/bufferView", "5", "accessors[0]: it has no buffer view"},
        BadGlb{"/accessors/0/count", "4", "its attributes have different counts"},
        BadGlb{"/accessors/0/count", "7",
               "accessors[0]: 7 elements of 12 bytes do not fit into 72"},
        BadGlb{"/accessors/0/count", "18446744073709551615", "do not fit into 72"},
        BadGlb{"/accessors/1/byteOffset", "40",
               "accessors[1]: 3 elements of 12 bytes do not fit into 32"},
        BadGlb{"/accessors/1/byteOffset", "1000000000000", "accessors[1]"},
        BadGlb{"/accessors/0/componentType", "5130", "GLB"},
        BadGlb{"/accessors/0/componentType", "5124", "accessors[0]: component type 5124"},
        BadGlb{"/accessors/2/componentType", "5122",
               "accessors[2]: indices are not unsigned integers"},
        BadGlb{"/accessors/0/type", "\"VEC4\"", "accessors[0]: 3 components are needed"},
        BadGlb{
            "/accessors/0/sparse",
            R"({"count": 1, "indices": {"bufferView": 1, "componentType": 5123}, "values": {"bufferView": 0}})",
            "sparse accessors are not supported"},
        BadGlb{"/bufferViews/0/byteStride", "4", "GLB"},
        BadGlb{"/bufferViews/0/byteLength", "100",
               "accessors[0]: its buffer view leaves the buffer"},
        BadGlb{"/bufferViews/0/byteOffset", "77",
               "accessors[0]: its buffer view leaves the buffer"},
        BadGlb{"/bufferViews/0/byteOffset", "18446744073709551615", "accessors[0]"},
        BadGlb{"/bufferViews/0/buffer", "1", "accessors[0]: its buffer does not exist"},
        BadGlb{"/buffers/0/byteLength", "1000", "not within the BIN chunk, which has 80 bytes"},
        BadGlb{"/buffers/0/byteLength", "0", "not within the BIN chunk"},
        BadGlb{"/buffers/0/byteLength", "-1", "not within the BIN chunk"},
        BadGlb{"/buffers/0/uri", "\"other.bin\"", "buffers[0].uri: only the BIN chunk is read"},
        BadGlb{"/buffers/1", R"({"byteLength": 8})", "buffers[1]: only the BIN chunk is read"},
        BadGlb{"/extensionsRequired", R"(["KHR_draco_mesh_compression"])",
               "the extension 'KHR_draco_mesh_compression' is not supported"}));

TEST_P(BadGlbTest, IsRefusedByName) {
  Triangle file;
  file.document[json::json_pointer(GetParam().pointer)] = json::parse(GetParam().value);
  EXPECT_THAT(file.Read(), IsMalformed(GetParam().message)) << GetParam().pointer;
}

TEST(GlbReaderTest, WrongTypesAnywhereNeverEscapeAsExceptions) {
  const json flat = Triangle().document.flatten();
  for (const auto& [pointer, value] : flat.items()) {
    for (const char* wrong :
         {"null", "true", "\"text\"", "-1", "1.5", "1e40", "[]", "{}", "[[]]"}) {
      Triangle file;
      file.document[json::json_pointer(pointer)] = json::parse(wrong);
      const auto mesh = file.Read();  // some are harmless, none may crash
      if (mesh.ok()) continue;
      EXPECT_THAT(mesh, IsMalformed("GLB")) << pointer << " = " << wrong;
    }
  }
}

TEST(GlbReaderTest, BadNumbersInTheBuffer) {
  Triangle index;
  index.binary[76] = 3;
  EXPECT_THAT(index.Read(), IsMalformed("vertex index 3 is out of range; it has 3"));
  for (float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Triangle position;
    position.binary.replace(4, 4, Raw(bad));
    EXPECT_THAT(position.Read(), IsMalformed("vertex 0 is not finite"));
    Triangle normal;
    normal.binary.replace(40, 4, Raw(bad));
    EXPECT_THAT(normal.Read(), IsMalformed("normal 0 is not finite"));
  }
}

TEST(GlbReaderTest, LongChainsOfNodesAreNoStackOverflow) {
  constexpr int kNodes = 100'000;
  Triangle file;
  file.document["nodes"] = json::array();
  for (int i = 0; i + 1 < kNodes; ++i) file.document["nodes"].push_back({{"children", {i + 1}}});
  file.document["nodes"].push_back({{"mesh", 0}});
  EXPECT_OK(file.Read());
}

TEST(GlbReaderTest, RepeatedMeshesMayNotGrowWithoutBound) {
  Triangle file;
  constexpr int kTriangles = 4'000, kNodes = 4'000;
  file.binary.resize(72);
  for (int i = 0; i < kTriangles; ++i)
    file.binary += Raw(uint16_t{0}) + Raw(uint16_t{1}) + Raw(uint16_t{2});
  file.document["buffers"][0]["byteLength"] = file.binary.size();
  file.document["bufferViews"][1]["byteLength"] = 6 * kTriangles;
  file.document["accessors"][2]["count"] = 3 * kTriangles;
  file.document["nodes"] = json::array();
  file.document["scenes"][0]["nodes"] = json::array();
  for (int i = 0; i < kNodes; ++i) {
    file.document["nodes"].push_back({{"mesh", 0}});
    file.document["scenes"][0]["nodes"].push_back(i);
  }
  EXPECT_THAT(file.Read(), IsMalformed("grow far beyond the size of the file"));
}

json DocumentOf(const std::string& glb) {
  return json::parse(glb.substr(20, LoadLittleEndian<uint32_t>(&glb[12])));
}

TEST(GlbWriterTest, ReadsBackWithGroups) {
  const PolygonMesh mesh = testing::SquareOfTwoGroups();
  ASSERT_OK_AND_ASSIGN(const auto bytes, WriteGlb(mesh));
  ASSERT_OK_AND_ASSIGN(const auto read, ReadGlb(bytes));
  EXPECT_EQ(testing::CornerPositions(read), testing::CornerPositions(mesh));
  EXPECT_EQ(testing::CornerNormals(read), testing::CornerNormals(mesh));
  EXPECT_EQ(testing::CornerUvs(read), testing::CornerUvs(mesh));
  EXPECT_EQ(read.group_names, mesh.group_names);
  EXPECT_EQ(read.face_groups, mesh.face_groups);
  EXPECT_EQ(read.positions.size(), 4u);
}

TEST(GlbWriterTest, FarAwayMeshesKeepTheirPrecision) {
  const Vec3d origin{1e9, -1e9, 1e9};
  const PolygonMesh mesh = testing::SquareOfTwoGroups(origin);
  ASSERT_OK_AND_ASSIGN(const auto bytes, WriteGlb(mesh));
  ASSERT_OK_AND_ASSIGN(const auto read, ReadGlb(bytes));
  EXPECT_EQ(testing::CornerPositions(read),
            testing::CornerPositions(mesh));  // float32 has steps of 64 there
}

TEST(GlbWriterTest, IsValidGltf) {
  ASSERT_OK_AND_ASSIGN(const auto bytes, WriteGlb(testing::SquareOfTwoGroups({2, 0, 0})));
  EXPECT_EQ(bytes.size() % 4, 0u);
  EXPECT_EQ(LoadLittleEndian<uint32_t>(&bytes[8]), bytes.size());
  const uint32_t text = LoadLittleEndian<uint32_t>(&bytes[12]);
  EXPECT_EQ(text % 4, 0u);
  const uint32_t binary = LoadLittleEndian<uint32_t>(&bytes[20 + text]);
  EXPECT_EQ(bytes.size(), 28u + text + binary);
  const json document = DocumentOf(bytes);
  EXPECT_EQ(document["asset"]["version"], "2.0");
  EXPECT_EQ(document["scenes"], json::parse(R"([{"nodes": [0]}])"));
  EXPECT_EQ(document["nodes"], json::parse(R"([{"mesh": 0, "translation": [2.5, 0.5, 0.25]}])"));
  EXPECT_EQ(document["accessors"][0]["min"], json::parse("[-0.5, -0.5, -0.25]"));
  EXPECT_EQ(document["accessors"][0]["max"], json::parse("[0.5, 0.5, 0.25]"));
  EXPECT_EQ(document["buffers"][0]["byteLength"], 4 * 32 + 2 * 12);
  for (const json& view : document["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"].get<size_t>() % 4, 0u);
    EXPECT_LE(view["byteOffset"].get<size_t>() + view["byteLength"].get<size_t>(), binary);
  }
  EXPECT_EQ(document["meshes"][0]["primitives"].size(), 2u);
  EXPECT_EQ(document["materials"][1]["name"], "a \"quoted\" name");
}

TEST(GlbWriterTest, EmptyMeshesAndOddNamesAreStillValid) {
  ASSERT_OK_AND_ASSIGN(const auto empty, WriteGlb({}));
  EXPECT_EQ(DocumentOf(empty)["scenes"], json::parse("[{}]"));
  EXPECT_THAT(ReadGlb(empty), IsMalformed("no faces"));
  PolygonMesh mesh = testing::SquareOfTwoGroups();
  mesh.group_names = {"\xff not UTF-8", "unused", "b"};
  mesh.face_groups = {0, 2};
  ASSERT_OK_AND_ASSIGN(const auto bytes, WriteGlb(mesh));
  EXPECT_EQ(DocumentOf(bytes)["materials"].size(), 2u);
}

}  // namespace
}  // namespace latticed
