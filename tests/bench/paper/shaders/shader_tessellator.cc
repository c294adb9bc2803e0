// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/paper/shaders/shader_tessellator.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/status_macros.h"
#include "tests/bench/paper/shaders/drawing/time_commands.h"
#include "tests/bench/paper/shaders/gl_context.h"

namespace latticed::bench {
namespace {

constexpr int kPictureSize = 256;

// What each of the two programs captures per vertex.
struct Captured {
  Vec3f position, normal;
};
struct Probed {
  Vec3f coordinate;
  int32_t patch;
};
constexpr size_t kVertices = 3;  // per triangle

absl::StatusOr<GlProgram> Link(const BezierShaders& shaders, bool fragments,
                               std::span<const char* const> captured) {
  std::vector<GlProgram::Stage> stages{{GL_VERTEX_SHADER, shaders.vertex},
                                       {GL_TESS_CONTROL_SHADER, shaders.control},
                                       {GL_TESS_EVALUATION_SHADER, shaders.evaluation}};
  if (fragments) stages.push_back({GL_FRAGMENT_SHADER, shaders.fragment});
  return GlProgram::Create(stages, captured);
}

}  // namespace

ShaderTessellator::ShaderTessellator(const Spec& spec, size_t patches, Programs programs,
                                     GlBuffer nets)
    : spec_(spec),
      patches_(patches),
      programs_(std::move(programs)),
      nets_(std::move(nets)),
      target_(kPictureSize) {
  glCreateVertexArrays(1, &vertex_array_);
  if (spec.source == NetSource::kBuffer) return;
  glEnableVertexArrayAttrib(vertex_array_, 0);
  glVertexArrayAttribFormat(vertex_array_, 0, 4, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(vertex_array_, 0, 0);
  glVertexArrayVertexBuffer(vertex_array_, 0, nets_.id(), 0, sizeof(NetPoint));
}

ShaderTessellator::~ShaderTessellator() { glDeleteVertexArrays(1, &vertex_array_); }

int ShaderTessellator::PatchVertices() const {
  return spec_.source == NetSource::kBuffer ? 1 : BernsteinCount(spec_.degree) + 1;
}

absl::StatusOr<std::unique_ptr<ShaderTessellator>> ShaderTessellator::Create(
    const Spec& spec, std::span<const NetPoint> nets) {
  const int stride = BernsteinCount(spec.degree) + 1;
  if (spec.source == NetSource::kVertices && stride > kMostPatchVertices) {
    return absl::InvalidArgumentError("a net of this degree has more vertices than a patch");
  }
  const BezierShaders shaders = MakeBezierShaders(spec.degree, spec.level, spec.source);
  constexpr std::array kCaptured{"position", "normal"}, kProbed{"coordinate", "patch_index"};
  Programs programs;
  LATTICED_ASSIGN_OR_RETURN(programs.captured, Link(shaders, false, kCaptured));
  LATTICED_ASSIGN_OR_RETURN(programs.probe, Link(shaders, false, kProbed));
  LATTICED_ASSIGN_OR_RETURN(programs.drawn, Link(shaders, true, {}));
  LATTICED_ASSIGN_OR_RETURN(auto buffer, GlBuffer::Create(nets.size_bytes(), nets.data()));
  std::unique_ptr<ShaderTessellator> tessellator(new ShaderTessellator(
      spec, nets.size() / static_cast<size_t>(stride), std::move(programs), std::move(buffer)));
  LATTICED_RETURN_IF_ERROR(GlStatus("a picture"));
  LATTICED_RETURN_IF_ERROR(tessellator->MakeCaptureBuffers());
  return tessellator;
}

absl::Status ShaderTessellator::MakeCaptureBuffers() {
  glEnable(GL_RASTERIZER_DISCARD);
  Use(programs_.drawn);
  triangles_ = GlQuery(GL_PRIMITIVES_GENERATED).Count([&] { DrawPatches(0, 1); });
  const size_t bytes = triangles_ * kVertices * sizeof(Captured);
  LATTICED_RETURN_IF_ERROR(GlStatus("the first patch"));
  if (bytes == 0) return absl::InternalError("OpenGL makes no triangle of a patch");
  batch_ = std::clamp<size_t>(spec_.capture_bytes / bytes, 1, std::max<size_t>(patches_, 1));
  LATTICED_ASSIGN_OR_RETURN(captured_, GlBuffer::Create(batch_ * bytes, nullptr));
  LATTICED_ASSIGN_OR_RETURN(
      probed_, GlBuffer::Create(batch_ * triangles_ * kVertices * sizeof(Probed), nullptr));
  return absl::OkStatus();
}

void ShaderTessellator::Use(const GlProgram& program) const {
  glUseProgram(program.id());
  target_.Bind();  // the only framebuffer; OpenGL draws nothing without one
  glBindVertexArray(vertex_array_);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, nets_.id());
  glPatchParameteri(GL_PATCH_VERTICES, PatchVertices());
}

void ShaderTessellator::DrawPatches(size_t first, size_t count) const {
  const auto vertices = static_cast<size_t>(PatchVertices());
  glDrawArrays(GL_PATCHES, static_cast<GLint>(first * vertices),
               static_cast<GLsizei>(count * vertices));
}

void ShaderTessellator::CapturePatches(const GlProgram& program, const GlBuffer& to, size_t first,
                                       size_t count) const {
  glEnable(GL_RASTERIZER_DISCARD);
  Use(program);
  glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, to.id());
  glBeginTransformFeedback(GL_TRIANGLES);
  DrawPatches(first, count);
  glEndTransformFeedback();
}

