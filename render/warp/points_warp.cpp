// Points into an image of sample ids, with a reversed float depth buffer.
// See points_warp.h. Deviation: window z is not what is kept, the depth test alone uses it.
#include "render/warp/points_warp.h"

#include <algorithm>
#include <vector>

#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/gl/canvas.h"
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
  explicit PointsWarp(gl::Context& context) : context_(gl::current(context)) {
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
  }
  ~PointsWarp() override {
    if (context_.tryMakeCurrent()) return;
    program_.abandon();
    vertexArray_.abandon();
    buffer_.abandon();
    canvas_.abandon();
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
    context_.makeCurrent();
    const float pointPx = settings.knobs.number(kPointSizeKnob);
    if (pointPx > largestPoint_)
      throw InputError("this OpenGL driver draws points of at most " + std::to_string(largestPoint_) + " pixels");
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
    if (!buffer_) return;
    canvas_.begin(camera.width, camera.height, kNoSample);
    glEnable(GL_PROGRAM_POINT_SIZE);
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
    canvas_.read(image.samples);
    gl::check("drawing points");
    resolveColors(*frame_, image.samples, image.color);
  }

 private:
  gl::Context& context_;
  gl::Program program_;
  gl::VertexArray vertexArray_;
  gl::Buffer buffer_;
  gl::Canvas canvas_{GL_R32UI};
  GLint clipFromVolume_ = -1;
  GLint pointSize_ = -1;
  GLfloat largestPoint_ = 1.0f;
  SampleFramePtr frame_;
  std::vector<glm::vec3> positions_;
};

std::unique_ptr<Warp> makePointsWarp(const WarpResources& resources) {
  return std::make_unique<PointsWarp>(resources.context());
}

constexpr double kSweptSizes[] = {1.0, 2.0, 3.0};
constexpr const Knob* kPointsKnobs[] = {&kPointSizeKnob};

}  // namespace

constinit const Knob kPointSizeKnob{
    .key = "pointSize",
    .option = "--point-size",
    .label = "Point size",
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
    .usesOpenGl = true,
    .uses = {.depth = true},
    .knobs = kPointsKnobs,
    .make = makePointsWarp,
};

}  // namespace warpscope
