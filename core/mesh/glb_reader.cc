// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// Binary glTF 2.0 (GLB).
//
// Reads all triangle primitives (list, strip, fan) of the default scene, or of all roots where there is none: POSITION,
// NORMAL, TEXCOORD_0 and _WEIGHT, under the transforms of their nodes. A mirroring node reverses its triangles. Positions with
// the same bits and the same weight become one vertex, because glTF doubles vertices at every seam. A primitive's group is its
// material, else its mesh. Texture coordinates are flipped to have their origin at the lower left. Lines and points are skipped.
// External buffers, sparse accessors, compressed geometry and unknown required extensions are refused. Skins, morph
// targets and images are ignored.
//
// Errors   kInvalidArgument, reason MALFORMED_FILE, naming the byte or the glTF element
#include <cmath>
#include <map>
#include <utility>

#include "core/base/status_macros.h"
#include "core/mesh/glb_document.h"
#include "core/mesh/glb_layout.h"
#include "core/mesh/glb_transform.h"
#include "core/mesh/mesh_io.h"
#include "core/mesh/mesh_reading.h"
#include "core/mesh/reading_memory.h"
#include "fmt/format.h"

namespace latticed {
namespace {

using nlohmann::json;

// Index in the mesh of each element of an accessor, filled as elements are used.
using Slots = std::vector<uint32_t>;

// The accessors of one primitive under one node.
struct Vertices {
  GlbAccessor positions, normals, uvs,
      weights;  // all but the first with count 0 where there are none
  Slots *position_slots = nullptr, *normal_slots = nullptr, *uv_slots = nullptr;
};

class GlbReader {
 public:
  GlbReader(const GlbDocument& document, size_t file_bytes, ReadingMemory* memory)
      : document_(document),
        budget_(kFreeBudget + kBudgetPerByte * file_bytes),
        growth_(memory, &mesh_) {}

  absl::StatusOr<PolygonMesh> Read() {
    LATTICED_ASSIGN_OR_RETURN(const auto roots, Roots());
    LATTICED_RETURN_IF_ERROR(ReadNodes(roots));
    if (!mesh_.weights.empty()) mesh_.weights.resize(mesh_.positions.size(), 1.0f);
    return FinishMesh("GLB", std::move(mesh_));
  }

 private:
  // A small file can name one mesh in many nodes. These bound the corners and vertices that it may
  // grow to.
  static constexpr size_t kFreeBudget = size_t{1} << 22;
  static constexpr size_t kBudgetPerByte = 64;
  // More than a corner appends: position, normal, UV, three indices, and its part of a face.
  static constexpr uint64_t kMostCornerBytes = 72;

  const json& Array(const char* name) const { return GlbArray(document_.root(), name); }

  absl::StatusOr<std::vector<int64_t>> Roots() const {
    if (const json& scenes = Array("scenes"); !scenes.empty()) {
      const int64_t named = GlbIndex(document_.root(), "scene");
      const auto scene = static_cast<size_t>(named == kGlbNoIndex ? 0 : named);
      if (scene < scenes.size()) return GlbIndices(scenes[scene], "nodes");
      return MalformedGlb("scene", fmt::format("there are {} scenes", scenes.size()));
    }
    const json& nodes = Array("nodes");
    std::vector<bool> is_child(nodes.size());
    for (const json& node : nodes) {
      for (const int64_t child : GlbIndices(node, "children")) {
        if (static_cast<size_t>(child) < is_child.size())
          is_child[static_cast<size_t>(child)] = true;
      }
    }
    std::vector<int64_t> roots;
    for (size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) roots.push_back(static_cast<int64_t>(i));
    }
    return roots;
  }

  // Depth first in file order. The stack is explicit, because a chain of nodes may be as long as
  // the file.
  absl::Status ReadNodes(const std::vector<int64_t>& roots) {
    struct Pending {
      size_t node;
      GlbTransform parent;
    };
    const json& nodes = Array("nodes");
    std::vector<Pending> stack;
    std::vector<bool> seen(nodes.size());
    const auto push = [&](const std::vector<int64_t>& numbers,
                          const GlbTransform& parent) -> absl::Status {
      LATTICED_RETURN_IF_ERROR(growth_.Reserve(
          3 * sizeof(Pending) * (stack.size() + numbers.size()), document_.memory_bytes()));
      for (size_t i = numbers.size(); i-- > 0;) {
        const auto index = static_cast<size_t>(numbers[i]);
        if (index >= seen.size()) {
          return MalformedGlb(NodeName(numbers[i]), fmt::format("there are {} nodes", seen.size()));
        }
        if (seen[index]) return MalformedGlb(NodeName(numbers[i]), "it has two parents");
        seen[index] = true;
        stack.push_back({index, parent});
      }
      return absl::OkStatus();
    };
    LATTICED_RETURN_IF_ERROR(push(roots, {}));
    while (!stack.empty()) {
      const auto [index, parent] = stack.back();
      stack.pop_back();
      const json& node = nodes[index];
      const GlbTransform transform =
          parent * GlbTransform::OfNode(GlbNumbers(node, "matrix"), GlbNumbers(node, "translation"),
                                        GlbNumbers(node, "rotation"), GlbNumbers(node, "scale"));
      LATTICED_RETURN_IF_ERROR(ReadNodeMesh(GlbIndex(node, "mesh"), index, transform));
      LATTICED_RETURN_IF_ERROR(push(GlbIndices(node, "children"), transform));
    }
    return absl::OkStatus();
  }

