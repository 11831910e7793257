// A picture on a plane against the plane itself, seen by rays in double; and a camera that is only turned.
// Mirrors render/warp/rotate_warp.h, and the plane of render/warp/rotated_picture.h.
#include <gtest/gtest.h>

#include "marcher_cases.h"
#include "render/metrics/psnr.h"
#include "render/warp/rotate_warp.h"
#include "render/warp/rotated_picture.h"
#include "warp_cases.h"

namespace warpscope {
namespace {

WarpSettings onPlane(PicturePlane plane) {
  WarpSettings settings;
  settings.knobs.set(kPicturePlaneKnob, plane);
  return settings;
}

TEST(RotateWarp, ThePictureIsAPlaneThroughTheMiddleOfTheVolume) {
  const Stage stage(smallScene("block", 32));
  const Camera server = stage.camera(160, 120);
  const SampleFramePtr frame = stage.frame(server, stage.scene().march);
  const WarpedImage own = ownImageOf(*frame);
  const double depth = glm::dot(glm::dvec3(frame->quantization.bounds.center()) - glm::dvec3(server.eye), glm::dvec3(server.forward));
  const double edge = static_cast<double>(pixelEdge(server));
  for (const double turn : {0.0, 3.0, 30.0, 80.0, 100.0, 170.0, 180.0}) {
    const Camera camera = stage.camera(97, 83, turn);
    const WarpedImage image = stage.draw("rotate", frame, camera);
    size_t seen = 0;
    for (uint32_t y = 0; y < camera.height; ++y)
      for (uint32_t x = 0; x < camera.width; ++x) {
        // Where the pixel's ray meets the plane, and where the server saw that.
        const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
        const glm::dvec3 direction(ray.direction), offset = glm::dvec3(camera.eye) - glm::dvec3(server.eye), forward(server.forward);
        const double t = (depth - glm::dot(offset, forward)) / glm::dot(direction, forward);
        const glm::dvec3 point = offset + t * direction;
        const double column = 80.0 + glm::dot(point, glm::dvec3(server.right)) / (depth * edge), row = 60.0 - glm::dot(point, glm::dvec3(server.up)) / (depth * edge);
        constexpr double kBorder = 1e-3;  // decided by rounding
        if (!(t > 0.0) || column < -kBorder || row < -kBorder || column > 160.0 + kBorder || row > 120.0 + kBorder) {
          ASSERT_EQ(image.samples(x, y), kNoSample) << turn << ": " << x << ", " << y;
          continue;
        }
        // All four centres about the place are of one sample's kind, or the place is close to a border.
        const auto at = [&](double u, double v) {
          return own.color(static_cast<uint32_t>(std::clamp(u, 0.0, 159.0)), static_cast<uint32_t>(std::clamp(v, 0.0, 119.0)));
        };
        const double u = std::floor(column - 0.5), v = std::floor(row - 0.5), a = column - 0.5 - u, b = row - 0.5 - v;
        if (column < kBorder || row < kBorder || column > 160.0 - kBorder || row > 120.0 - kBorder) continue;
        const glm::dvec4 expected = (1 - b) * ((1 - a) * glm::dvec4(at(u, v)) + a * glm::dvec4(at(u + 1, v))) +
                                    b * ((1 - a) * glm::dvec4(at(u, v + 1)) + a * glm::dvec4(at(u + 1, v + 1)));
        for (int channel = 0; channel < 4; ++channel) ASSERT_NEAR(image.color(x, y)[channel], expected[channel], 3e-3) << turn << ": " << x << ", " << y;
        seen += expected.a > 0.0;
      }
    EXPECT_GT(seen, turn == 80.0 || turn == 100.0 ? 50u : 500u) << turn;
  }
}

TEST(RotateWarp, AtInfinityOnlyTurningChangesAnything) {
  const Stage stage(smallScene("block", 32));
  const Camera server = stage.camera(160, 120);
  const SampleFramePtr frame = stage.frame(server, stage.scene().march);
  Camera moved = server;
  moved.eye += 3.0f * server.right - 2.0f * server.forward;
  const WarpSettings infinity = onPlane(PicturePlane::infinity);
  const WarpedImage own = stage.draw("hold", frame, server);
  EXPECT_EQ(stage.draw("rotate", frame, moved, infinity).color, own.color);
  EXPECT_NE(stage.draw("rotate", frame, moved).color, own.color) << "a plane that is near moves";
  EXPECT_EQ(stage.draw("rotate", frame, server).samples, own.samples);
  EXPECT_EQ(stage.draw("rotate", frame, server, infinity).samples, own.samples);
  // Turned about its eye, the camera sees the volume as marching shows it.
  Camera turned = lookingFrom(server.eye, frame->quantization.bounds.center() + glm::vec3(2.0f, 1.0f, 0.0f), 160, 120, server.tanHalfFovY);
  Image<glm::vec4> reference;
  stage.marcher().render(turned, stage.scene().march.render, reference);
  EXPECT_GT(psnrSrgb(stage.draw("rotate", frame, turned, infinity).color, reference, glm::vec3(0.0f)), 30.0);
}

}  // namespace
}  // namespace warpscope
