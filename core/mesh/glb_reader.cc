// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <map>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/mesh/glb_document.h"
#include "core/mesh/glb_io.h"
#include "core/mesh/glb_layout.h"
#include "core/mesh/glb_transform.h"
#include "core/mesh/mesh_reading.h"
#include "fmt/format.h"

#include <tiny_gltf.h>

namespace latticed {
namespace {

absl::Status Malformed(std::string_view where, std::string_view problem) {
  return error::MalformedFile("GLB", where, problem);
}

// Index in the mesh of each element of an accessor, filled as elements are used.
using Slots = std::vector<uint32_t>;

// The accessors of one primitive under one node.
struct Vertices {
  GlbAccessor positions, normals, uvs;  // the last two with count 0 where there are none
  Slots *position_slots = nullptr, *normal_slots = nullptr, *uv_slots = nullptr;
};

class GlbReader {
 public:
  GlbReader(const GlbDocument& document, size_t file_bytes)
      : document_(document),
        model_(document.model()),
        budget_(kFreeBudget + kBudgetPerByte * file_bytes) {}

  absl::StatusOr<PolygonMesh> Read() {
    LATTICED_ASSIGN_OR_RETURN(std::vector<int> roots, Roots());
    LATTICED_RETURN_IF_ERROR(ReadNodes(roots));
    const auto fill = [this](std::vector<uint32_t>* list) {
      if (!list->empty()) list->resize(mesh_.corner_count(), PolygonMesh::kNoAttribute);
    };
    fill(&mesh_.corner_normals);
    fill(&mesh_.corner_uvs);
    return FinishMesh("GLB", std::move(mesh_));
  }

 private:
  // A small file can name one mesh in many nodes. Corners and vertices that it may grow to:
  static constexpr size_t kFreeBudget = size_t{1} << 22;
  static constexpr size_t kBudgetPerByte = 64;

  absl::StatusOr<std::vector<int>> Roots() const {
    if (!model_.scenes.empty()) {
      const int scene = model_.defaultScene < 0 ? 0 : model_.defaultScene;
      if (static_cast<size_t>(scene) >= model_.scenes.size()) {
        return Malformed("scene", fmt::format("there are {} scenes", model_.scenes.size()));
      }
      return model_.scenes[static_cast<size_t>(scene)].nodes;
    }
    std::vector<bool> is_child(model_.nodes.size());
    for (const tinygltf::Node& node : model_.nodes) {
      for (int child : node.children) {
        if (child >= 0 && static_cast<size_t>(child) < is_child.size()) {
          is_child[static_cast<size_t>(child)] = true;
        }
      }
    }
    std::vector<int> roots;
    for (size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) roots.push_back(static_cast<int>(i));
    }
    return roots;
  }

