// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/client/patches/shader/patch_shader.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/adaptive/adaptive_pattern.h"
#include "core/base/status_macros.h"
#include "fmt/format.h"
#include "tests/bench/paper/shaders/gl_context.h"
#include "tests/bench/paper/shaders/gl_objects.h"
#include "tests/client/patches/shader/shader_textures.h"

namespace latticed::testing {
namespace {

using bench::GlBuffer;
using bench::GlProgram;

constexpr size_t kWidth = 2048;         // of the textures
constexpr int kDenominator = 4096;      // of all patterns together
constexpr size_t kDrawPoints = 32'768;  // past 65,535, Mesa's software renderer may repeat points
constexpr size_t kCaptured = 6;         // floats of a point

// The source with the lattice's degrees after its first line.
std::string WithDegrees(const std::string& text, const std::array<int, 3>& degree) {
  const size_t line = text.find('\n') + 1;
  return text.substr(0, line) +
         fmt::format("#define DEGREE_0 {}\n#define DEGREE_1 {}\n#define DEGREE_2 {}\n", degree[0],
                     degree[1], degree[2]) +
         text.substr(line);
}

class Texture {
 public:
  // `numbers`: four a texel. The texture stays bound to the unit.
  template <typename T>
  Texture(GLuint program, const char* name, GLint unit, GLint format, GLenum numbers_format,
          GLenum type, std::vector<T> numbers) {
    const size_t rows = std::max<size_t>(1, (numbers.size() / 4 + kWidth - 1) / kWidth);
    numbers.resize(rows * kWidth * 4);
    glGenTextures(1, &id_);
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(GL_TEXTURE_2D, id_);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexImage2D(GL_TEXTURE_2D, 0, format, kWidth, static_cast<GLsizei>(rows), 0, numbers_format,
                 type, numbers.data());
    glUniform1i(glGetUniformLocation(program, name), unit);
  }
  ~Texture() { glDeleteTextures(1, &id_); }
  Texture(const Texture&) = delete;

 private:
  GLuint id_ = 0;
};

// The attribute patchPlace of every point.
std::vector<uint32_t> Points(const client::PatchSurface& surface) {
  std::vector<uint32_t> points;
  for (size_t p = 0; p < surface.patterns.size(); ++p) {
    const AdaptivePattern& pattern =
        AdaptivePattern::Get(*PatternKey::FromCode(surface.patterns[p]));
    const auto factor = static_cast<uint32_t>(kDenominator / pattern.denominator);
    for (const auto& i : pattern.points) {
      points.push_back(static_cast<uint32_t>(p));
      points.push_back(factor * i[1] | factor * i[2] << 16);
    }
  }
  return points;
}

absl::Status Draw(const std::vector<uint32_t>& points, GLuint program,
                  std::vector<float>* captured) {
  const bench::GlTarget nothing(1);  // a context without a surface draws into a framebuffer only
  nothing.Bind();
  GLuint layout = 0;
  glGenVertexArrays(1, &layout);
  glBindVertexArray(layout);
  const auto place = static_cast<GLuint>(glGetAttribLocation(program, "patchPlace"));
  const size_t count = points.size() / 2;
  captured->resize(count * kCaptured);
  glEnable(GL_RASTERIZER_DISCARD);
  for (size_t first = 0; first < count; first += kDrawPoints) {
    const size_t some = std::min(kDrawPoints, count - first),
                 bytes = some * kCaptured * sizeof(float);
    LATTICED_ASSIGN_OR_RETURN(const auto from,
                              GlBuffer::Create(some * 2 * sizeof(uint32_t), &points[2 * first]));
    LATTICED_ASSIGN_OR_RETURN(const auto to, GlBuffer::Create(bytes, nullptr));
    glBindBuffer(GL_ARRAY_BUFFER, from.id());
    glEnableVertexAttribArray(place);
    glVertexAttribIPointer(place, 2, GL_UNSIGNED_INT, 0, nullptr);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, to.id());
    glBeginTransformFeedback(GL_POINTS);
    glDrawArrays(GL_POINTS, 0, static_cast<GLsizei>(some));
    glEndTransformFeedback();
    to.Read(bytes, captured->data() + first * kCaptured);
  }
  glDisable(GL_RASTERIZER_DISCARD);
  glDeleteVertexArrays(1, &layout);
  return bench::GlStatus("evaluating patches");
}

}  // namespace

absl::StatusOr<client::PatchSurface> EvaluateByShader(const PatchScene& scene,
                                                      const std::string& text,
                                                      client::PatchSurface surface) {
  const GlProgram::Stage stage{GL_VERTEX_SHADER, WithDegrees(text, scene.plan->structure.degree)};
  constexpr std::array kOutputs{"point", "pointNormal"};
  LATTICED_ASSIGN_OR_RETURN(const auto program, GlProgram::Create(std::span(&stage, 1), kOutputs));
  const GLuint id = program.id();
  glUseProgram(id);
  const ShaderTextures data = MakeShaderTextures(scene);
  const Texture patches(id, "patches", 0, GL_RGBA32I, GL_RGBA_INTEGER, GL_INT, data.patches);
  const Texture seams(id, "seams", 1, GL_RGBA32I, GL_RGBA_INTEGER, GL_INT, data.seams);
  const Texture boxes(id, "boxes", 2, GL_RGBA32F, GL_RGBA, GL_FLOAT, data.boxes);
  const Texture normals(id, "normals", 3, GL_RGBA32F, GL_RGBA, GL_FLOAT, data.normals);
  glUniform1i(glGetUniformLocation(id, "denominator"), kDenominator);
  glUniform3iv(glGetUniformLocation(id, "boxSteps"), 1, data.box_steps.data());
  glUniformMatrix3fv(glGetUniformLocation(id, "conormals"), 1, GL_FALSE, data.conormals.data());

  std::vector<float> captured;
  LATTICED_RETURN_IF_ERROR(Draw(Points(surface), id, &captured));
  for (size_t i = 0; i < surface.positions.size(); ++i) {
    const float* at = &captured[i * kCaptured];
    surface.positions[i] = {at[0], at[1], at[2]};
    if (!surface.normals.empty()) surface.normals[i] = {at[3], at[4], at[5]};
  }
  return surface;
}

}  // namespace latticed::testing
