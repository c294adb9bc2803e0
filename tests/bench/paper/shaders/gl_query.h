// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// What the OpenGL device counts between two points of its command stream.
//
// Threads  that of the context
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_QUERY_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_QUERY_H_

#include <epoxy/gl.h>

#include <cstdint>

namespace latticed::bench {

class GlQuery {
 public:
  // GL_TIME_ELAPSED, nanoseconds; GL_PRIMITIVES_GENERATED …
  explicit GlQuery(GLenum counted) : counted_(counted) { glCreateQueries(counted, 1, &id_); }
  ~GlQuery() { glDeleteQueries(1, &id_); }
  GlQuery(const GlQuery&) = delete;  // one owner
  GlQuery& operator=(const GlQuery&) = delete;

  // Waits until the device has come so far.
  uint64_t Count(const auto& commands) const {
    glBeginQuery(counted_, id_);
    commands();
    glEndQuery(counted_);
    GLuint64 result = 0;
    glGetQueryObjectui64v(id_, GL_QUERY_RESULT, &result);
    return result;
  }

 private:
  GLenum counted_;
  GLuint id_ = 0;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_QUERY_H_
