// The two real volumes, upright and the right way round: their silhouettes against a ray caster that shares nothing with the program.
// It reads the files by itself, stays in double and in world space (NIfTI: right, anterior, superior), and places the camera by what
// scene.h documents. Data sets are no part of the repository; without them these tests are skipped.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "render/metrics/psnr.h"
#include "tests/headless.h"
#include "tests/real_data.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using glm::dvec3;

constexpr uint32_t kSide = 96;

/// A volume of bytes as its file means it.
struct PlainVolume {
  glm::ivec3 dims;
  std::vector<uint8_t> voxels;
  glm::dmat4 worldFromIndex{1.0};  ///< index (0, 0, 0) is the first voxel's centre
  dvec3 up, front;                 ///< world directions: up in the picture; from the volume to the camera

  double at(const dvec3& index) const {
    const glm::ivec3 low(glm::floor(index));
    const dvec3 f = index - dvec3(low);
    double value = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const glm::ivec3 offset(corner & 1, corner >> 1 & 1, corner >> 2);
      const glm::ivec3 p = glm::clamp(low + offset, glm::ivec3(0), dims - 1);
      const dvec3 w = glm::mix(1.0 - f, f, dvec3(offset));
      value += w.x * w.y * w.z * voxels[(static_cast<size_t>(p.z) * dims.y + p.y) * dims.x + p.x];
    }
    return value;
  }
};

/// Which pixels see anything above `threshold` for at least half a voxel, from a view as scene.h describes it.
Image<uint8_t> silhouette(const PlainVolume& volume, const View& view, double fovYDeg, double threshold) {
  const auto radians = [](double degrees) { return degrees * std::numbers::pi / 180.0; };
  const dvec3 first(volume.worldFromIndex * glm::dvec4(-0.5, -0.5, -0.5, 1.0));
  const dvec3 last(volume.worldFromIndex * glm::dvec4(dvec3(volume.dims) - 0.5, 1.0));
  const dvec3 center = 0.5 * (first + last);
  const double radius = 0.5 * glm::length(last - first);
  const double distance = view.distance * radius / std::sin(radians(0.5 * fovYDeg));
  // A camera in front of a thing has on its right what, seen along `up`, lies a quarter turn from the front.
  const dvec3 side = glm::cross(volume.up, volume.front);
  const double a = radians(view.angleDeg), e = radians(view.elevationDeg);
  const dvec3 horizontal = std::cos(a) * volume.front + std::sin(a) * side;
  const dvec3 backward = std::cos(e) * horizontal + std::sin(e) * volume.up;
  const dvec3 eye = center + distance * backward;
  const dvec3 right = glm::normalize(glm::cross(volume.up, backward));
  const dvec3 cameraUp = glm::cross(backward, right);

  const glm::dmat4 indexFromWorld = glm::inverse(volume.worldFromIndex);
  const double step = 0.25 * glm::length(dvec3(volume.worldFromIndex[0]));
  Image<uint8_t> mask(kSide, kSide);
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      const double half = std::tan(radians(0.5 * fovYDeg));
      const double u = (2.0 * (x + 0.5) / kSide - 1.0) * half, v = (1.0 - 2.0 * (y + 0.5) / kSide) * half;
      const dvec3 direction = glm::normalize(u * right + v * cameraUp - backward);
      int run = 0;
      for (double t = distance - radius; t < distance + radius && run < 2; t += step) {
        const dvec3 index(indexFromWorld * glm::dvec4(eye + t * direction, 1.0));
        const bool isInside = glm::all(glm::greaterThan(index, dvec3(-0.5))) && glm::all(glm::lessThan(index, dvec3(volume.dims) - 0.5));
        run = isInside && volume.at(index) > threshold ? run + 1 : 0;
      }
      mask(x, y) = run >= 2;
    }
  return mask;
}

/// What the program shows of the same: everything above the threshold is nearly opaque.
Image<uint8_t> programsSilhouette(Scene scene, const View& view, double threshold) {
  scene.transferFunction.points = {{threshold, glm::vec3(1.0f), 0.0f}, {threshold, glm::vec3(1.0f), 0.95f}};
  const Stage stage(scene);
  Image<glm::vec4> image;
  stage.marcher().render(makeCamera(scene, view, kSide, kSide), {}, image);
  Image<uint8_t> mask(kSide, kSide);
  for (size_t i = 0; i < image.size(); ++i) mask[i] = image[i].a > 0.5f;
  return mask;
}

double overlap(const Image<uint8_t>& a, const Image<uint8_t>& b, bool mirrored = false, bool upsideDown = false) {
  size_t both = 0, any = 0;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) {
      const bool inA = a(x, y) != 0, inB = b(mirrored ? kSide - 1 - x : x, upsideDown ? kSide - 1 - y : y) != 0;
      both += inA && inB;
      any += inA || inB;
    }
  return static_cast<double>(both) / static_cast<double>(any);
}

/// The program's silhouette is the oracle's, and is not it when mirrored or upside down.
void expectRightWayRound(const Scene& scene, const PlainVolume& volume, double threshold) {
  for (const View& view : {View{30.0, 20.0, 0.8}, View{110.0, -15.0, 0.9}, View{-70.0, 40.0, 1.0}}) {
    SCOPED_TRACE("angle " + std::to_string(view.angleDeg));
    const Image<uint8_t> expected = silhouette(volume, view, scene.fovYDeg, threshold);
    const Image<uint8_t> seen = programsSilhouette(scene, view, threshold);
    EXPECT_GT(overlap(seen, expected), 0.985);
    EXPECT_LT(overlap(seen, expected, true, false), 0.95) << "the view cannot tell left from right";
    EXPECT_LT(overlap(seen, expected, false, true), 0.95) << "the view cannot tell up from down";
  }
}

