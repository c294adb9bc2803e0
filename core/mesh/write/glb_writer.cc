// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Binary glTF 2.0: one mesh on one node, with a primitive for each group. With known units the node is the child of a
// root that rotates and scales to glTF's own (metres, +y up), and asset.extras names the units.
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>
#include <vector>

#include "core/base/bounds.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/mesh/glb_layout.h"
#include "core/mesh/little_endian.h"
#include "core/mesh/write/glb_materials.h"
#include "core/mesh/write/vertex_records.h"
#include "core/mesh/write/write_mesh.h"

namespace latticed {
namespace {

using nlohmann::json;

// The rotation and scale from world units to glTF's, which are metres, +y up, right-handed.
// Column-major. Unknown units count as glTF's.
json ToGltf(const MeshUnits& units) {
  const double s = units.meters_per_unit > 0 ? units.meters_per_unit : 1;
  if (units.up_axis == "z") return json::array({s, 0, 0, 0, 0, 0, -s, 0, 0, s, 0, 0, 0, 0, 0, 1});
  if (units.up_axis == "x") return json::array({0, s, 0, 0, -s, 0, 0, 0, 0, 0, s, 0, 0, 0, 0, 1});
  return json::array({s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, 0, 0, 0, 1});
}

class GlbBuilder {
 public:
  GlbBuilder(const PolygonMesh& mesh, const FileExtras& extras)
      : mesh_(mesh),
        units_(extras.units),
        vertices_(MakeVertexRecords(mesh)),
        materials_(extras.source_format == MeshFormat::kGlb ? extras.source : std::string_view()) {
    Bounds bounds;
    for (Vec3d p : mesh.positions) bounds.Extend(p);
    if (!bounds.empty()) center_ = bounds.center();
  }

  absl::StatusOr<std::string> Build() {
    const size_t point_bytes = sizeof(Vec3f) + (mesh_.has_normals() ? sizeof(Vec3f) : 0) +
                               (mesh_.has_uvs() ? sizeof(Vec2f) : 0);
    const size_t binary_bytes = vertices_.records.size() * point_bytes +
                                mesh_.corner_count() * sizeof(uint32_t) + materials_.PictureBytes();
    constexpr size_t kRoomForJson = size_t{64} << 20;
    constexpr size_t kMostBytes = std::numeric_limits<uint32_t>::max() - kRoomForJson;
    if (binary_bytes > kMostBytes)
      return error::OutOfMemory("a GLB file", binary_bytes, kMostBytes);
    binary_.reserve(binary_bytes + MostJsonBytes());
    AddAttributes();
    AddPrimitives();
    std::move(materials_).AddTo(document_, binary_);
    for (json& material : named_materials_) document_["materials"].push_back(std::move(material));
    Describe();
    return Pack();
  }

 private:
  // Enough that the JSON can be put in front of the binary chunk without a copy of that.
  size_t MostJsonBytes() const {
    constexpr size_t kBytes = 2'048, kBytesPerGroup = 640, kBytesPerNameByte = 6;
    size_t bytes = kBytes + materials_.MostJsonBytes();
    for (const std::string& name : mesh_.group_names) {
      bytes += kBytesPerGroup + kBytesPerNameByte * name.size();
    }
    return bytes;
  }

  // Adds a buffer view over what was appended since `begin`, with one accessor; returns its index.
  size_t AddAccessor(size_t begin, size_t count, int component_type, std::string_view type,
                     int target) {
    document_["bufferViews"].push_back(json::object({{"buffer", 0},
                                                     {"byteOffset", begin},
                                                     {"byteLength", binary_.size() - begin},
                                                     {"target", target}}));
    document_["accessors"].push_back(
        json::object({{"bufferView", document_["bufferViews"].size() - 1},
                      {"componentType", component_type},
                      {"count", count},
                      {"type", std::string(type)}}));
    return document_["accessors"].size() - 1;
  }

  void AddAttributes() {
    const size_t count = vertices_.records.size();
    if (count == 0) return;
    Bounds local;  // of the floats as written, which is what glTF asks for
    for (const VertexRecord& record : vertices_.records) {
      const Vec3f q = ToFloat(mesh_.positions[record.position] - center_);
      local.Extend(ToDouble(q));
      AppendLittleEndian(q, &binary_);
    }
    const size_t positions = AddAccessor(0, count, glb::kFloat, "VEC3", glb::kArrayBuffer);
    json& accessor = document_["accessors"][positions];
    accessor["min"] = json::array({local.min.x, local.min.y, local.min.z});
    accessor["max"] = json::array({local.max.x, local.max.y, local.max.z});
    attributes_["POSITION"] = positions;
    if (mesh_.has_normals()) {
      const size_t begin = binary_.size();
      for (const VertexRecord& record : vertices_.records) {
        AppendLittleEndian(NormalOf(mesh_, record), &binary_);
      }
      attributes_["NORMAL"] = AddAccessor(begin, count, glb::kFloat, "VEC3", glb::kArrayBuffer);
    }
    if (mesh_.has_uvs()) {
      const size_t begin = binary_.size();
      for (const VertexRecord& record : vertices_.records) {
        const Vec2f uv = UvOf(mesh_, record);
        AppendLittleEndian(Vec2f{uv.x, 1 - uv.y}, &binary_);
      }
      attributes_["TEXCOORD_0"] = AddAccessor(begin, count, glb::kFloat, "VEC2", glb::kArrayBuffer);
    }
  }

