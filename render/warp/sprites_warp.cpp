// Spheres as instances of a strip of two triangles.
// See sprites_warp.h. Deviation: fragment depth is the reciprocal of the distance along the ray.
#include "render/warp/sprites_warp.h"

#include <algorithm>

#include "render/base/error.h"
#include "render/gl/canvas.h"
#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "render/warp/sphere_cloud_warp.h"
#include "shaders.h"

namespace warpscope {
namespace {

/// Distance whose depth is 1, volume units: so small that whatever unit a volume has, depths are as precise as floats are.
constexpr float kNearest = 1e-24f;

/// Drawing is looked into for a stop after so many sprites.
constexpr size_t kSpritesPerCall = 1 << 18;

class SpritesWarp final : public SphereCloudWarp {
 public:
  explicit SpritesWarp(gl::Context& context) : context_(gl::current(context)) {
    program_ = gl::makeProgram("sprites", shaders::find("sprites.vert"), shaders::find("sprites.frag"));
    vertexArray_ = gl::makeVertexArray();
    static_assert(sizeof(Sphere) == 4 * sizeof(float));
    glEnableVertexArrayAttrib(vertexArray_.name(), 0);
    glVertexArrayAttribFormat(vertexArray_.name(), 0, 4, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vertexArray_.name(), 0, 0);
    glVertexArrayBindingDivisor(vertexArray_.name(), 0, 1);
  }
  ~SpritesWarp() override {
    if (context_.tryMakeCurrent()) return;
    program_.abandon();
    vertexArray_.abandon();
    buffer_.abandon();
    canvas_.abandon();
  }

 protected:
  void build(const SampleFrame&, std::span<const Sphere> spheres, const WarpSettings&) override {
    context_.makeCurrent();
    buffer_ = {};
    if (spheres.empty()) return;
    buffer_ = gl::makeBuffer(spheres.data(), spheres.size_bytes());
    glVertexArrayVertexBuffer(vertexArray_.name(), 0, buffer_.name(), 0, sizeof(Sphere));
  }

  void drawSpheres(const SampleFrame& frame, const Camera& camera, const WarpSettings&, WarpedImage& image, const std::stop_token& stop) override {
    context_.makeCurrent();
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
    if (!buffer_) return;
    canvas_.begin(camera.width, camera.height, kNoSample);
    glUseProgram(program_.name());
    const auto place = [&](const char* name) { return glGetUniformLocation(program_.name(), name); };
    const auto setVector = [&](const char* name, const glm::vec3& value) { glUniform3f(place(name), value.x, value.y, value.z); };
    setVector("eye", camera.eye);
    setVector("right", camera.right);
    setVector("up", camera.up);
    setVector("forward", camera.forward);
    glUniform1f(place("edge"), pixelEdge(camera));
    glUniform2f(place("halfSize"), 0.5f * static_cast<float>(camera.width), 0.5f * static_cast<float>(camera.height));
    glUniform1f(place("nearest"), kNearest);
    glBindVertexArray(vertexArray_.name());
    for (size_t first = 0; first < frame.size(); first += kSpritesPerCall) {
      const size_t count = std::min(kSpritesPerCall, frame.size() - first);
      glUniform1ui(place("firstSample"), static_cast<GLuint>(first));
      glDrawArraysInstancedBaseInstance(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(count), static_cast<GLuint>(first));
      if (first + count < frame.size() && stop.stop_possible()) glFinish();  // a software rasteriser takes its time
      if (stop.stop_requested()) throw OperationCancelled();
    }
    canvas_.read(image.samples);
    gl::check("drawing sprites");
    resolveColors(frame, image.samples, image.color);
  }

 private:
  gl::Context& context_;
  gl::Program program_;
  gl::VertexArray vertexArray_;
  gl::Buffer buffer_;
  gl::Canvas canvas_{GL_R32UI};
};

std::unique_ptr<Warp> makeSpritesWarp(const WarpResources& resources) { return std::make_unique<SpritesWarp>(resources.context()); }

}  // namespace

constinit const WarpDescriptor kSpritesWarp{
    .name = "sprites",
    .label = "Sprites",
    .summary = "OpenGL sprites as large as spheres are seen, each fragment at the sphere's depth",
    .usesOpenGl = true,
    .uses = {.depth = true, .radius = true},
    .make = makeSpritesWarp,
};

}  // namespace warpscope
