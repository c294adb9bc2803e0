// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0

#include "core/mesh/sample_meshes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "fmt/ranges.h"

namespace latticed {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

constexpr std::array<std::string_view, 6> kNames = {"vase",  "knot", "gear",
                                                    "shell", "slab", "beam"};

void AddFace(std::initializer_list<size_t> vertices, PolygonMesh* mesh) {
  for (size_t v : vertices) mesh->corner_vertices.push_back(static_cast<uint32_t>(v));
  mesh->face_offsets.push_back(static_cast<uint32_t>(mesh->corner_count()));
}

void AddCornerUvs(std::initializer_list<size_t> uvs, PolygonMesh* mesh) {
  for (size_t uv : uvs) mesh->corner_uvs.push_back(static_cast<uint32_t>(uv));
}

Vec2f GridUv(int i, int columns, int j, int rows) {
  return {static_cast<float>(i) / static_cast<float>(columns),
          static_cast<float>(j) / static_cast<float>(rows)};
}

// Outer half of the vase's profile: radius at height t in 0 … 1.
double VaseRadius(double t) {
  return 0.42 + 0.26 * std::sin(kTurn * (0.78 * t + 0.02)) + 0.10 * t * t;
}

// Point of ring j of the closed profile, up the outside and down the inside, at angle fraction s.
Vec3d VasePoint(double s, int ring, int rings_up) {
  constexpr double kWall = 0.05, kFloor = 0.06, kHeight = 2.0;
  const bool outside = ring <= rings_up;
  const double t = outside ? static_cast<double>(ring) / rings_up
                           : static_cast<double>(2 * rings_up + 1 - ring) / rings_up;
  const double flutes = 1 + 0.035 * std::sin(kTurn * t / 2) * std::cos(12 * kTurn * (s + 0.15 * t));
  const double radius = VaseRadius(t) * flutes - (outside ? 0 : kWall);
  const double z = kHeight * (outside ? t : kFloor + (1 - kFloor) * t) - kHeight / 2;
  return {radius * std::cos(kTurn * s), radius * std::sin(kTurn * s), z};
}

PolygonMesh MakeVase(int resolution) {
  const int around = 24 * resolution, rings_up = 12 * resolution;
  const int rings = 2 * rings_up + 2;
  PolygonMesh mesh;
  const auto vertex = [&](int i, int j) { return static_cast<size_t>(j * around + i % around); };
  const auto uv = [&](int i, int j) { return static_cast<size_t>(j * (around + 1) + i); };
  for (int j = 0; j < rings; ++j) {
    for (int i = 0; i <= around; ++i) {
      if (i < around) mesh.positions.push_back(VasePoint(1.0 * i / around, j, rings_up));
      mesh.uvs.push_back(GridUv(i, around, j, rings - 1));
    }
  }
  for (int j = 0; j + 1 < rings; ++j) {
    for (int i = 0; i < around; ++i) {
      AddFace({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)}, &mesh);
      AddCornerUvs({uv(i, j), uv(i + 1, j), uv(i + 1, j + 1), uv(i, j + 1)}, &mesh);
    }
  }
  for (const bool bottom : {true, false}) {  // the bottom seen from below, the floor from above
    const int ring = bottom ? 0 : rings - 1;
    for (int n = 0; n < around; ++n) {
      const int i = bottom ? around - 1 - n : n;
      mesh.corner_vertices.push_back(static_cast<uint32_t>(vertex(i, ring)));
      mesh.corner_uvs.push_back(static_cast<uint32_t>(mesh.uvs.size()));
      const double angle = kTurn * i / around;
      mesh.uvs.push_back({static_cast<float>(0.5 + 0.5 * std::cos(angle)),
                          static_cast<float>(0.5 + 0.5 * std::sin(angle))});
    }
    mesh.face_offsets.push_back(static_cast<uint32_t>(mesh.corner_count()));
  }
  return mesh;
}

// A point of the (2, 3) torus knot and a frame across it. The frame's normal is the torus's normal, made perpendicular
// to the tangent; such a frame closes without a twist.
struct KnotFrame {
  Vec3d center, normal, binormal;
};

KnotFrame KnotAt(double s) {
  constexpr double kMajor = 0.68, kMinor = 0.30;
  const double phi = 2 * kTurn * s, theta = 3 * kTurn * s;
  const Vec3d radial{std::cos(phi), std::sin(phi), 0}, along{-std::sin(phi), std::cos(phi), 0};
  const Vec3d outward = std::cos(theta) * radial + Vec3d{0, 0, std::sin(theta)};
  const Vec3d tangent = 2 * (kMajor + kMinor * std::cos(theta)) * along +
                        3 * kMinor * (-std::sin(theta) * radial + Vec3d{0, 0, std::cos(theta)});
  const Vec3d binormal = Cross(outward, tangent);
  return {kMajor * radial + kMinor * outward, outward, binormal / Norm(binormal)};
}