  size_t GroupOf(size_t triangle) const {
    return mesh_.face_groups.empty() ? 0 : mesh_.face_groups[triangle];
  }

  void AppendTriangle(size_t triangle) {
    for (size_t i = 0; i < 3; ++i) {
      AppendLittleEndian(vertices_.corner_records[3 * triangle + i], &binary_);
    }
  }

  void AddPrimitives() {
    const bool grouped = !mesh_.face_groups.empty();
    const size_t triangles = mesh_.face_count();
    // Where each group's triangles begin in `order`, which lists them group by group.
    std::vector<size_t> begins(grouped ? mesh_.group_names.size() + 1 : 2);
    for (size_t t = 0; t < triangles; ++t) ++begins[GroupOf(t) + 1];
    std::partial_sum(begins.begin(), begins.end(), begins.begin());
    std::vector<uint32_t> order(grouped ? triangles : 0);
    std::vector<size_t> ends(begins.begin(), begins.end() - 1);
    for (size_t t = 0; t < order.size(); ++t) order[ends[GroupOf(t)]++] = static_cast<uint32_t>(t);
    for (size_t g = 0; g < ends.size(); ++g) {
      if (begins[g] == begins[g + 1]) continue;  // glTF has no empty accessors
      const size_t begin = binary_.size();
      for (size_t i = begins[g]; i < begins[g + 1]; ++i) AppendTriangle(grouped ? order[i] : i);
      json primitive = json::object(
          {{"attributes", attributes_},
           {"indices", AddAccessor(begin, 3 * (begins[g + 1] - begins[g]), glb::kUnsignedInt,
                                   "SCALAR", glb::kElementArrayBuffer)},
           {"mode", glb::kTriangles}});
      if (grouped) primitive["material"] = MaterialOf(mesh_.group_names[g]);
      primitives_.push_back(std::move(primitive));
    }
  }

  // The source's, or one of the group's name, which comes after those of the source.
  size_t MaterialOf(const std::string& group) {
    if (const auto of_source = materials_.Find(group)) return *of_source;
    named_materials_.push_back(json::object({{"name", ValidUtf8(group)}, {"doubleSided", true}}));
    return materials_.count() + named_materials_.size() - 1;
  }

  void Describe() {
    document_["asset"] = json::object({{"version", "2.0"}, {"generator", "latticed"}});
    if (!units_.up_axis.empty()) document_["asset"]["extras"]["upAxis"] = units_.up_axis;
    if (units_.meters_per_unit > 0) {
      document_["asset"]["extras"]["metersPerUnit"] = units_.meters_per_unit;
    }
    document_["scene"] = 0;
    json scene = json::object();
    if (!primitives_.empty()) {
      scene["nodes"] = json::array({0});
      const json translation = json::array({center_.x, center_.y, center_.z});
      const json mesh_node = json::object({{"mesh", 0}, {"translation", translation}});
      if (units_.known()) {
        document_["nodes"] =
            json::array({json::object({{"children", json::array({1})}, {"matrix", ToGltf(units_)}}),
                         mesh_node});
      } else {
        document_["nodes"] = json::array({mesh_node});
      }
      document_["meshes"] = json::array({json::object({{"primitives", primitives_}})});
      document_["buffers"] = json::array({json::object({{"byteLength", binary_.size()}})});
    }
    document_["scenes"] = json::array({scene});
  }

  absl::StatusOr<std::string> Pack() {
    std::string text = document_.dump();
    text.resize(glb::Aligned(text.size()), ' ');
    binary_.resize(glb::Aligned(binary_.size()), '\0');
    std::string head;
    const size_t binary_chunk = binary_.empty() ? 0 : glb::kChunkHeaderBytes + binary_.size();
    const size_t total = glb::kHeaderBytes + glb::kChunkHeaderBytes + text.size() + binary_chunk;
    constexpr size_t kMostBytes = std::numeric_limits<uint32_t>::max();
    if (total > kMostBytes) return error::OutOfMemory("a GLB file", total, kMostBytes);
    for (uint64_t word : {uint64_t{glb::kMagic}, uint64_t{glb::kVersion}, uint64_t{total},
                          uint64_t{text.size()}, uint64_t{glb::kJsonChunk}}) {
      AppendLittleEndian(static_cast<uint32_t>(word), &head);
    }
    head += text;
    if (binary_.empty()) return head;
    AppendLittleEndian(static_cast<uint32_t>(binary_.size()), &head);
    AppendLittleEndian(glb::kBinaryChunk, &head);
    return std::move(binary_.insert(0, head));
  }

  const PolygonMesh& mesh_;
  const MeshUnits& units_;
  const VertexRecords vertices_;
  GlbMaterials materials_;
  std::vector<json> named_materials_;
  Vec3d center_;
  std::string binary_;
  json document_ = json::object();
  json attributes_ = json::object();
  json primitives_ = json::array();
};

}  // namespace

absl::StatusOr<std::string> WriteGlb(const PolygonMesh& mesh, const FileExtras& extras) {
  return GlbBuilder(mesh, extras).Build();
}

}  // namespace latticed
