// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// OpenUSD as text (usda): one Mesh, and for each group a GeomSubset with a material of its name.
//
//   /latticed             Xform; it turns a mesh with +x up to +y, because USD has no other up axes than y and z
//   /latticed/mesh        Mesh: points about the centre of the bounds, which is its translation
//   /latticed/materials   a grey UsdPreviewSurface for each group
//
// Normals and texture coordinates are primvars of corners (faceVarying) with indices.
// Source   https://openusd.org/release/spec_usdpreviewsurface.html, and UsdGeomMesh of the API's documentation
#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "absl/strings/ascii.h"
#include "core/base/bounds.h"
#include "core/mesh/write/write_mesh.h"
#include "core/mesh/write/writing_memory.h"
#include "fmt/format.h"

namespace latticed {
namespace {

// Names of USD's prims are identifiers: letters, digits and '_'. Each group gets another one.
std::vector<std::string> PrimNames(const std::vector<std::string>& groups) {
  std::vector<std::string> names;
  std::set<std::string, std::less<>> taken;
  for (size_t g = 0; g < groups.size(); ++g) {
    std::string name = groups[g];
    for (char& c : name) {
      if (!absl::ascii_isalnum(static_cast<unsigned char>(c))) c = '_';
    }
    if (name.empty() || absl::ascii_isdigit(static_cast<unsigned char>(name[0]))) name = "_" + name;
    while (!taken.insert(name).second) name += fmt::format("_{}", g);
    names.push_back(name);
  }
  return names;
}

class UsdWriter {
 public:
  UsdWriter(const PolygonMesh& mesh, const MeshUnits& units)
      : mesh_(mesh), units_(units), names_(PrimNames(mesh.group_names)) {
    Bounds bounds;
    for (const Vec3d p : mesh.positions) bounds.Extend(p);
    if (!bounds.empty()) center_ = bounds.center();
  }

  std::string Write() {
    out_.reserve(MostUsdBytes(WrittenSizesOf(mesh_)));  // pages that are not written take no memory
    AddHeader();
    Add("def Xform \"latticed\"\n{{\n");
    if (units_.up_axis == "x") {
      Add("    matrix4d xformOp:transform = "
          "((0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))\n"
          "    uniform token[] xformOpOrder = [\"xformOp:transform\"]\n\n");
    }
    AddMesh();
    if (!mesh_.face_groups.empty()) AddMaterials();
    Add("}}\n");
    return std::move(out_);
  }

 private:
  template <typename... Args>
  void Add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Args>(args)...);
  }

  // `add` appends one element.
  template <typename Values, typename AddOne>
  void AddList(const Values& values, const AddOne& add) {
    out_.push_back('[');
    bool first = true;
    for (const auto& value : values) {
      if (!first) out_ += ", ";
      first = false;
      add(value);
    }
    out_.push_back(']');
  }
  void AddIndices(const std::vector<uint32_t>& indices) {
    AddList(indices, [this](uint32_t i) { Add("{}", i); });
  }

  void AddHeader() {
    Add("#usda 1.0\n(\n    defaultPrim = \"latticed\"\n");
    if (units_.meters_per_unit > 0) Add("    metersPerUnit = {}\n", units_.meters_per_unit);
    if (!units_.up_axis.empty()) Add("    upAxis = \"{}\"\n", units_.up_axis == "z" ? "Z" : "Y");
    Add(")\n\n");
  }

  void AddMesh() {
    Add("    def Mesh \"mesh\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )\n   "
        " {{\n");
    Add("        uniform token subdivisionScheme = \"none\"\n");
    Add("        double3 xformOp:translate = ({}, {}, {})\n", center_.x, center_.y, center_.z);
    Add("        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n");
    AddFaces();
    AddPoints();
    AddPrimvar("normal3f[] primvars:normals", mesh_.normals, mesh_.corner_normals,
               [this](Vec3f n) { Add("({}, {}, {})", n.x, n.y, n.z); });
    AddPrimvar("texCoord2f[] primvars:st", mesh_.uvs, mesh_.corner_uvs,
               [this](Vec2f uv) { Add("({}, {})", uv.x, uv.y); });
    if (!mesh_.face_groups.empty()) AddSubsets();
    Add("    }}\n");
  }

