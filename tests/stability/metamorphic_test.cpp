// What must change nothing, or no more than is said here: the same scene elsewhere, in another unit, along other axes, from samples in another
// order, from rays in pieces, on other numbers of threads, by another OpenGL, for another processor. Pictures of all techniques, on the CPU.
// Metamorphic testing: Chen, Cheung, Yiu 1998. tests/README.md lists the relations ("What changes nothing").
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "render/core/color.h"
#include "render/core/ray_sphere.h"
#include "render/gl/context.h"
#include "render/march/march_setup.h"
#include "render/march/ray_samples.h"
#include "render/march/volume_source_scalar.h"
#include "render/volume/volume.h"
#include "render/warp/warp.h"
#include "tests/frame_samples.h"
#include "tests/heuristic_cases.h"
#include "tests/marcher_cases.h"
#include "tests/test_volumes.h"

namespace warpscope {
namespace {

constexpr uint32_t kWidth = 61, kHeight = 47;  // no multiples of a tile's or a vector's
const glm::uvec3 kDims(24, 20, 16);

/// Translucent matter with an opaque core, in colours that differ along the values.
TransferFunction matter() {
  return {{{5.0, {1.0f, 0.3f, 0.1f}, 0.0f}, {30.0, {0.9f, 0.8f, 0.2f}, 0.1f}, {70.0, {0.1f, 0.6f, 1.0f}, 0.6f}, {95.0, {0.2f, 0.2f, 0.3f}, 1.0f}}};
}

Camera serverCamera() { return lookingFrom({25.0f, 14.0f, 31.0f}, {0.5f, -0.5f, 1.0f}, kWidth, kHeight); }
Camera clientCamera() { return lookingFrom({31.0f, 8.0f, 22.0f}, {-0.5f, 0.5f, 0.0f}, kWidth + 6, kHeight + 4); }

VolumeGeometry geometryOf(const glm::dvec3& spacing, const glm::dvec3& origin = glm::dvec3(0.0)) {
  VolumeGeometry geometry;
  geometry.dims = kDims;
  geometry.spacing = spacing;
  geometry.origin = origin;
  return geometry;
}

/// A context for this thread, of one platform at a time.
class Drawing {
 public:
  explicit Drawing(MarcherPtr marcher, gl::Platform platform = gl::Platform::automatic) {
    resources_.marcher = std::move(marcher);
    resources_.backend = Backend::cpu;
    resources_.context = [this, platform]() -> gl::Context& {
      if (!context_) context_ = gl::makeHeadlessContext(platform);
      context_->makeCurrent();
      return *context_;
    };
  }

  WarpedImage draw(const WarpDescriptor& technique, const SampleFramePtr& frame, const Camera& camera) const {
#if defined(WARPSCOPE_TRAPS)
    // OpenGL's own arithmetic traps in Mesa's threads: something that stays the same stands for its pictures.
    if (technique.usesOpenGl) return draw(findWarp("hold"), frame, camera);
#endif
    const std::unique_ptr<Warp> warp = makeWarp(technique, resources_);
    const WarpSettings settings;
    warp->setFrame(frame, settings);
    WarpedImage image;
    warp->draw(camera, settings, image);
    return image;
  }

