// OpenGL objects that free themselves, and calls that check. A context must be current wherever these are made, used or destroyed.
// OpenGL 4.5 core, direct state access.
#pragma once

#include <glad/gl.h>

#include <string_view>
#include <utility>

namespace warpscope::gl {

/// An object name owned by one holder. `Traits::destroy(GLuint)` frees it.
template <class Traits>
class Object {
 public:
  Object() = default;
  explicit Object(GLuint name) : name_(name) {}
  Object(Object&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  Object& operator=(Object&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
  ~Object() {
    if (name_ != 0) Traits::destroy(name_);
  }
  /// Forgets the name without deleting it: where its context cannot be made current, the name may be another context's.
  void abandon() noexcept { name_ = 0; }
  GLuint name() const { return name_; }
  explicit operator bool() const { return name_ != 0; }

 private:
  GLuint name_ = 0;
};

struct BufferTraits {
  static void destroy(GLuint name) { glDeleteBuffers(1, &name); }
};
struct TextureTraits {
  static void destroy(GLuint name) { glDeleteTextures(1, &name); }
};
struct FramebufferTraits {
  static void destroy(GLuint name) { glDeleteFramebuffers(1, &name); }
};
struct VertexArrayTraits {
  static void destroy(GLuint name) { glDeleteVertexArrays(1, &name); }
};
struct ProgramTraits {
  static void destroy(GLuint name) { glDeleteProgram(name); }
};
using Buffer = Object<BufferTraits>;
using Texture = Object<TextureTraits>;
using Framebuffer = Object<FramebufferTraits>;
using VertexArray = Object<VertexArrayTraits>;
using Program = Object<ProgramTraits>;

/// Throws InputError naming `what` if OpenGL reports an error (out of memory, most likely).
void check(std::string_view what);

Buffer makeBuffer(const void* data, size_t sizeBytes);
Texture makeTexture2D(GLenum internalFormat, uint32_t width, uint32_t height);
VertexArray makeVertexArray();
/// A framebuffer with one colour and one depth attachment; throws if it is not complete.
Framebuffer makeFramebuffer(const Texture& color, const Texture& depth);
/// Compiles and links; throws with the driver's log and `name`, which says whose shaders these are.
Program makeProgram(std::string_view name, std::string_view vertexSource, std::string_view fragmentSource);

}  // namespace warpscope::gl