  void AddFaces() {
    std::vector<uint32_t> counts;
    counts.reserve(mesh_.face_count());
    for (size_t f = 0; f < mesh_.face_count(); ++f) {
      counts.push_back(mesh_.face_offsets[f + 1] - mesh_.face_offsets[f]);
    }
    Add("        int[] faceVertexCounts = ");
    AddIndices(counts);
    Add("\n        int[] faceVertexIndices = ");
    AddIndices(mesh_.corner_vertices);
    out_.push_back('\n');
  }

  void AddPoints() {
    Bounds local;  // of the floats as written
    Add("        point3f[] points = ");
    AddList(mesh_.positions, [&](Vec3d p) {
      const Vec3f q = ToFloat(p - center_);
      local.Extend(ToDouble(q));
      Add("({}, {}, {})", q.x, q.y, q.z);
    });
    const Vec3f min = ToFloat(local.min), max = ToFloat(local.max);
    Add("\n        float3[] extent = [({}, {}, {}), ({}, {}, {})]\n", min.x, min.y, min.z, max.x,
        max.y, max.z);
  }

  // A corner without the attribute gets one more value, of zeros.
  template <typename T, typename AddOne>
  void AddPrimvar(std::string_view name, std::vector<T> values, std::vector<uint32_t> indices,
                  const AddOne& add) {
    if (values.empty()) return;
    const auto none = static_cast<uint32_t>(values.size());
    if (std::ranges::count(indices, PolygonMesh::kNoAttribute) > 0) values.push_back({});
    std::ranges::replace(indices, PolygonMesh::kNoAttribute, none);
    Add("        {} = ", name);
    AddList(values, add);
    Add(" (\n            interpolation = \"faceVarying\"\n        )\n        int[] {}:indices = ",
        name.substr(name.find(' ') + 1));
    AddIndices(indices);
    out_.push_back('\n');
  }

  void AddSubsets() {
    std::vector<std::vector<uint32_t>> faces(names_.size());
    for (size_t f = 0; f < mesh_.face_count(); ++f) {
      faces[mesh_.face_groups[f]].push_back(static_cast<uint32_t>(f));
    }
    Add("        uniform token subsetFamily:materialBind:familyType = \"nonOverlapping\"\n");
    for (size_t g = 0; g < names_.size(); ++g) {
      if (faces[g].empty()) continue;
      Add("\n        def GeomSubset \"{}\" (\n            prepend apiSchemas = "
          "[\"MaterialBindingAPI\"]\n"
          "        )\n        {{\n            uniform token elementType = \"face\"\n"
          "            uniform token familyName = \"materialBind\"\n            int[] indices = ",
          names_[g]);
      AddIndices(faces[g]);
      Add("\n            rel material:binding = </latticed/materials/{}>\n        }}\n", names_[g]);
    }
  }

  void AddMaterials() {
    Add("\n    def Scope \"materials\"\n    {{\n");
    for (const std::string& name : names_) {
      Add("        def Material \"{0}\"\n        {{\n"
          "            token outputs:surface.connect = "
          "</latticed/materials/{0}/surface.outputs:surface>\n\n"
          "            def Shader \"surface\"\n            {{\n"
          "                uniform token info:id = \"UsdPreviewSurface\"\n"
          "                color3f inputs:diffuseColor = (0.8, 0.8, 0.8)\n"
          "                token outputs:surface\n            }}\n        }}\n",
          name);
    }
    Add("    }}\n");
  }

  const PolygonMesh& mesh_;
  const MeshUnits& units_;
  const std::vector<std::string> names_;
  Vec3d center_;
  std::string out_;
};

}  // namespace

std::string WriteUsd(const PolygonMesh& mesh, const FileExtras& extras) {
  return UsdWriter(mesh, extras.units).Write();
}

}  // namespace latticed