  static std::string NodeName(int64_t node) { return fmt::format("nodes[{}]", node); }

  absl::Status ReadNodeMesh(int64_t index, size_t node, const GlbTransform& transform) {
    if (index == kGlbNoIndex) return absl::OkStatus();
    const json& meshes = Array("meshes");
    if (static_cast<size_t>(index) >= meshes.size()) {
      return MalformedGlb(NodeName(static_cast<int64_t>(node)),
                          fmt::format("mesh {}; there are {}", index, meshes.size()));
    }
    position_slots_.clear();
    normal_slots_.clear();
    uv_slots_.clear();
    slot_bytes_ = 0;
    const json& mesh = meshes[static_cast<size_t>(index)];
    for (const json& primitive : GlbArray(mesh, "primitives")) {
      const int64_t given = GlbIndex(primitive, "mode");
      const int64_t mode = given == kGlbNoIndex ? glb::kTriangles : given;
      if (mode < glb::kTriangles || mode > glb::kTriangleFan) continue;
      SetGroup(GlbIndex(primitive, "material"), GlbString(mesh, "name"), index);
      LATTICED_RETURN_IF_ERROR(ReadPrimitive(primitive, static_cast<int>(mode), transform));
    }
    return absl::OkStatus();
  }

  void SetGroup(int64_t material, const std::string& mesh_name, int64_t mesh) {
    std::string name = mesh_name.empty() ? fmt::format("mesh {}", mesh) : mesh_name;
    if (const json& materials = Array("materials");
        static_cast<size_t>(material) < materials.size()) {
      const std::string own = GlbString(materials[static_cast<size_t>(material)], "name");
      name = own.empty() ? fmt::format("material {}", material) : own;
    }
    const auto [it, added] =
        group_ids_.try_emplace(name, static_cast<uint32_t>(mesh_.group_names.size()));
    if (added) {
      mesh_.group_names.push_back(name);
      growth_.NoteName(2 * name.size() + sizeof(name));
    }
    group_ = it->second;
  }

  // `bytes` are what the mesh or the slots may grow by.
  absl::Status Spend(size_t count, uint64_t bytes) {
    if (count > budget_) {
      return MalformedGlb("its nodes", "repeated meshes grow far beyond the size of the file");
    }
    budget_ -= count;
    return growth_.Append(bytes, welder_.MemoryBytes() + slot_bytes_ + document_.memory_bytes());
  }

  // Opens an attribute of the primitive, if it has it. The primitives of one node share slots.
  absl::Status OpenAttribute(const json& attributes, const char* name, int components,
                             std::map<int64_t, Slots>* slots_of, GlbAccessor* accessor,
                             Slots** slots) {
    const int64_t index = GlbIndex(attributes, name);
    if (index == kGlbNoIndex) return absl::OkStatus();
    LATTICED_ASSIGN_OR_RETURN(*accessor, document_.Open(index, components));
    *slots = &(*slots_of)[index];
    if (!(*slots)->empty()) return absl::OkStatus();
    LATTICED_RETURN_IF_ERROR(Spend(accessor->count, accessor->count * sizeof(uint32_t)));
    slot_bytes_ += accessor->count * sizeof(uint32_t);
    (*slots)->resize(accessor->count, PolygonMesh::kNoAttribute);
    return absl::OkStatus();
  }

  absl::Status ReadPrimitive(const json& primitive, int mode, const GlbTransform& transform) {
    const json& attributes = GlbMember(primitive, "attributes");
    Vertices v;
    // A vertex of another weight is another vertex.
    const int64_t weights = GlbIndex(attributes, "_WEIGHT");
    LATTICED_RETURN_IF_ERROR(OpenAttribute(attributes, "POSITION", 3, &position_slots_[weights],
                                           &v.positions, &v.position_slots));
    if (v.positions.count == 0) return absl::OkStatus();  // glTF: such a primitive is not drawn
    LATTICED_RETURN_IF_ERROR(
        OpenAttribute(attributes, "NORMAL", 3, &normal_slots_, &v.normals, &v.normal_slots));
    LATTICED_RETURN_IF_ERROR(
        OpenAttribute(attributes, "TEXCOORD_0", 2, &uv_slots_, &v.uvs, &v.uv_slots));
    if (weights != kGlbNoIndex) {
      LATTICED_ASSIGN_OR_RETURN(v.weights, document_.Open(weights, 1));
      LATTICED_RETURN_IF_ERROR(growth_.Append(v.weights.count * sizeof(float)));
    }
    for (const GlbAccessor* attribute : {&v.normals, &v.uvs, &v.weights}) {
      if (attribute->count != 0 && attribute->count != v.positions.count) {
        return MalformedGlb("a primitive", "its attributes have different counts");
      }
    }
    GlbAccessor indices;
    if (const int64_t index = GlbIndex(primitive, "indices"); index != kGlbNoIndex) {
      LATTICED_ASSIGN_OR_RETURN(indices, document_.OpenIndices(index));
    }
    return ReadTriangles(v, indices, mode, transform);
  }

