// Two triangles between four pixels, in OpenGL.
// See mesh_warp.h. Samples are drawn as points of one pixel as well: those without neighbours are triangles of nothing, and a surface's last ones lie on its
// edge, whose pixels it covers in part only.
#include "render/warp/mesh_warp.h"

#include <algorithm>
#include <array>
#include <vector>

#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/gl/canvas.h"
#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "render/march/own_picture.h"
#include "shaders.h"

namespace warpscope {
namespace {

/// Nearest distance from the eye's plane at which anything is drawn, in volume units.
constexpr float kNearDepth = 1e-3f;

/// Drawing is looked into for a stop after so many corners.
constexpr size_t kCornersPerCall = 3 << 18;

struct Vertex {
  glm::vec3 position;
  glm::vec4 color;
};

class MeshWarp final : public Warp {
 public:
  explicit MeshWarp(gl::Context& context) : context_(gl::current(context)) {
    program_ = gl::makeProgram("mesh", shaders::find("mesh.vert"), shaders::find("mesh.frag"));
    vertexArray_ = gl::makeVertexArray();
    const auto addAttribute = [&](GLuint place, GLint size, size_t offset) {
      glEnableVertexArrayAttrib(vertexArray_.name(), place);
      glVertexArrayAttribFormat(vertexArray_.name(), place, size, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
      glVertexArrayAttribBinding(vertexArray_.name(), place, 0);
    };
    addAttribute(0, 3, offsetof(Vertex, position));
    addAttribute(1, 4, offsetof(Vertex, color));
  }
  ~MeshWarp() override {
    if (context_.tryMakeCurrent()) return;
    program_.abandon();
    vertexArray_.abandon();
    vertices_.abandon();
    corners_.abandon();
    canvas_.abandon();
  }

  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop) override {
    context_.makeCurrent();
    vertices_ = {};
    corners_ = {};
    cornerCount_ = vertexCount_ = 0;
    if (!frame || frame->size() == 0) return;
    const Image<uint32_t> pixels = ownPicture(*frame);
    Image<glm::vec4> colors;
    resolveRayColors(*frame, pixels, colors);
    const SampleGrid grid = frame->grid();
    std::vector<Vertex> vertices;
    std::vector<float> depths;
    Image<uint32_t> places(pixels.width(), pixels.height(), kNoSample);  // among the vertices
    for (size_t i = 0; i < pixels.size(); ++i) {
      if (pixels[i] == kNoSample) continue;
      places[i] = static_cast<uint32_t>(vertices.size());
      vertices.push_back({unpackPosition(frame->samples[pixels[i]], grid), colors[i]});
      depths.push_back(glm::dot(vertices.back().position - frame->camera.eye, frame->camera.forward));
    }
    if (stop.stop_requested()) throw OperationCancelled();
    const std::vector<uint32_t> corners = trianglesOf(places, depths, settings.knobs.number(kMeshCutKnob));
    vertices_ = gl::makeBuffer(vertices.data(), vertices.size() * sizeof(Vertex));
    if (!corners.empty()) corners_ = gl::makeBuffer(corners.data(), corners.size() * sizeof(uint32_t));
    glVertexArrayVertexBuffer(vertexArray_.name(), 0, vertices_.name(), 0, sizeof(Vertex));
    glVertexArrayElementBuffer(vertexArray_.name(), corners_.name());
    vertexCount_ = vertices.size();
    cornerCount_ = corners.size();
  }