absl::StatusOr<std::vector<ShaderVertex>> ShaderTessellator::Capture(size_t first, size_t count) {
  const GlQuery written(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
  std::vector<ShaderVertex> vertices;
  std::vector<Captured> captured;
  std::vector<Probed> probed;
  for (const size_t last = first + count; first < last; first += batch_) {
    const size_t patches = std::min(batch_, last - first), triangles = patches * triangles_;
    const auto capture = [&](const GlProgram& program, const GlBuffer& to) {
      return written.Count([&] { CapturePatches(program, to, first, patches); }) == triangles;
    };
    if (!capture(programs_.captured, captured_) || !capture(programs_.probe, probed_)) {
      return absl::InternalError("OpenGL captured a different number of triangles");
    }
    captured.resize(triangles * kVertices);
    captured_.Read(captured.size() * sizeof(Captured), captured.data());
    probed.resize(captured.size());
    probed_.Read(probed.size() * sizeof(Probed), probed.data());
    for (size_t i = 0; i < captured.size(); ++i) {
      vertices.push_back(
          {captured[i].position, captured[i].normal, probed[i].coordinate, probed[i].patch});
    }
  }
  LATTICED_RETURN_IF_ERROR(GlStatus("transform feedback"));
  return vertices;
}

void ShaderTessellator::CaptureAll() const {
  for (size_t first = 0; first < patches_; first += batch_) {
    CapturePatches(programs_.captured, captured_, first, std::min(batch_, patches_ - first));
  }
}

void ShaderTessellator::DrawAll(float extent) const {
  glDisable(GL_RASTERIZER_DISCARD);
  target_.Bind();
  glClear(GL_COLOR_BUFFER_BIT);
  const GLuint program = programs_.drawn.id();
  glProgramUniform1f(program, glGetUniformLocation(program, "view_scale"), 1 / extent);
  Use(programs_.drawn);
  DrawPatches(0, patches_);
}

absl::StatusOr<std::vector<uint8_t>> ShaderTessellator::Draw(float extent) {
  DrawAll(extent);
  auto pixels = target_.Read();
  LATTICED_RETURN_IF_ERROR(GlStatus("the picture"));
  return pixels;
}

absl::StatusOr<GpuTimes> ShaderTessellator::TimeCaptured(int runs) {
  return TimeCommands(runs, [this] { CaptureAll(); });
}

absl::StatusOr<GpuTimes> ShaderTessellator::TimeDrawn(float extent, int runs) {
  return TimeCommands(runs, [this, extent] { DrawAll(extent); });
}

}  // namespace latticed::bench