 private:
  std::unique_ptr<gl::Context> context_;
  WarpResources resources_;
};

/// A frame and what every technique makes of it for the client's camera, in the registry's order.
struct Outcome {
  SampleFramePtr frame;
  std::vector<WarpedImage> pictures;
};

Outcome outcomeOf(const VolumePtr& volume, const Camera& server, const Camera& client, const MarchSettings& settings = {}) {
  const MarcherPtr marcher = makeCpuMarcher(volume, matter());
  const Drawing drawing(marcher);
  MarchSettings withSegments = settings;
  withSegments.sample.segments = 3;
  Outcome outcome{std::make_shared<SampleFrame>(marcher->march(server, withSegments)), {}};
  for (const WarpDescriptor& technique : warpRegistry()) outcome.pictures.push_back(drawing.draw(technique, outcome.frame, client));
  return outcome;
}

Outcome outcomeOf(const VolumeGeometry& geometry, const MarchSettings& settings = {}) {
  return outcomeOf(makeTestVolume(VoxelType::uint8, geometry, blobs(kDims, 46)), serverCamera(), clientCamera(), settings);
}

size_t coveredPixels(const WarpedImage& image) {
  return static_cast<size_t>(std::count_if(image.color.begin(), image.color.end(), [](const glm::vec4& color) { return color.a > 0.0f; }));
}

void expectSame(const Outcome& a, const Outcome& b) {
  ASSERT_GT(a.frame->size(), 400u);
  EXPECT_TRUE(sameFrame(*a.frame, *b.frame));
  for (size_t i = 0; i < warpRegistry().size(); ++i) {
    SCOPED_TRACE(warpRegistry()[i].name);
    if (warpRegistry()[i].name == "proxy") continue;  // these frames have none
    EXPECT_GT(coveredPixels(a.pictures[i]), 400u);
    EXPECT_EQ(a.pictures[i].samples, b.pictures[i].samples);
    EXPECT_TRUE(sameBits(a.pictures[i].color, b.pictures[i].color));
  }
}

// How much may change where rounding may; with what was found.
constexpr float kTurnedColor = 3e-4f;      ///< found 2.0e-4
constexpr float kTurnedEvenColor = 2e-6f;
constexpr double kTurnedDepth = 5e-4;      ///< in voxels; found 1.9e-4
constexpr size_t kTurnedPixels = 0;
constexpr float kOnePieceColor = 0.0f;
constexpr float kPiecesColor = 1e-6f;
constexpr float kPiecesDepth = 1e-5f;      ///< in voxels, beyond half a step of depth codes
constexpr size_t kPiecesRays = 0;
constexpr size_t kOtherGlPixels = 0;
constexpr uint64_t kSamplesFingerprint = 0x54d462d793539dc7, kColorsFingerprint = 2197309016990898340ull;
constexpr std::pair<std::string_view, uint64_t> kFingerprints[] = {
    {"reference", 0x469c682cce881d2a}, {"hold", 0x786667ce1e3e4100},     {"spheres", 0x33c0d9de4a69f05b},
    {"rotate", 0xc02c12e4eb14120a},    {"splats", 0x33c0d9de4a69f05b}, {"multihit", 0x1e4db011a741c953}, {"segments", 0xacfe26d08249542b},
};

TEST(Metamorphic, PlaceAndUnitOfTheWorldChangeNothing) {
  for (const glm::dvec3& spacing : {glm::dvec3(1.0), glm::dvec3(1.0, 1.5, 4.0)}) {
    const Outcome plain = outcomeOf(geometryOf(spacing));
    for (const glm::dvec3& origin : {glm::dvec3(0.0), glm::dvec3(1e7, -1e7, 1e7)})
      for (const double unit : {1.0, 0x1p-30, 0x1p30, 1e-9}) {
        SCOPED_TRACE("origin " + std::to_string(origin.x) + ", unit " + std::to_string(unit));
        expectSame(plain, outcomeOf(geometryOf(spacing * unit, origin)));
      }
  }
}

/// The frame with all lengths `scale` times as long.
SampleFramePtr scaled(const SampleFrame& frame, float scale) {
  auto other = std::make_shared<SampleFrame>(frame);
  other->camera.eye *= scale;
  other->voxelRadius *= scale;
  SampleQuantization& q = other->quantization;
  q.bounds = {q.bounds.lower * scale, q.bounds.upper * scale};
  q.nearDepth *= scale;
  q.depthStep *= scale;
  q.radiusUnit *= scale;
  return other;
}

TEST(Metamorphic, FramesInAnotherUnitMakeTheSamePictures) {
  const Outcome plain = outcomeOf(geometryOf(glm::dvec3(1.0)));
  const Drawing drawing(makeCpuMarcher(makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 46)), matter()));
  for (const float scale : {0x1p-30f, 0x1p-1f, 0x1p1f, 0x1p30f}) {
    const SampleFramePtr frame = scaled(*plain.frame, scale);
    Camera client = clientCamera();
    client.eye *= scale;
    for (size_t i = 0; i < warpRegistry().size(); ++i) {
      const WarpDescriptor& technique = warpRegistry()[i];
      if (!technique.usesFrame) continue;
      // Both are clipped at a thousandth of a voxel in front of the eye, which in such a unit is far behind all of them.
      if ((technique.name == "points" || technique.name == "mesh") && scale == 0x1p-30f) continue;
      SCOPED_TRACE(std::string(technique.name) + " times " + std::to_string(scale));
      EXPECT_EQ(drawing.draw(technique, frame, client).samples, plain.pictures[i].samples);
    }
  }
}

