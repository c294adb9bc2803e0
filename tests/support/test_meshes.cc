// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/test_meshes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace latticed::testing {
namespace {

void AddFace(PolygonMesh& mesh, std::initializer_list<int> corners) {
  for (int c : corners) mesh.corner_vertices.push_back(static_cast<uint32_t>(c));
  mesh.face_offsets.push_back(static_cast<uint32_t>(mesh.corner_vertices.size()));
}

// Adds a grid of n x n quads with (n+1) x (n+1) new points, from `at` along a and b. It welds no points.
void AddGrid(PolygonMesh& mesh, int n, Vec3d at, Vec3d a, Vec3d b) {
  const auto base = static_cast<int>(mesh.positions.size());
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      mesh.positions.push_back(at + (static_cast<double>(i) / n) * a +
                               (static_cast<double>(j) / n) * b);
    }
  }
  const auto id = [&](int i, int j) { return base + i + (n + 1) * j; };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      AddFace(mesh, {id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
}

}  // namespace

PolygonMesh TorusMesh(int rings, int sides, Vec3d centre) {
  constexpr double kBig = 1.0, kSmall = 0.4;
  PolygonMesh mesh;
  for (int i = 0; i < rings; ++i) {
    const double a = 2 * std::numbers::pi * i / rings;
    for (int j = 0; j < sides; ++j) {
      const double b = 2 * std::numbers::pi * j / sides;
      const Vec3d out{std::cos(a) * std::cos(b), std::sin(a) * std::cos(b), std::sin(b)};
      mesh.positions.push_back(centre + kBig * Vec3d{std::cos(a), std::sin(a), 0} + kSmall * out);
      mesh.normals.push_back(ToFloat(out));
    }
  }
  const auto id = [&](int i, int j) { return (i % rings) * sides + j % sides; };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < sides; ++j) {
      AddFace(mesh, {id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  mesh.corner_normals = mesh.corner_vertices;
  return mesh;
}

PolygonMesh FlatGrid(int n, double z) {
  PolygonMesh mesh;
  AddGrid(mesh, n, {0, 0, z}, {1, 0, 0}, {0, 1, 0});
  return mesh;
}

PolygonMesh CubeMesh(int n) {
  PolygonMesh mesh;
  const Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  AddGrid(mesh, n, {}, y, x);
  AddGrid(mesh, n, z, x, y);
  AddGrid(mesh, n, {}, x, z);
  AddGrid(mesh, n, y, z, x);
  AddGrid(mesh, n, {}, z, y);
  AddGrid(mesh, n, x, y, z);
  return mesh;
}

PolygonMesh OneTriangle() {
  PolygonMesh mesh;
  mesh.positions = {{0.1, 0.2, 0.3}, {0.9, 0.1, 0.4}, {0.3, 0.8, 0.7}};
  AddFace(mesh, {0, 1, 2});
  return mesh;
}

std::vector<Vec3d> FacePositions(const PolygonMesh& mesh, size_t face) {
  std::vector<Vec3d> positions;
  for (uint32_t c = mesh.face_offsets[face]; c < mesh.face_offsets[face + 1]; ++c) {
    positions.push_back(mesh.positions[mesh.corner_vertices[c]]);
  }
  return positions;
}

PolygonMesh TriangleSoup(int count, uint32_t seed) {
  constexpr double kSliverHeight = 1e-5;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto point = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
  PolygonMesh mesh;
  for (int t = 0; t < count; ++t) {
    const Vec3d a = 0.8 * point(), b = a + 0.2 * point();
    const Vec3d side = 0.2 * point();
    const Vec3d c = t % 4 == 3 ? a + 0.4 * (b - a) + kSliverHeight * side : a + side;
    for (const Vec3d& p : {a, b, c}) mesh.positions.push_back(p);
    AddFace(mesh, {3 * t, 3 * t + 1, 3 * t + 2});
  }
  return mesh;
}

std::string PlyStrip(uint32_t indices) {
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement tristrips 1\nproperty list uint uchar "
      "vertex_indices\nend_header\n";
  const float xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  ply.append(reinterpret_cast<const char*>(xyz), sizeof(xyz));
  ply.append(reinterpret_cast<const char*>(&indices), sizeof(indices));
  for (uint32_t i = 0; i < indices; ++i) ply += static_cast<char>(i % 3);
  return ply;
}

std::vector<double> MakeKnots(KnotKind kind, int degree, int size) {
  std::vector<double> knots = ClampedUniformKnots(degree, size);
  const auto d = static_cast<size_t>(degree), n = static_cast<size_t>(size);
  switch (kind) {
    case KnotKind::kUniform:
      break;
    case KnotKind::kNonUniform:
      for (double& k : knots) k = 0.3 * k * k + 0.1 * k - 2;
      break;
    case KnotKind::kUnclamped:
      for (size_t i = 0; i < knots.size(); ++i) knots[i] = 1.5 * static_cast<double>(i);
      break;
    case KnotKind::kRepeated:
      // The first interior knots coincide: `degree` of them, if there are so many.
      for (size_t i = d + 1; i < std::min(n, 2 * d + 1); ++i) knots[i] = knots[d + 1];
      break;
  }
  return knots;
}

LatticeStructure MakeStructure(const Bounds& bounds, const LatticeOptions& options) {
  LatticeStructure s;
  const Vec3d extent = bounds.extent();
  const double longest = std::max({extent.x, extent.y, extent.z});
  const double edge = options.scale * longest;
  std::array<Vec3d, 3> edges{Vec3d{edge, 0, options.shear * edge},
                             Vec3d{options.shear * edge, edge, 0},
                             Vec3d{0, options.shear * edge, edge}};
  if (options.mirrored) std::swap(edges[0], edges[1]);
  for (Vec3d& e : edges) {
    // Rodrigues' formula.
    const Vec3d axis = Vec3d{1, 2, 2} / 3.0;
    const double cosine = std::cos(options.turn), sine = std::sin(options.turn);
    e = cosine * e + sine * Cross(axis, e) + (1 - cosine) * Dot(axis, e) * axis;
  }
  const Vec3d centre = bounds.center() + longest * options.shift;
  s.frame = {centre - 0.5 * (edges[0] + edges[1] + edges[2]), edges};
  s.degree = options.degree;
  for (size_t a = 0; a < 3; ++a) {
    s.size[a] = s.degree[a] + 1 + options.extra[a];
    s.knots[a] = MakeKnots(options.knots, s.degree[a], s.size[a]);
  }
  return s;
}

RandomCase DrawCase(uint32_t seed) {
  std::mt19937 random(seed);
  const auto draw = [&](int lowest, int highest) {
    return std::uniform_int_distribution<int>(lowest, highest)(random);
  };
  const auto real = [&](double lowest, double highest) {
    return std::uniform_real_distribution<double>(lowest, highest)(random);
  };
  RandomCase result;
  switch (draw(0, 3)) {
    case 0:
      result.mesh = TorusMesh(draw(3, 9), draw(3, 6), {real(-50, 50), real(-50, 50), 0});
      break;
    case 1:
      result.mesh = CubeMesh(draw(1, 4));
      break;
    case 2:
      result.mesh = FlatGrid(draw(1, 6), real(-1, 1));
      break;
    default:
      result.mesh = TriangleSoup(draw(1, 60), seed);
  }
  LatticeOptions& options = result.options;
  for (size_t a = 0; a < 3; ++a) {
    options.degree[a] = draw(1, 3);
    options.extra[a] = draw(0, 4);
  }
  options.knots = static_cast<KnotKind>(draw(0, 3));
  options.shear = draw(0, 1) ? real(-0.3, 0.3) : 0;
  options.mirrored = draw(0, 1) == 1;
  // In a third of the cases the frame has the mesh's size, so that faces and knot planes coincide.
  options.scale = draw(0, 2) == 0 ? 1.0 : real(0.4, 1.3);
  options.shift = draw(0, 1) ? Vec3d{real(-0.3, 0.3), real(-0.3, 0.3), 0.5 * draw(-1, 1)} : Vec3d{};
  result.segments = draw(1, 8);
  return result;
}

std::vector<Vec3d> Jitter(const LatticeStructure& s, double amount, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double shortest = Norm(s.frame.edges[0]);
  for (const Vec3d& edge : s.frame.edges) shortest = std::min(shortest, Norm(edge));
  std::vector<Vec3d> points = IdentityControlPoints(s);
  for (Vec3d& p : points) {
    p += (amount * shortest) * Vec3d{uniform(random), uniform(random), uniform(random)};
  }
  return points;
}

}  // namespace latticed::testing
