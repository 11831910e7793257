// Making OpenGL objects, with every failure reported.
// See objects.h.
#include "render/gl/objects.h"

#include <string>

#include "render/base/error.h"

namespace warpscope::gl {

void check(std::string_view what) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  while (glGetError() != GL_NO_ERROR) {
  }
  throw InputError("OpenGL: " + std::string(what) + " failed" +
                   (error == GL_OUT_OF_MEMORY ? ": out of memory" : " with error " + std::to_string(error)));
}

Buffer makeBuffer(const void* data, size_t sizeBytes) {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  Buffer buffer(name);
  glNamedBufferStorage(name, static_cast<GLsizeiptr>(sizeBytes), data, 0);
  check("making a buffer of " + std::to_string(sizeBytes) + " bytes");
  return buffer;
}

Texture makeTexture2D(GLenum internalFormat, uint32_t width, uint32_t height) {
  GLuint name = 0;
  glCreateTextures(GL_TEXTURE_2D, 1, &name);
  Texture texture(name);
  glTextureStorage2D(name, 1, internalFormat, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
  glTextureParameteri(name, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(name, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  check("making a texture of " + std::to_string(width) + "x" + std::to_string(height) + " pixels");
  return texture;
}

VertexArray makeVertexArray() {
  GLuint name = 0;
  glCreateVertexArrays(1, &name);
  VertexArray array(name);
  check("making a vertex array");
  return array;
}

Framebuffer makeFramebuffer(const Texture& color, const Texture& depth) {
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  Framebuffer framebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, color.name(), 0);
  glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, depth.name(), 0);
  const GLenum status = glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE)
    throw InputError("OpenGL: the framebuffer is not complete, status " + std::to_string(status));
  return framebuffer;
}

namespace {

GLuint compile(std::string_view name, GLenum stage, std::string_view source) {
  const GLuint shader = glCreateShader(stage);
  const char* text = source.data();
  const auto length = static_cast<GLint>(source.size());
  glShaderSource(shader, 1, &text, &length);
  glCompileShader(shader);
  GLint ok = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok == GL_TRUE) return shader;
  char log[1024] = "";
  glGetShaderInfoLog(shader, sizeof log, nullptr, log);
  glDeleteShader(shader);
  throw InputError("OpenGL: a shader of " + std::string(name) + " does not compile: " + log);
}

}  // namespace

Program makeProgram(std::string_view name, std::string_view vertexSource, std::string_view fragmentSource) {
  Program program(glCreateProgram());
  for (const auto& [stage, source] : {std::pair{GL_VERTEX_SHADER, vertexSource}, {GL_FRAGMENT_SHADER, fragmentSource}}) {
    const GLuint shader = compile(name, stage, source);
    glAttachShader(program.name(), shader);
    glDeleteShader(shader);  // stays until the program goes
  }
  glLinkProgram(program.name());
  GLint ok = GL_FALSE;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &ok);
  if (ok != GL_TRUE) {
    char log[1024] = "";
    glGetProgramInfoLog(program.name(), sizeof log, nullptr, log);
    throw InputError("OpenGL: the program of " + std::string(name) + " does not link: " + log);
  }
  return program;
}

}  // namespace warpscope::gl