/// Where axes go, and which of them turn round.
struct Turn {
  std::array<int, 3> from;  ///< axis i of the turned scene is axis from[i] of the other
  std::array<bool, 3> mirrored;

  glm::vec3 operator()(const glm::vec3& v) const {
    glm::vec3 turned;
    for (int i = 0; i < 3; ++i) turned[i] = mirrored[static_cast<size_t>(i)] ? -v[from[static_cast<size_t>(i)]] : v[from[static_cast<size_t>(i)]];
    return turned;
  }
  Camera operator()(Camera camera) const {
    camera.eye = (*this)(camera.eye);
    camera.right = (*this)(camera.right);
    camera.up = (*this)(camera.up);
    camera.forward = (*this)(camera.forward);
    return camera;
  }
  VolumePtr operator()(const glm::dvec3& spacing) const {
    VolumeGeometry geometry;
    for (int i = 0; i < 3; ++i) {
      geometry.dims[i] = kDims[from[static_cast<size_t>(i)]];
      geometry.spacing[i] = spacing[from[static_cast<size_t>(i)]];
    }
    const FieldFunction field = blobs(kDims, 46);
    return makeTestVolume(VoxelType::uint8, geometry, [&](const glm::ivec3& turned) {
      glm::ivec3 p;
      for (int i = 0; i < 3; ++i)
        p[from[static_cast<size_t>(i)]] = mirrored[static_cast<size_t>(i)] ? static_cast<int>(geometry.dims[i]) - 1 - turned[i] : turned[i];
      return field(p);
    });
  }
};

std::vector<Turn> everyTurn() {
  std::vector<Turn> turns;
  std::array<int, 3> axes{0, 1, 2};
  do
    for (unsigned bits = 0; bits < 8; ++bits) turns.push_back({axes, {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0}});
  while (std::next_permutation(axes.begin(), axes.end()));
  return turns;
}

/// How two pictures differ.
struct Difference {
  float largest = 0.0f;  ///< of colours
  size_t beyond = 0;     ///< pixels whose colours differ by more than half a code of 8 bits
};

Difference differenceOf(const Image<glm::vec4>& a, const Image<glm::vec4>& b) {
  Difference difference;
  for (size_t i = 0; i < a.size(); ++i) {
    const glm::vec4 apart = glm::abs(a[i] - b[i]);
    const float largest = std::max({apart.r, apart.g, apart.b, apart.a});
    difference.largest = std::max(difference.largest, largest);
    difference.beyond += largest > 0.5f / 255.0f;
  }
  return difference;
}

/// For each pixel the sample's depth code, or nothing.
std::vector<std::optional<uint32_t>> depthsOf(const SampleFrame& frame) {
  std::vector<std::optional<uint32_t>> depths(size_t{frame.camera.width} * frame.camera.height);
  for (const PackedSample sample : frame.samples) depths[size_t{rowOf(sample)} * frame.camera.width + columnOf(sample)] = depthCode(sample);
  return depths;
}

/// Along the camera's axis.
double depthOf(const SampleFrame& frame, uint32_t code) {
  return static_cast<double>(frame.quantization.nearDepth) + static_cast<double>(decodeDepth(code, frame.quantization.depthStep));
}