  void draw(const Camera& camera, const WarpSettings&, WarpedImage& image, const std::stop_token& stop) override {
    requireUsable(camera);
    context_.makeCurrent();
    image.samples.resize(camera.width, camera.height, kNoSample);
    image.color.resize(camera.width, camera.height);
    if (vertexCount_ == 0) return;
    canvas_.begin(camera.width, camera.height, glm::vec4(0.0f, 0.0f, 0.0f, -1.0f));
    glEnable(GL_PROGRAM_POINT_SIZE);
    glUseProgram(program_.name());
    const glm::mat4 matrix = clipFromVolume(camera, kNearDepth);
    glUniformMatrix4fv(glGetUniformLocation(program_.name(), "clipFromVolume"), 1, GL_FALSE, &matrix[0][0]);
    glBindVertexArray(vertexArray_.name());
    const auto drawAll = [&](size_t count, const auto& drawPart) {
      for (size_t first = 0; first < count; first += kCornersPerCall) {
        const size_t part = std::min(kCornersPerCall, count - first);
        drawPart(first, static_cast<GLsizei>(part));
        if (first + part < count && stop.stop_possible()) glFinish();  // a software rasteriser takes its time
        if (stop.stop_requested()) throw OperationCancelled();
      }
    };
    drawAll(cornerCount_, [](size_t first, GLsizei count) {
      glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, reinterpret_cast<const void*>(first * sizeof(uint32_t)));
    });
    drawAll(vertexCount_, [](size_t first, GLsizei count) { glDrawArrays(GL_POINTS, static_cast<GLint>(first), count); });
    canvas_.read(image.color);
    gl::check("drawing a mesh");
    parallelForRanges(image.color.size(), 1 << 15, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        if (image.color[i].a >= 0.0f)
          image.samples[i] = kNotASample;
        else
          image.color[i] = glm::vec4(0.0f);
      }
    });
  }

 private:
  /// Corners of those triangles whose pixels all have a vertex, and depths that are near one another; of the two ways to cut a square the one along which
  /// depths differ less.
  static std::vector<uint32_t> trianglesOf(const Image<uint32_t>& places, const std::vector<float>& depths, float cut) {
    std::vector<uint32_t> corners;
    const auto add = [&](const std::array<uint32_t, 3>& triangle) {
      float least = std::numeric_limits<float>::infinity(), most = -least;
      for (const uint32_t corner : triangle) {
        if (corner == kNoSample) return;
        least = std::min(least, depths[corner]);
        most = std::max(most, depths[corner]);
      }
      if (most - least <= cut * least) corners.insert(corners.end(), triangle.begin(), triangle.end());
    };
    const auto apart = [&](uint32_t a, uint32_t b) {
      return a == kNoSample || b == kNoSample ? std::numeric_limits<float>::infinity() : std::abs(depths[a] - depths[b]);
    };
    for (uint32_t y = 0; y + 1 < places.height(); ++y)
      for (uint32_t x = 0; x + 1 < places.width(); ++x) {
        const uint32_t a = places(x, y), b = places(x + 1, y), c = places(x, y + 1), d = places(x + 1, y + 1);
        if (apart(a, d) <= apart(b, c)) {
          add({a, b, d});
          add({a, d, c});
        } else {
          add({a, b, c});
          add({b, d, c});
        }
      }
    return corners;
  }

  gl::Context& context_;
  gl::Program program_;
  gl::VertexArray vertexArray_;
  gl::Buffer vertices_, corners_;
  gl::Canvas canvas_{GL_RGBA32F};
  size_t vertexCount_ = 0, cornerCount_ = 0;
};

std::unique_ptr<Warp> makeMeshWarp(const WarpResources& resources) { return std::make_unique<MeshWarp>(resources.context()); }

constexpr double kSweptCuts[] = {0.1f};
constexpr const Knob* kMeshKnobs[] = {&kMeshCutKnob};

}  // namespace

constinit const Knob kMeshCutKnob{
    .key = "meshCut",
    .option = "--mesh-cut",
    .label = "Mesh cut",
    .noun = "cut of the mesh",
    .help = "By how much the depths of neighbours may differ that a mesh joins, as a share of the nearer one",
    .type = KnobType::number,
    .stale = KnobStage::build,
    .range = {1e-3, 100.0},
    .track = {1e-3, 10.0},
    .scale = KnobScale::logarithmic,
    .decimals = 3,
    .defaultValue = 0.1f,
    .axis = {"meshCuts", "--mesh-cuts", "Differences of depth that meshes bridge, as shares of the nearer", kSweptCuts},
    .phrase = " cut at {}",
    .naming = KnobNaming::unlessDefault,
};

constinit const WarpDescriptor kMeshWarp{
    .name = "mesh",
    .label = "Mesh",
    .summary = "the depth image as triangles, cut where depth jumps: what is streamed to headsets",
    .usesOpenGl = true,
    .uses = {.depth = true},
    .knobs = kMeshKnobs,
    .make = makeMeshWarp,
};

}  // namespace warpscope