  // Depth first in file order, on a stack of its own: a chain of nodes may be as long as the file.
  absl::Status ReadNodes(const std::vector<int>& roots) {
    struct Pending {
      int node;
      GlbTransform parent;
    };
    std::vector<Pending> stack;
    std::vector<bool> seen(model_.nodes.size());
    for (size_t i = roots.size(); i-- > 0;) stack.push_back({roots[i], {}});
    while (!stack.empty()) {
      const auto [index, parent] = stack.back();
      stack.pop_back();
      const std::string where = fmt::format("nodes[{}]", index);
      if (index < 0 || static_cast<size_t>(index) >= seen.size()) {
        return Malformed(where, fmt::format("there are {} nodes", seen.size()));
      }
      if (seen[static_cast<size_t>(index)]) return Malformed(where, "it has two parents");
      seen[static_cast<size_t>(index)] = true;
      const tinygltf::Node& node = model_.nodes[static_cast<size_t>(index)];
      const GlbTransform transform =
          parent * GlbTransform::OfNode(node.matrix, node.translation, node.rotation, node.scale);
      LATTICED_RETURN_IF_ERROR(ReadNodeMesh(node.mesh, where, transform));
      for (size_t i = node.children.size(); i-- > 0;) {
        stack.push_back({node.children[i], transform});
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadNodeMesh(int index, std::string_view where, const GlbTransform& transform) {
    if (index == -1) return absl::OkStatus();
    if (index < 0 || static_cast<size_t>(index) >= model_.meshes.size()) {
      return Malformed(where, fmt::format("mesh {}; there are {}", index, model_.meshes.size()));
    }
    position_slots_.clear();
    normal_slots_.clear();
    uv_slots_.clear();
    const tinygltf::Mesh& mesh = model_.meshes[static_cast<size_t>(index)];
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      const int mode = primitive.mode == -1 ? glb::kTriangles : primitive.mode;
      if (mode < glb::kTriangles || mode > glb::kTriangleFan) continue;
      SetGroup(primitive.material, mesh.name, index);
      LATTICED_RETURN_IF_ERROR(ReadPrimitive(primitive, mode, transform));
    }
    return absl::OkStatus();
  }

  void SetGroup(int material, const std::string& mesh_name, int mesh) {
    std::string name = mesh_name.empty() ? fmt::format("mesh {}", mesh) : mesh_name;
    if (material >= 0 && static_cast<size_t>(material) < model_.materials.size()) {
      const std::string& own = model_.materials[static_cast<size_t>(material)].name;
      name = own.empty() ? fmt::format("material {}", material) : own;
    }
    const auto [it, added] =
        group_ids_.try_emplace(name, static_cast<uint32_t>(mesh_.group_names.size()));
    if (added) mesh_.group_names.push_back(name);
    group_ = it->second;
  }

  absl::Status Spend(size_t count) {
    if (count > budget_) {
      return Malformed("its nodes", "repeated meshes grow far beyond the size of the file");
    }
    budget_ -= count;
    return absl::OkStatus();
  }

  // An attribute of the primitive, if it has it; slots are shared by the primitives of one node.
  absl::Status OpenAttribute(const tinygltf::Primitive& primitive, const char* name, int components,
                             std::map<int, Slots>* slots_of, GlbAccessor* accessor, Slots** slots) {
    const auto it = primitive.attributes.find(name);
    if (it == primitive.attributes.end()) return absl::OkStatus();
    LATTICED_ASSIGN_OR_RETURN(GlbAccessor opened, document_.Open(it->second, components));
    *accessor = opened;
    *slots = &(*slots_of)[it->second];
    if ((*slots)->empty()) {
      LATTICED_RETURN_IF_ERROR(Spend(accessor->count));
      (*slots)->resize(accessor->count, PolygonMesh::kNoAttribute);
    }
    return absl::OkStatus();
  }

  absl::Status ReadPrimitive(const tinygltf::Primitive& primitive, int mode,
                             const GlbTransform& transform) {
    Vertices v;
    absl::Status status =
        OpenAttribute(primitive, "POSITION", 3, &position_slots_, &v.positions, &v.position_slots);
    if (!status.ok()) return status;
    if (v.positions.count == 0) return absl::OkStatus();  // glTF: such a primitive is not drawn
    status = OpenAttribute(primitive, "NORMAL", 3, &normal_slots_, &v.normals, &v.normal_slots);
    if (!status.ok()) return status;
    status = OpenAttribute(primitive, "TEXCOORD_0", 2, &uv_slots_, &v.uvs, &v.uv_slots);
    if (!status.ok()) return status;
    for (const GlbAccessor* attribute : {&v.normals, &v.uvs}) {
      if (attribute->count != 0 && attribute->count != v.positions.count) {
        return Malformed("a primitive", "its attributes have different counts");
      }
    }
    GlbAccessor indices;
    if (primitive.indices != -1) {
      LATTICED_ASSIGN_OR_RETURN(GlbAccessor opened, document_.OpenIndices(primitive.indices));
      indices = opened;
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
      LATTICED_RETURN_IF_ERROR(Spend(3));
      for (size_t corner : {a, b, c}) {
        if (corner >= v.positions.count) {
          return Malformed("a primitive", fmt::format("vertex index {} is out of range; it has {}",
                                                      corner, v.positions.count));
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

  void AddCorner(const Vertices& v, size_t vertex, const GlbTransform& transform) {
    uint32_t& position = (*v.position_slots)[vertex];
    if (position == PolygonMesh::kNoAttribute) {
      position = welder_.Add(transform.Point(ReadVector(v.positions, vertex)));
    }
    mesh_.corner_vertices.push_back(position);
    if (v.normals.count > 0) {
      uint32_t& normal = (*v.normal_slots)[vertex];
      if (normal == PolygonMesh::kNoAttribute) {
        normal = static_cast<uint32_t>(mesh_.normals.size());
        mesh_.normals.push_back(ToFloat(transform.Normal(ReadVector(v.normals, vertex))));
      }
      AddAttribute(normal, &mesh_.corner_normals);
    }
    if (v.uvs.count > 0) {
      uint32_t& uv = (*v.uv_slots)[vertex];
      if (uv == PolygonMesh::kNoAttribute) {
        uv = static_cast<uint32_t>(mesh_.uvs.size());
        mesh_.uvs.push_back({static_cast<float>(v.uvs.Component(vertex, 0)),
                             static_cast<float>(1 - v.uvs.Component(vertex, 1))});
      }
      AddAttribute(uv, &mesh_.corner_uvs);
    }
  }

  // Corners of primitives without the attribute, before this one, have none.
  void AddAttribute(uint32_t index, std::vector<uint32_t>* list) {
    list->resize(mesh_.corner_count() - 1, PolygonMesh::kNoAttribute);
    list->push_back(index);
  }

  const GlbDocument& document_;
  const tinygltf::Model& model_;
  size_t budget_;
  PolygonMesh mesh_;
  VertexWelder welder_{&mesh_.positions};
  std::map<int, Slots> position_slots_, normal_slots_, uv_slots_;  // by accessor, of one node
  std::map<std::string, uint32_t> group_ids_;
  uint32_t group_ = 0;
};

}  // namespace

absl::StatusOr<PolygonMesh> ReadGlb(std::string_view bytes) {
  LATTICED_ASSIGN_OR_RETURN(GlbDocument document, GlbDocument::Parse(bytes));
  return GlbReader(document, bytes.size()).Read();
}

}  // namespace latticed