TEST(Metamorphic, TurnedAndMirroredAxesChangeRoundingAlone) {
  // Sums over axes are added up in another order, and interpolation goes the other way.
  const glm::dvec3 spacing(1.0, 1.5, 2.0);
  const Turn none{{0, 1, 2}, {false, false, false}};
  const Outcome plain = outcomeOf(none(spacing), serverCamera(), clientCamera());
  const auto depths = depthsOf(*plain.frame);
  ASSERT_GT(plain.frame->size(), 500u);
  // To the ray's end: where hardly any light is left may be decided on one side or the other of a threshold. Matter of one opacity shows the
  // lengths of rays alone; other matter, that a value next to the border of two bins of the transfer function's table may fall into either.
  MarchSettings toTheEnd;
  toTheEnd.render.terminateEarly = false;
  const auto truthOf = [&](const Turn& turn, const TransferFunction& function) {
    return rendered(*makeCpuMarcher(turn(spacing), function), turn(clientCamera()), toTheEnd);
  };
  const Image<glm::vec4> truth = truthOf(none, matter()), even = truthOf(none, everywhere(0.1f));
  const std::vector<Turn> turns = everyTurn();
  ASSERT_EQ(turns.size(), 48u);
  for (const Turn& turn : turns) {
    SCOPED_TRACE("axes " + std::to_string(turn.from[0]) + std::to_string(turn.from[1]) + std::to_string(turn.from[2]) + ", mirrored " +
                 std::to_string(turn.mirrored[0]) + std::to_string(turn.mirrored[1]) + std::to_string(turn.mirrored[2]));
    EXPECT_LT(differenceOf(truth, truthOf(turn, matter())).largest, kTurnedColor);
    EXPECT_LT(differenceOf(even, truthOf(turn, everywhere(0.1f))).largest, kTurnedEvenColor);
    const Outcome turned = outcomeOf(turn(spacing), turn(serverCamera()), turn(clientCamera()));
    EXPECT_NEAR(turned.frame->quantization.nearDepth, plain.frame->quantization.nearDepth, 1e-4f);
    EXPECT_EQ(turned.frame->quantization.depthStep, plain.frame->quantization.depthStep);
    const auto turnedDepths = depthsOf(*turned.frame);
    for (size_t i = 0; i < depths.size(); ++i) {
      ASSERT_EQ(depths[i].has_value(), turnedDepths[i].has_value()) << i;
      if (depths[i]) ASSERT_NEAR(depthOf(*plain.frame, *depths[i]), depthOf(*turned.frame, *turnedDepths[i]), kTurnedDepth) << i;
    }
    for (size_t i = 0; i < warpRegistry().size(); ++i)
      EXPECT_LE(differenceOf(plain.pictures[i].color, turned.pictures[i].color).beyond, kTurnedPixels) << warpRegistry()[i].name;
  }
}

TEST(Metamorphic, TheOrderOfSamplesDecidesTiesAlone) {
  const Outcome plain = outcomeOf(geometryOf(glm::dvec3(1.0)));
  const SampleFrame& frame = *plain.frame;
  const Drawing drawing(makeCpuMarcher(makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 46)), matter()));
  const Camera client = clientCamera();
  for (uint32_t seed = 1; seed <= 3; ++seed) {
    std::vector<uint32_t> order(frame.size());  // of the shuffled frame's samples, where they were
    std::iota(order.begin(), order.end(), 0u);
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    auto shuffled = std::make_shared<SampleFrame>(frame);
    for (size_t i = 0; i < order.size(); ++i) {
      shuffled->samples[i] = frame.samples[order[i]];
      shuffled->colors[i] = frame.colors[order[i]];
    }
    for (size_t i = 0; i < warpRegistry().size(); ++i) {
      const WarpDescriptor& technique = warpRegistry()[i];
      if (!technique.usesFrame || technique.uses.segments || technique.uses.proxy || technique.name == "mesh") continue;  // whose pixels are not of one sample
      SCOPED_TRACE(std::string(warpRegistry()[i].name) + ", seed " + std::to_string(seed));
      const WarpedImage image = drawing.draw(warpRegistry()[i], shuffled, client);
      size_t ties = 0;
      for (uint32_t y = 0; y < client.height; ++y)
        for (uint32_t x = 0; x < client.width; ++x) {
          const uint32_t before = plain.pictures[i].samples(x, y), now = image.samples(x, y);
          ASSERT_EQ(before == kNoSample, now == kNoSample) << x << "," << y;
          if (before == kNoSample || order[now] == before) continue;
          ++ties;
          // Of two samples equally far along the pixel's ray the first in the frame is seen: points are as far as their forward depths.
          const Sphere a = sphereOf(frame, before), b = sphereOf(frame, order[now]);
          const Ray ray = pixelRay(client, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
          const bool isPoint = warpRegistry()[i].name == "points";
          const float depthA = isPoint ? project(client, a.center).forwardDepth : intersectSphere(ray, a.center, a.radius);
          const float depthB = isPoint ? project(client, b.center).forwardDepth : intersectSphere(ray, b.center, b.radius);
          ASSERT_NEAR(depthA, depthB, warpRegistry()[i].usesOpenGl ? 1e-5f * depthA : 0.0f) << x << "," << y;
        }
      EXPECT_LE(ties, 4u);
    }
  }
}