PolygonMesh MakeKnot(int resolution) {
  constexpr double kTube = 0.16;
  const int along = 60 * resolution, around = 6 * resolution;
  PolygonMesh mesh;
  const auto vertex = [&](int i, int j) {
    return static_cast<size_t>(i % along * around + j % around);
  };
  const auto uv = [&](int i, int j) { return static_cast<size_t>(i * (around + 1) + j); };
  for (int i = 0; i <= along; ++i) {
    const KnotFrame frame = KnotAt(static_cast<double>(i % along) / along);
    for (int j = 0; j <= around; ++j) {
      mesh.uvs.push_back(GridUv(i, along, j, around));
      if (i == along || j == around) continue;
      const double angle = kTurn * j / around;
      const Vec3d normal = std::cos(angle) * frame.normal + std::sin(angle) * frame.binormal;
      mesh.positions.push_back(frame.center + kTube * normal);
      mesh.normals.push_back(ToFloat(normal));
    }
  }
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < around; ++j) {
      AddFace({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)}, &mesh);
      AddCornerUvs({uv(i, j), uv(i + 1, j), uv(i + 1, j + 1), uv(i, j + 1)}, &mesh);
    }
  }
  mesh.corner_normals = mesh.corner_vertices;
  return mesh;
}

constexpr int kTeeth = 24;
constexpr int kCapSectors = 6;  // concave n-gons of each cap

// Radius of the gear's outline at a fraction 0 … 1 of one tooth's pitch: root, flank, tip, flank.
double GearRadius(double pitch) {
  constexpr double kRoot = 0.82, kTip = 1.0, kFlank = 0.12, kHalfGap = 0.22;
  const double from_gap = std::min(pitch, 1 - pitch) - kHalfGap;
  return kRoot + (kTip - kRoot) * std::min(1.0, std::max(0.0, from_gap / kFlank));
}

// Vertex rings of the gear: outline and bore, below and above, with as many vertices each.
class GearBuilder {
 public:
  explicit GearBuilder(int resolution)
      : around_(kTeeth * 12 * resolution), layers_(2 * resolution) {}

  PolygonMesh Build() {
    mesh_.group_names = {"caps", "teeth", "bore"};
    for (int layer = 0; layer <= layers_; ++layer) AddRings(layer);
    for (const bool top : {false, true}) {
      for (int sector = 0; sector < kCapSectors; ++sector) AddCapSector(sector, top);
    }
    for (int layer = 0; layer < layers_; ++layer) {
      for (int i = 0; i < around_; ++i) {
        AddFace({Outline(i, layer), Outline(i + 1, layer), Outline(i + 1, layer + 1),
                 Outline(i, layer + 1)},
                &mesh_);
        mesh_.face_groups.push_back(1);
        AddFace({Bore(i + 1, layer), Bore(i, layer), Bore(i, layer + 1), Bore(i + 1, layer + 1)},
                &mesh_);
        mesh_.face_groups.push_back(2);
      }
    }
    return std::move(mesh_);
  }

 private:
  size_t Outline(int i, int layer) const {
    return static_cast<size_t>(2 * layer * around_ + i % around_);
  }
  size_t Bore(int i, int layer) const {
    return static_cast<size_t>((2 * layer + 1) * around_ + i % around_);
  }

  void AddRings(int layer) {
    constexpr double kBore = 0.30, kThickness = 0.36;
    const double z = kThickness * (static_cast<double>(layer) / layers_ - 0.5);
    for (const bool bore : {false, true}) {
      for (int i = 0; i < around_; ++i) {
        const double turn = static_cast<double>(i) / around_;
        const double radius = bore ? kBore : GearRadius(turn * kTeeth - std::floor(turn * kTeeth));
        mesh_.positions.push_back(
            {radius * std::cos(kTurn * turn), radius * std::sin(kTurn * turn), z});
      }
    }
  }

  void AddCapSector(int sector, bool top) {
    const int layer = top ? layers_ : 0;
    const int steps = around_ / kCapSectors, first = sector * steps;
    std::vector<size_t> loop;
    for (int i = 0; i <= steps; ++i) loop.push_back(Outline(first + i, layer));
    for (int i = steps; i >= 0; --i) loop.push_back(Bore(first + i, layer));
    if (!top) std::reverse(loop.begin(), loop.end());
    for (size_t v : loop) mesh_.corner_vertices.push_back(static_cast<uint32_t>(v));
    mesh_.face_offsets.push_back(static_cast<uint32_t>(mesh_.corner_count()));
    mesh_.face_groups.push_back(0);
  }

  const int around_, layers_;
  PolygonMesh mesh_;
};

// A conical log spiral: everything grows by kGrowth a turn, so that each whorl rests on the one
// before.
Vec3d ShellPoint(double turns, double s) {
  constexpr double kGrowth = 1.9, kTurns = 4.0, kTube = 0.46, kPitch = 0.85;
  const double size = 0.62 * std::pow(kGrowth, turns - kTurns);
  const double ribs = 1 + 0.04 * std::cos(14 * kTurn * turns) * (0.5 + 0.5 * std::cos(kTurn * s));
  const double tube = kTube * size * ribs;
  const double out = size + tube * std::cos(kTurn * s);
  return {out * std::cos(kTurn * turns), out * std::sin(kTurn * turns),
          0.75 - 2 * kPitch * size + 1.25 * tube * std::sin(kTurn * s)};
}

