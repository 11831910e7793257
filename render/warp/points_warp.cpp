// Points into an image of sample ids, with a reversed float depth buffer.
// See points_warp.h. Deviation: window z is not what is kept, the depth test alone uses it.
#include "render/warp/points_warp.h"

#include <algorithm>
#include <vector>

#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "shaders.h"

namespace warpscope {
namespace {

/// Nearest distance from the eye's plane at which points are drawn, in volume units.
constexpr float kNearDepth = 1e-3f;

/// Drawing is looked into for a stop after so many points.
constexpr size_t kPointsPerCall = 1 << 20;

class PointsWarp final : public Warp {
 public:
  explicit PointsWarp(gl::Context& context) : context_(context) {
    context_.makeCurrent();
    program_ = gl::makeProgram("points", shaders::find("points.vert"), shaders::find("points.frag"));
    clipFromVolume_ = glGetUniformLocation(program_.name(), "clipFromVolume");
    pointSize_ = glGetUniformLocation(program_.name(), "pointSize");
    vertexArray_ = gl::makeVertexArray();
    glEnableVertexArrayAttrib(vertexArray_.name(), 0);
    glVertexArrayAttribFormat(vertexArray_.name(), 0, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(vertexArray_.name(), 0, 0);
    GLfloat range[2] = {1.0f, 1.0f};
    glGetFloatv(GL_POINT_SIZE_RANGE, range);
    largestPoint_ = range[1];
    GLint side = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
    largestSide_ = static_cast<uint32_t>(side);
  }
  ~PointsWarp() override {
    if (context_.tryMakeCurrent()) return;
    program_.abandon();
    vertexArray_.abandon();
    buffer_.abandon();
    seen_.abandon();
    depth_.abandon();
    framebuffer_.abandon();
  }

  void setFrame(SampleFramePtr frame, const WarpSettings&, const std::stop_token&) override {
    context_.makeCurrent();
    frame_ = std::move(frame);
    buffer_ = {};
    if (!frame_ || frame_->size() == 0) return;
    positions_.resize(frame_->size());
    const SampleGrid grid = frame_->grid();
    parallelForRanges(frame_->size(), 1 << 15, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) positions_[i] = unpackPosition(frame_->samples[i], grid);
    });
    buffer_ = gl::makeBuffer(positions_.data(), positions_.size() * sizeof(glm::vec3));
    glVertexArrayVertexBuffer(vertexArray_.name(), 0, buffer_.name(), 0, sizeof(glm::vec3));
  }

  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image,
            const std::stop_token& stop) override {
    requireUsable(camera);
    validate(settings);
    context_.makeCurrent();
    const float pointPx = settings.knobs.number(kPointSizeKnob);
    if (pointPx > largestPoint_)
      throw InputError("this OpenGL driver draws points of at most " + std::to_string(largestPoint_) + " pixels");
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
    if (!buffer_) return;
    prepareTarget(camera.width, camera.height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
    glViewport(0, 0, static_cast<GLsizei>(camera.width), static_cast<GLsizei>(camera.height));
    const GLuint nothing[4] = {kNoSample, 0, 0, 0};
    const GLfloat farthest = 0.0f;
    glClearNamedFramebufferuiv(framebuffer_.name(), GL_COLOR, 0, nothing);
    glClearNamedFramebufferfv(framebuffer_.name(), GL_DEPTH, 0, &farthest);
    glEnable(GL_PROGRAM_POINT_SIZE);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);  // reversed; of equal depths the first drawn, the lower id, stays
    // Rows upside down, so that row 0 of what is read back is the top row.
    glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    glUseProgram(program_.name());
    const glm::mat4 matrix = clipFromVolume(camera, kNearDepth);
    glUniformMatrix4fv(clipFromVolume_, 1, GL_FALSE, &matrix[0][0]);
    glUniform1f(pointSize_, pointPx);
    glBindVertexArray(vertexArray_.name());
    for (size_t first = 0; first < frame_->size(); first += kPointsPerCall) {
      glDrawArrays(GL_POINTS, static_cast<GLint>(first), static_cast<GLsizei>(std::min(kPointsPerCall, frame_->size() - first)));
      if (first + kPointsPerCall < frame_->size() && stop.stop_possible()) glFinish();  // a software rasteriser takes its time
      if (stop.stop_requested()) throw OperationCancelled();
    }
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, static_cast<GLsizei>(camera.width), static_cast<GLsizei>(camera.height), GL_RED_INTEGER,
                 GL_UNSIGNED_INT, image.samples.data());
    gl::check("drawing points");
    resolveColors(*frame_, image.samples, image.color);
  }

 private:
  void prepareTarget(uint32_t width, uint32_t height) {
    if (framebuffer_ && width == width_ && height == height_) return;
    if (width > largestSide_ || height > largestSide_)
      throw InputError("this OpenGL driver draws images of at most " + std::to_string(largestSide_) + " pixels a side");
    framebuffer_ = {};
    seen_ = gl::makeTexture2D(GL_R32UI, width, height);
    depth_ = gl::makeTexture2D(GL_DEPTH_COMPONENT32F, width, height);
    framebuffer_ = gl::makeFramebuffer(seen_, depth_);
    width_ = width;
    height_ = height;
  }

  gl::Context& context_;
  gl::Program program_;
  gl::VertexArray vertexArray_;
  gl::Buffer buffer_;
  gl::Texture seen_, depth_;
  gl::Framebuffer framebuffer_;
  GLint clipFromVolume_ = -1;
  GLint pointSize_ = -1;
  GLfloat largestPoint_ = 1.0f;
  uint32_t largestSide_ = 0;
  uint32_t width_ = 0;
  uint32_t height_ = 0;
  SampleFramePtr frame_;
  std::vector<glm::vec3> positions_;
};

std::unique_ptr<Warp> makePointsWarp(const WarpResources& resources) {
  return std::make_unique<PointsWarp>(resources.context());
}

constexpr double kSweptSizes[] = {1.0, 2.0, 3.0};
constexpr const Knob* kKnobs[] = {&kPointSizeKnob};

}  // namespace

constinit const Knob kPointSizeKnob{
    .key = "pointSize",
    .option = "--point-size",
    .label = "Points",
    .noun = "point size",
    .help = "Edge of a point in pixels of its picture (Zellmann, Aumueller, Lang 2012)",
    .unit = " px",
    .type = KnobType::whole,
    .stale = KnobStage::draw,
    .range = {1.0, 16.0},
    .track = {1.0, 16.0},
    .defaultValue = 2.0,
    .axis = {"pointSizes", "--point-sizes", "Sizes of points in pixels", kSweptSizes},
    .phrase = " of {} px",
};

constinit const WarpDescriptor kPointsWarp{
    .name = "points",
    .label = "Points",
    .summary = "OpenGL points of a fixed size in pixels (2012)",
    .uses = {.depth = true},
    .knobs = kKnobs,
    .make = makePointsWarp,
};

}  // namespace warpscope
