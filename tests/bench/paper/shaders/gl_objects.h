// SPDX-FileCopyrightText: The latticed authors
// SPDX-License-Identifier: Apache-2.0
//
// OpenGL objects, each with one owner.
//
// Errors   kResourceExhausted, kInternal
// Threads  only the context's thread
#ifndef LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_OBJECTS_H_
#define LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_OBJECTS_H_

#include <epoxy/gl.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"

namespace latticed::bench {

template <class Delete>
class GlObject {
 public:
  explicit GlObject(GLuint id = 0) : id_(id) {}
  ~GlObject() {
    if (id_ != 0) Delete()(id_);
  }
  GlObject(GlObject&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }

  GLuint id() const { return id_; }

 private:
  GLuint id_;
};

// Device memory of a fixed size.
class GlBuffer {
 public:
  GlBuffer() = default;
  // Copies `bytes` bytes from `from`. If `from` is null, the memory is uninitialised.
  [[nodiscard]] static absl::StatusOr<GlBuffer> Create(size_t bytes, const void* from);

  GLuint id() const { return object_.id(); }
  // Reads the first `bytes` bytes, after everything drawn before.
  void Read(size_t bytes, void* to) const;

 private:
  struct Delete {
    void operator()(GLuint id) const { glDeleteBuffers(1, &id); }
  };
  GlObject<Delete> object_;
};

// A linked program.
class GlProgram {
 public:
  struct Stage {
    GLenum kind;  // GL_VERTEX_SHADER …
    std::string text;
  };

  // Transform feedback takes the outputs named in `captured`, interleaved. kInternal with the
  // message of the compiler or linker.
  [[nodiscard]] static absl::StatusOr<GlProgram> Create(std::span<const Stage> stages,
                                                        std::span<const char* const> captured);

  GLuint id() const { return object_.id(); }

 private:
  struct Delete {
    void operator()(GLuint id) const { glDeleteProgram(id); }
  };
  GlObject<Delete> object_;
};

// A square picture to draw into, four bytes per pixel.
class GlTarget {
 public:
  explicit GlTarget(int size);

  // Directs what is drawn next to this picture.
  void Bind() const;
  // Red, green, blue, alpha. Waits for everything drawn.
  std::vector<uint8_t> Read() const;

 private:
  struct DeleteFramebuffer {
    void operator()(GLuint id) const { glDeleteFramebuffers(1, &id); }
  };
  struct DeletePixels {
    void operator()(GLuint id) const { glDeleteRenderbuffers(1, &id); }
  };
  GLsizei size_;
  GlObject<DeleteFramebuffer> framebuffer_;
  GlObject<DeletePixels> pixels_;
};

// Counts on the device between two points of its command stream.
class GlQuery {
 public:
  // `counted`: GL_TIME_ELAPSED (nanoseconds), GL_PRIMITIVES_GENERATED …
  explicit GlQuery(GLenum counted);

  // Waits until the device has run the commands.
  uint64_t Count(const auto& commands) const {
    glBeginQuery(counted_, object_.id());
    commands();
    glEndQuery(counted_);
    GLuint64 result = 0;
    glGetQueryObjectui64v(object_.id(), GL_QUERY_RESULT, &result);
    return result;
  }

 private:
  struct Delete {
    void operator()(GLuint id) const { glDeleteQueries(1, &id); }
  };
  GLenum counted_;
  GlObject<Delete> object_;
};

}  // namespace latticed::bench

#endif  // LATTICED_TESTS_BENCH_PAPER_SHADERS_GL_OBJECTS_H_