PolygonMesh MakeShell(int resolution) {
  constexpr double kTurns = 4.0;
  const int along = 45 * resolution, around = 6 * resolution;
  PolygonMesh mesh;
  const auto vertex = [&](int i, int j) { return static_cast<size_t>(i * around + j % around); };
  for (int i = 0; i <= along; ++i) {
    for (int j = 0; j < around; ++j) {
      mesh.positions.push_back(ShellPoint(kTurns * i / along, static_cast<double>(j) / around));
    }
  }
  const size_t apex = mesh.positions.size();
  Vec3d center;
  for (int j = 0; j < around; ++j) center += mesh.positions[vertex(0, j)] / around;
  mesh.positions.push_back(center);
  for (int j = 0; j < around; ++j) AddFace({apex, vertex(0, j), vertex(0, j + 1)}, &mesh);
  for (int i = 0; i < along; ++i) {
    for (int j = 0; j < around; ++j) {
      AddFace({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)}, &mesh);
      AddFace({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)}, &mesh);
    }
  }
  return mesh;
}

PolygonMesh MakeSlab(int resolution) {
  const int quads = 10 * resolution;
  PolygonMesh mesh;
  const auto vertex = [&](int i, int j) { return static_cast<size_t>(i * (quads + 1) + j); };
  for (int i = 0; i <= quads; ++i) {
    for (int j = 0; j <= quads; ++j) {
      const double s = static_cast<double>(i) / quads, t = static_cast<double>(j) / quads;
      const double height = 0.06 * std::cos(2 * kTurn * s) * std::cos(2 * kTurn * t);
      mesh.positions.push_back({2 * s - 1, 2 * t - 1, height});
      mesh.uvs.push_back(GridUv(i, quads, j, quads));
    }
  }
  for (int i = 0; i < quads; ++i) {
    for (int j = 0; j < quads; ++j) {
      AddFace({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)}, &mesh);
    }
  }
  mesh.corner_uvs = mesh.corner_vertices;
  return mesh;
}

PolygonMesh MakeBeam() {
  constexpr int kQuads = 4, kSides = 4;
  constexpr double kHalfLength = 1, kHalfWidth = 0.125;
  constexpr std::array<std::array<double, 2>, kSides> kRing{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  PolygonMesh mesh;
  const auto vertex = [](int i, int j) { return static_cast<size_t>(kSides * i + j % kSides); };
  const auto uv = [](int i, int j) { return static_cast<size_t>((kSides + 1) * i + j); };
  for (int i = 0; i <= kQuads; ++i) {
    const double x = kHalfLength * (2.0 * i / kQuads - 1);
    for (const auto& [y, z] : kRing) mesh.positions.push_back({x, kHalfWidth * y, kHalfWidth * z});
    for (int j = 0; j <= kSides; ++j) mesh.uvs.push_back(GridUv(i, kQuads, j, kSides));
  }
  for (int i = 0; i < kQuads; ++i) {
    for (int j = 0; j < kSides; ++j) {
      AddFace({vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)}, &mesh);
      AddCornerUvs({uv(i, j), uv(i, j + 1), uv(i + 1, j + 1), uv(i + 1, j)}, &mesh);
    }
  }
  AddFace({vertex(0, 3), vertex(0, 2), vertex(0, 1), vertex(0, 0)}, &mesh);
  AddFace({vertex(kQuads, 0), vertex(kQuads, 1), vertex(kQuads, 2), vertex(kQuads, 3)}, &mesh);
  AddCornerUvs({uv(0, 1), uv(1, 1), uv(1, 0), uv(0, 0)}, &mesh);
  AddCornerUvs({uv(0, 0), uv(1, 0), uv(1, 1), uv(0, 1)}, &mesh);
  return mesh;
}

}  // namespace

std::span<const std::string_view> SampleMeshNames() { return kNames; }

absl::StatusOr<PolygonMesh> MakeSampleMesh(std::string_view name, int resolution) {
  LATTICED_RETURN_IF_ERROR(
      error::CheckRange("resolution", resolution, kMinSampleResolution, kMaxSampleResolution));
  if (name == "vase") return MakeVase(resolution);
  if (name == "knot") return MakeKnot(resolution);
  if (name == "gear") return GearBuilder(resolution).Build();
  if (name == "shell") return MakeShell(resolution);
  if (name == "slab") return MakeSlab(resolution);
  if (name == "beam") return MakeBeam();
  return error::InvalidField("sample", fmt::format("no sample is called '{}'; there are {}", name,
                                                   fmt::join(kNames, ", ")));
}

}  // namespace latticed