TEST(RealVolume, EngineIsTheRightWayRound) {
  const RealData engine("engine_256x256x128_uint8.raw");
  if (!engine.whyMissing().empty()) GTEST_SKIP() << engine.whyMissing();
  PlainVolume volume{{256, 256, 128}, std::vector<uint8_t>(256 * 256 * 128), glm::dmat4(1.0), {0, 1, 0}, {0, 0, 1}};
  std::ifstream(engine.path(), std::ios::binary).read(reinterpret_cast<char*>(volume.voxels.data()), static_cast<std::streamsize>(volume.voxels.size()));
  expectRightWayRound(openScene(engine.path().string()), volume, 90.0);
}

/// The paper's finding on the paper's volume: at ten degrees spheres are at least as good as points of two pixels.
TEST(RealVolume, SpheresAreAtLeastAsGoodAsPointsOnTheEngine) {
  const RealData engine("engine_256x256x128_uint8.raw");
  if (!engine.whyMissing().empty()) GTEST_SKIP() << engine.whyMissing();
  const Stage stage(openScene(engine.path().string()));
  const SampleFramePtr frame = stage.frame(stage.camera(640, 640), stage.scene().march);
  const Camera turned = stage.camera(640, 640, 10.0);
  Image<glm::vec4> reference;
  stage.marcher().render(turned, stage.scene().march.render, reference);
  const auto psnrDb = [&](std::string_view technique) {
    return psnrSrgb(stage.draw(technique, frame, turned).color, reference, stage.scene().background);
  };
  const double spheres = psnrDb("spheres");
  EXPECT_GE(spheres, psnrDb("points"));
  EXPECT_GT(spheres, psnrDb("hold"));
}

#if WARPSCOPE_WITH_ITK
/// A NIfTI-1 file as it stands, decompressed.
std::string inflated(const fs::path& path) {
  std::string bytes;
  const gzFile file = gzopen(path.string().c_str(), "rb");
  std::vector<char> piece(1 << 20);
  for (int got; (got = gzread(file, piece.data(), static_cast<unsigned>(piece.size()))) > 0;) bytes.append(piece.data(), static_cast<size_t>(got));
  gzclose(file);
  return bytes;
}

template <class T>
T fieldAt(const std::string& bytes, size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST(RealVolume, BrainIsTheRightWayRound) {
  const RealData brain("spm152.nii.gz");
  if (!brain.whyMissing().empty()) GTEST_SKIP() << brain.whyMissing();
  std::string bytes = inflated(brain.path());
  ASSERT_EQ(fieldAt<int32_t>(bytes, 0), 348);
  ASSERT_EQ(fieldAt<int16_t>(bytes, 70), 2) << "unsigned bytes";
  ASSERT_GT(fieldAt<int16_t>(bytes, 254), 0) << "sform_code: the file states an orientation matrix";
  PlainVolume volume;
  for (int axis = 0; axis < 3; ++axis) {
    volume.dims[axis] = fieldAt<int16_t>(bytes, 42 + 2 * static_cast<size_t>(axis));
    for (int column = 0; column < 4; ++column)  // srow_x, srow_y, srow_z: rows of the matrix to right, anterior, superior
      volume.worldFromIndex[column][axis] = fieldAt<float>(bytes, 280 + 16 * static_cast<size_t>(axis) + 4 * static_cast<size_t>(column));
  }
  volume.up = {0.0, 0.0, 1.0};     // superior
  volume.front = {0.0, 1.0, 0.0};  // the face looks at the camera
  const auto first = static_cast<size_t>(fieldAt<float>(bytes, 108));
  const size_t count = static_cast<size_t>(volume.dims.x) * volume.dims.y * volume.dims.z;
  ASSERT_EQ(bytes.size(), first + count);

  // A brain is its own mirror image, nearly: without its right half and what lies low in front it is not.
  for (int z = 0, i = 0; z < volume.dims.z; ++z)
    for (int y = 0; y < volume.dims.y; ++y)
      for (int x = 0; x < volume.dims.x; ++x, ++i) {
        const dvec3 world(volume.worldFromIndex * glm::dvec4(x, y, z, 1.0));
        if (world.x > 5.0 || (world.y > 20.0 && world.z < 0.0)) bytes[first + static_cast<size_t>(i)] = 0;
      }
  volume.voxels.assign(bytes.begin() + static_cast<ptrdiff_t>(first), bytes.end());
  const TestFolder folder;
  const Scene scene = openScene(folder.write("left.nii", bytes));
  EXPECT_EQ(scene.volume->dims(), glm::uvec3(volume.dims));
  expectRightWayRound(scene, volume, 90.0);

  // In words: seen from the front, what is left of the patient is right in the picture.
  const Image<uint8_t> seen = programsSilhouette(scene, View{0.0, 0.0, 0.9}, 90.0);
  size_t leftHalf = 0, rightHalf = 0;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x) (x < kSide / 2 ? leftHalf : rightHalf) += seen(x, y);
  EXPECT_GT(rightHalf, 5 * leftHalf);
}
#endif

}  // namespace
}  // namespace warpscope