  absl::Status ReadTriangles(const Vertices& v, const GlbAccessor& indices, int mode,
                             const GlbTransform& transform) {
    const size_t count = indices.count == 0 ? v.positions.count : indices.count;
    const auto vertex = [&](size_t i) { return indices.count == 0 ? i : indices.Index(i); };
    const size_t step = mode == glb::kTriangles ? 3 : 1;
    for (size_t i = 0; i + 2 < count; i += step) {
      const bool turned = mode == glb::kTriangleStrip && (i & 1) != 0;
      size_t a = vertex(mode == glb::kTriangleFan ? 0 : i + (turned ? 1 : 0));
      size_t b = vertex(i + (turned ? 0 : 1)), c = vertex(i + 2);
      if (mode != glb::kTriangles && (a == b || b == c || c == a)) continue;  // joins two strips
      if (transform.Mirrors()) std::swap(b, c);
      LATTICED_RETURN_IF_ERROR(Spend(3, 3 * kMostCornerBytes));
      for (size_t corner : {a, b, c}) {
        if (corner >= v.positions.count) {
          return MalformedGlb(
              "a primitive",
              fmt::format("vertex index {} is out of range; it has {}", corner, v.positions.count));
        }
        AddCorner(v, corner, transform);
      }
      mesh_.face_offsets.push_back(static_cast<uint32_t>(mesh_.corner_count()));
      mesh_.face_groups.push_back(group_);
    }
    return absl::OkStatus();
  }

  static Vec3d ReadVector(const GlbAccessor& accessor, size_t i) {
    return {accessor.Component(i, 0), accessor.Component(i, 1), accessor.Component(i, 2)};
  }

  uint32_t AddPosition(Vec3d point, const Vertices& v, size_t vertex) {
    if (v.weights.count == 0) return welder_.Add(point);
    const auto weight = static_cast<float>(v.weights.Component(vertex, 0));
    const uint32_t position = welder_.Add(point, weight);
    mesh_.weights.resize(mesh_.positions.size(), 1.0f);
    mesh_.weights[position] = weight;
    return position;
  }

  void AddCorner(const Vertices& v, size_t vertex, const GlbTransform& transform) {
    uint32_t& position = (*v.position_slots)[vertex];
    if (position == PolygonMesh::kNoAttribute) {
      position = AddPosition(transform.Point(ReadVector(v.positions, vertex)), v, vertex);
    }
    mesh_.corner_vertices.push_back(position);
    if (v.normals.count > 0) {
      uint32_t& normal = (*v.normal_slots)[vertex];
      if (normal == PolygonMesh::kNoAttribute) {
        normal = static_cast<uint32_t>(mesh_.normals.size());
        mesh_.normals.push_back(ToFloat(transform.Normal(ReadVector(v.normals, vertex))));
      }
      AddCornerAttribute(mesh_, normal, &mesh_.corner_normals);
    }
    if (v.uvs.count > 0) {
      uint32_t& uv = (*v.uv_slots)[vertex];
      if (uv == PolygonMesh::kNoAttribute) {
        uv = static_cast<uint32_t>(mesh_.uvs.size());
        mesh_.uvs.push_back({static_cast<float>(v.uvs.Component(vertex, 0)),
                             static_cast<float>(1 - v.uvs.Component(vertex, 1))});
      }
      AddCornerAttribute(mesh_, uv, &mesh_.corner_uvs);
    }
  }

  const GlbDocument& document_;
  size_t budget_;
  PolygonMesh mesh_;
  VertexWelder welder_{&mesh_.positions};
  MeshGrowth growth_;
  std::map<int64_t, Slots> normal_slots_, uv_slots_;            // by accessor, of one node
  std::map<int64_t, std::map<int64_t, Slots>> position_slots_;  // the same, by accessor of weights
  uint64_t slot_bytes_ = 0;
  std::map<std::string, uint32_t> group_ids_;
  uint32_t group_ = 0;
};

}  // namespace

absl::StatusOr<PolygonMesh> ReadGlb(std::string_view bytes, ReadingMemory* memory) {
  LATTICED_ASSIGN_OR_RETURN(GlbDocument document, GlbDocument::Parse(bytes, memory));
  return GlbReader(document, bytes.size(), memory).Read();
}

}  // namespace latticed