/// The pieces of a ray, each marched by itself and put together, as several machines would: light and the heuristic's depth.
template <class Depth>
RayState<Depth> marchedInPieces(const RayPath& path, const VolumeView<uint8_t>& view, const MarchSettings& settings, int pieces) {
  const auto source = [&] { return ScalarVolumeSource<uint8_t, false, false>(view, path.ray, path.lattice); };
  const auto cut = [&](int piece) { return static_cast<int>(int64_t{path.lattice.count} * piece / pieces); };
  const RayLimits limits = limitsOf(settings.render);
  RayState<Depth> whole;
  std::vector<Transmittance> inFront{Transmittance()};
  ProfileFold profile;
  std::vector<RayState<Depth>> states;
  for (int piece = 0; piece < pieces; ++piece) {
    auto first = source(), second = source();
    RayOpacity alone;
    marchRay(path, cut(piece), cut(piece + 1), first, Unlit{}, {limits.contribution, 0.0f}, alone, [](const CountingSample&) { return true; });
    states.push_back(marchPiece<Depth>(path, cut(piece), cut(piece + 1), second, Unlit{}, limits, settings.sample.threshold, inFront.back()));
    inFront.push_back(Transmittance(inFront.back().exact() * alone.transmittance.exact()));
    profile = ProfileFold::combine(profile, states.back().profile);
  }
  for (int piece = 0; piece < pieces; ++piece) {
    auto& state = states[static_cast<size_t>(piece)];
    if constexpr (Depth::kTwoPass) {
      auto again = source();
      state.fold = marchPieceAgain<Depth>(path, cut(piece), cut(piece + 1), again, Unlit{}, limits, settings.sample.threshold,
                                          inFront[static_cast<size_t>(piece)], profile);
    }
    whole = RayState<Depth>::combine(whole, state);
  }
  return whole;
}

class MetamorphicBy : public testing::TestWithParam<Heuristic> {};
INSTANTIATE_TEST_SUITE_P(Heuristics, MetamorphicBy, testing::ValuesIn(everyHeuristic()), heuristicCase);

TEST_P(MetamorphicBy, RaysInPiecesMakeTheSamePictureAndSamples) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 46));
  const MarcherPtr marcher = makeCpuMarcher(volume, matter());
  const MarchedVolume marched(volume, matter());
  MarchSettings settings;
  settings.sample.heuristic = GetParam();
  settings.render.step = 0.23f;
  const BakedTransfer baked = bakeTransfer(marched, settings.render);
  VolumeView<uint8_t> view = makeVolumeView<uint8_t>(marched);
  view.voxels = volume->voxelsAs<uint8_t>();
  view.transfer = baked.table.lookup();
  view.cells.distances = baked.emptyDistances.data();
  const Camera camera = serverCamera();
  const SampleFrame frame = marcher->march(camera, settings);
  const Image<glm::vec4> image = rendered(*marcher, camera, settings);
  const auto depths = depthsOf(frame);
  const PixelGrid pixels = makePixelGrid(camera, frame.quantization.nearDepth);
  const float depthStep = frame.quantization.depthStep;
  ASSERT_GT(frame.size(), 400u);
  for (int pieces = 1; pieces <= 7; ++pieces) {
    size_t otherDepths = 0;
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        const PixelRay pixel = pixels.ray(x, y);
        const RayPath path{pixel.ray, makeLattice(intersectBox(reciprocalOf(pixel.ray.origin, pixel.ray.direction), volume->bounds(), 0.0f, 1e30f),
                                                  settings.render.step)};
        visitHeuristic(GetParam(), [&](auto depth) {
          const auto state = marchedInPieces<decltype(depth)>(path, view, settings, pieces);
          const glm::vec4 apart = glm::abs(state.light.premultiplied() - image(x, y));
          ASSERT_LE(std::max({apart.r, apart.g, apart.b, apart.a}), pieces == 1 ? kOnePieceColor : kPiecesColor) << x << "," << y << " of " << pieces;
          const auto before = depths[size_t{y} * camera.width + x];
          ASSERT_EQ(state.depth().hasDepth, before.has_value()) << x << "," << y << " of " << pieces;
          if (before) otherDepths += std::abs(state.depth().depth * pixel.cosine - decodeDepth(*before, depthStep)) > 0.5f * depthStep + kPiecesDepth;
        });
        if (HasFatalFailure()) return;
      }
    EXPECT_LE(otherDepths, pieces == 1 ? 0u : kPiecesRays) << pieces << " pieces of " << frame.size();
  }
}

