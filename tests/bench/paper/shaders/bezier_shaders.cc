// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/bezier_shaders.h"

#include <string_view>

#include "core/ffd/box/bernstein.h"
#include "fmt/format.h"

namespace latticed::bench {
namespace {

constexpr std::string_view kVersion = "#version 450 core\n";

constexpr std::string_view kVertex = R"(
{0}
out int vertex_patch;
void main() {{
  {1}
  vertex_patch = gl_VertexID / {2};
}}
)";

constexpr std::string_view kControl = R"(
layout(vertices = {0}) out;
in int vertex_patch[];
patch out int patch_number;
{1}
void main() {{
  {2}
  if (gl_InvocationID == 0) {{
    patch_number = vertex_patch[0];
    gl_TessLevelInner[0] = {3}.0;
    gl_TessLevelOuter[0] = {3}.0;
    gl_TessLevelOuter[1] = {3}.0;
    gl_TessLevelOuter[2] = {3}.0;
  }}
}}
)";

constexpr std::string_view kEvaluation = R"(
layout(triangles, equal_spacing, ccw) in;
{0}
patch in int patch_number;
uniform float view_scale = 1.0;
out vec3 position;
out vec3 normal;
out vec3 coordinate;
out int patch_index;
void main() {{
  patch_index = patch_number;
  int base = patch_number * {1};
  coordinate = gl_TessCoord;
  float y1 = gl_TessCoord.y, z1 = gl_TessCoord.z, x1 = 1.0 - y1 - z1;
{2}
  vec3 sum_x = vec3(0.0), sum_y = vec3(0.0), sum_z = vec3(0.0), p;
{3}
  vec3 across = cross(sum_y - sum_x, sum_z - sum_x);
  float area = length(across);
  normal = area > 0.0 ? across / area : vec3(0.0);
  position = {4} + (x1 * sum_x + y1 * sum_y + z1 * sum_z);
  gl_Position = vec4(view_scale * position, 1.0);
}}
)";

constexpr std::string_view kFragment = R"(
in vec3 normal;
out vec4 colour;
void main() { colour = vec4(0.5 + 0.5 * normal, 1.0); }
)";

// B^{i+j+k}_ijk as an expression of the powers x1 … of b0, y1 … of b1 and z1 … of b2.
std::string Weight(int i, int j, int k) {
  constexpr double kOne = 1;
  std::string text = fmt::format("{:.1f}", Bernstein(i, j, k, kOne, kOne, kOne));
  if (i > 0) text += fmt::format(" * x{}", i);
  if (j > 0) text += fmt::format(" * y{}", j);
  if (k > 0) text += fmt::format(" * z{}", k);
  return text;
}

std::string WeightName(int i, int j, int k) { return fmt::format("w_{}_{}_{}", i, j, k); }

// Defines the powers of the coordinates, then the polynomials of `degree`.
std::string Weights(int degree) {
  std::string text;
  for (const char* const b : {"x", "y", "z"}) {
    for (int e = 2; e <= degree; ++e) {
      text += fmt::format("  float {0}{1} = {0}{2} * {0}1;\n", b, e, e - 1);
    }
  }
  for (int i = degree; i >= 0; --i) {
    for (int k = 0; k <= degree - i; ++k) {
      const int j = degree - i - k;
      text += fmt::format("  float {} = {};\n", WeightName(i, j, k), Weight(i, j, k));
    }
  }
  return text;
}

std::string Net(int index, NetSource source) {
  return source == NetSource::kBuffer ? fmt::format("nets[base + {}].xyz", index)
                                      : fmt::format("net[{}].xyz", index);
}

std::string Sums(int degree, NetSource source) {
  std::string text;
  for (int i = degree; i >= 0; --i) {
    for (int k = 0; k <= degree - i; ++k) {
      const int j = degree - i - k;
      text += fmt::format("  p = {};", Net(BernsteinIndex(degree, i, k), source));
      if (i > 0) text += fmt::format(" sum_x += {} * p;", WeightName(i - 1, j, k));
      if (j > 0) text += fmt::format(" sum_y += {} * p;", WeightName(i, j - 1, k));
      if (k > 0) text += fmt::format(" sum_z += {} * p;", WeightName(i, j, k - 1));
      text += "\n";
    }
  }
  return text;
}

}  // namespace

BezierShaders MakeBezierShaders(int degree, int level, NetSource source) {
  const bool buffer = source == NetSource::kBuffer;
  const int m = BernsteinCount(degree);
  BezierShaders shaders;
  const int vertices = buffer ? 1 : m + 1;
  shaders.vertex = kVersion;
  shaders.vertex +=
      fmt::format(kVertex, buffer ? "" : "layout(location = 0) in vec4 net_point;\nout vec4 point;",
                  buffer ? "" : "point = net_point;", vertices);
  shaders.control = kVersion;
  shaders.control +=
      fmt::format(kControl, vertices, buffer ? "" : "in vec4 point[];\nout vec4 net[];",
                  buffer ? "" : "net[gl_InvocationID] = point[gl_InvocationID];", level);
  shaders.evaluation = kVersion;
  shaders.evaluation +=
      fmt::format(kEvaluation,
                  buffer ? "layout(std430, binding = 0) readonly buffer Nets { vec4 nets[]; };"
                         : "in vec4 net[];",
                  m + 1, Weights(degree - 1), Sums(degree, source), Net(m, source));
  shaders.fragment = kVersion;
  shaders.fragment += kFragment;
  return shaders;
}

}  // namespace latticed::bench
