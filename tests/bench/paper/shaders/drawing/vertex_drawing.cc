// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/drawing/vertex_drawing.h"

#include <utility>

#include "core/base/status_macros.h"
#include "core/ffd/tessellation_pattern.h"
#include "tests/bench/paper/shaders/drawing/time_commands.h"
#include "tests/bench/paper/shaders/gl_context.h"

namespace latticed::bench {
namespace {

constexpr int kDrawnSize = 256;  // as the tessellator's picture

constexpr char kVertexText[] = R"(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 vertex_normal;
uniform float view_scale = 1.0;
out vec3 normal;
void main() {
  normal = vertex_normal;
  gl_Position = vec4(view_scale * position, 1.0);
}
)";
constexpr char kFragmentText[] = R"(#version 450 core
in vec3 normal;
out vec4 colour;
void main() { colour = vec4(0.5 + 0.5 * normal, 1.0); }
)";

std::vector<uint32_t> Indices(size_t patches, int segments) {
  const TessellationPattern& pattern = TessellationPattern::Get(segments);
  std::vector<uint32_t> indices;
  indices.reserve(patches * pattern.triangles.size() * 3);
  for (size_t patch = 0; patch < patches; ++patch) {
    const auto first = static_cast<uint32_t>(patch * pattern.points.size());
    for (const auto& triangle : pattern.triangles) {
      for (const uint16_t corner : triangle) indices.push_back(first + corner);
    }
  }
  return indices;
}

}  // namespace

VertexDrawing::VertexDrawing(GlProgram program, GlBuffer vertices, GlBuffer indices,
                             size_t index_count)
    : program_(std::move(program)),
      vertices_(std::move(vertices)),
      indices_(std::move(indices)),
      index_count_(index_count),
      target_(kDrawnSize) {
  constexpr GLuint kComponents = 3;
  glCreateVertexArrays(1, &vertex_array_);
  glVertexArrayVertexBuffer(vertex_array_, 0, vertices_.id(), 0, kFloatsPerVertex * sizeof(float));
  glVertexArrayElementBuffer(vertex_array_, indices_.id());
  for (const GLuint attribute : {0U, 1U}) {
    glEnableVertexArrayAttrib(vertex_array_, attribute);
    glVertexArrayAttribFormat(vertex_array_, attribute, kComponents, GL_FLOAT, GL_FALSE,
                              attribute * kComponents * sizeof(float));
    glVertexArrayAttribBinding(vertex_array_, attribute, 0);
  }
}

VertexDrawing::~VertexDrawing() { glDeleteVertexArrays(1, &vertex_array_); }

absl::StatusOr<std::unique_ptr<VertexDrawing>> VertexDrawing::Create(
    std::span<const float> vertices, int segments) {
  const auto points = static_cast<size_t>(PointsPerPatch(segments));
  const auto indices = Indices(vertices.size() / kFloatsPerVertex / points, segments);
  const std::vector<GlProgram::Stage> stages{{GL_VERTEX_SHADER, kVertexText},
                                             {GL_FRAGMENT_SHADER, kFragmentText}};
  LATTICED_ASSIGN_OR_RETURN(auto program, GlProgram::Create(stages, {}));
  LATTICED_ASSIGN_OR_RETURN(auto vertex_buffer,
                            GlBuffer::Create(vertices.size_bytes(), vertices.data()));
  LATTICED_ASSIGN_OR_RETURN(auto index_buffer,
                            GlBuffer::Create(indices.size() * sizeof(uint32_t), indices.data()));
  std::unique_ptr<VertexDrawing> drawing(new VertexDrawing(
      std::move(program), std::move(vertex_buffer), std::move(index_buffer), indices.size()));
  LATTICED_RETURN_IF_ERROR(GlStatus("vertices to draw"));
  return drawing;
}

void VertexDrawing::DrawAll(float extent) const {
  glDisable(GL_RASTERIZER_DISCARD);
  target_.Bind();
  glClear(GL_COLOR_BUFFER_BIT);
  glProgramUniform1f(program_.id(), glGetUniformLocation(program_.id(), "view_scale"), 1 / extent);
  glUseProgram(program_.id());
  glBindVertexArray(vertex_array_);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(index_count_), GL_UNSIGNED_INT, nullptr);
}

size_t VertexDrawing::CountTriangles() const {
  return GlQuery(GL_PRIMITIVES_GENERATED).Count([&] { DrawAll(1); });
}

absl::StatusOr<std::vector<uint8_t>> VertexDrawing::Draw(float extent) {
  DrawAll(extent);
  auto pixels = target_.Read();
  LATTICED_RETURN_IF_ERROR(GlStatus("the picture of vertices"));
  return pixels;
}

absl::StatusOr<GpuTimes> VertexDrawing::TimeDrawn(float extent, int runs) {
  return TimeCommands(runs, [this, extent] { DrawAll(extent); });
}

}  // namespace latticed::bench