TEST(Metamorphic, TheNumberOfThreadsChangesNothing) {
  std::vector<Outcome> outcomes;
  for (const int threads : {1, 2, 16}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
    tbb::task_arena arena(threads);
    arena.execute([&] { outcomes.push_back(outcomeOf(geometryOf(glm::dvec3(1.0)))); });
    SCOPED_TRACE(threads);
    expectSame(outcomes.front(), outcomes.back());
  }
}

#if !defined(WARPSCOPE_TRAPS)
TEST(Metamorphic, BothOpenGlsDrawTheSamePoints) {
  const MarcherPtr marcher = makeCpuMarcher(makeTestVolume(VoxelType::uint8, kDims, blobs(kDims, 46)), matter());
  const auto frame = std::make_shared<SampleFrame>(marcher->march(serverCamera(), {}));
  std::vector<WarpedImage> images;
  for (const gl::Platform platform : {gl::Platform::egl, gl::Platform::osmesa})
    images.push_back(Drawing(marcher, platform).draw(findWarp("points"), frame, clientCamera()));
  EXPECT_GT(coveredPixels(images[0]), 400u);
  size_t other = 0;
  for (size_t i = 0; i < images[0].samples.size(); ++i) other += images[0].samples[i] != images[1].samples[i];
  EXPECT_LE(other, kOtherGlPixels);
}
#endif

/// FNV-1a over what is the same wherever a number has the same bits.
class Fingerprint {
 public:
  template <class Value>
  void add(const Value* values, size_t count) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(values);
    for (size_t i = 0; i < count * sizeof(Value); ++i) value_ = (value_ ^ bytes[i]) * 0x100000001b3ull;
  }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = 0xcbf29ce484222325ull;
};

TEST(Metamorphic, EveryProcessorAndCompilerMakesTheSameBits) {
  // These numbers come from every build: AVX-512 with fused multiply-add, plain x86-64 without, GCC, Clang, optimised or not. A change of what is
  // computed changes them: then they are to be the same again in every leg (tests/legs.sh).
#if !defined(__x86_64__)
  GTEST_SKIP() << "written down for x86-64";
#endif
  MarchSettings settings;
  settings.render.step = 0.37f;
  settings.sample.heuristic = Heuristic::expected;
  const Outcome outcome = outcomeOf(geometryOf(glm::dvec3(1.0, 1.5, 4.0)), settings);
  Fingerprint samples, colors;
  samples.add(outcome.frame->samples.data(), outcome.frame->size());
  colors.add(outcome.frame->colors.data(), outcome.frame->size());
  EXPECT_EQ(samples.value(), kSamplesFingerprint);
  EXPECT_EQ(colors.value(), kColorsFingerprint);
  for (size_t i = 0; i < warpRegistry().size(); ++i) {
    const WarpDescriptor& technique = warpRegistry()[i];
    if (technique.usesOpenGl) continue;  // another library's, and its processor's
    if (technique.name == "proxy") continue;  // these frames have none
    Fingerprint picture;
    picture.add(outcome.pictures[i].samples.data(), outcome.pictures[i].samples.size());
    picture.add(outcome.pictures[i].color.data(), outcome.pictures[i].color.size());
    const auto known = std::find_if(std::begin(kFingerprints), std::end(kFingerprints), [&](const auto& one) { return one.first == technique.name; });
    ASSERT_NE(known, std::end(kFingerprints)) << technique.name << " has no fingerprint yet: 0x" << std::hex << picture.value();
    EXPECT_EQ(picture.value(), known->second) << technique.name << ": 0x" << std::hex << picture.value();
  }
}

}  // namespace
}  // namespace warpscope
