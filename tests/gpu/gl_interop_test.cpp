// Device pictures in OpenGL textures, through interop and read back by OpenGL; what is refused.
// Mirrors render/cuda/gl_interop.h.
#include "render/cuda/gl_interop.h"

#include <gtest/gtest.h>

#include "render/base/error.h"
#include "render/cuda/devices.h"
#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "render/warp/splats_warp_cuda.h"
#include "tests/frame_samples.h"
#include "tests/gpu/agreement.h"
#include "tests/sphere_clouds.h"

namespace warpscope {
namespace {

std::vector<Rgba8> pixelsOf(const DevicePicture& picture) {
  std::vector<Rgba8> pixels(size_t{picture.width()} * picture.height());
  picture.download(pixels);
  return pixels;
}

SampleFramePtr cloudFrame() {
  auto frame = std::make_shared<SampleFrame>(frameOfCloud(makeCloud(CloudShape::random, 2000, 100.0f, 9)));
  for (size_t i = 0; i < frame->size(); ++i) frame->colors[i] = static_cast<Rgba8>(0xff000000u | (i * 2654435761u >> 8));
  return frame;
}

TEST(GlInterop, TexturesShowThePicture) {
  WARPSCOPE_NEEDS_GPU();
  const std::unique_ptr<gl::Context> context = gl::makeHeadlessContext(gl::Platform::egl);
  context->makeCurrent();
  const std::string reason = cuda::whyNoInterop();
  if (!reason.empty()) GTEST_SKIP() << "no interop here: " << reason << "; OpenGL is " << context->renderer();
  const std::unique_ptr<Warp> warp = makeCudaSplatsWarp();
  warp->setFrame(cloudFrame(), {});
  const gl::Texture texture = gl::makeTexture2D(GL_RGBA8, 193, 161);
  cuda::InteropTexture interop(texture.name(), 193, 161);
  for (const float angle : {0.0f, 40.0f}) {
    const DevicePicturePtr picture = warp->drawForScreen(orbitCamera(300.0f, angle, 193, 161), {}, glm::vec3(0.2f), {});
    ASSERT_NE(picture, nullptr);
    interop.show(*picture);
    const std::vector<Rgba8> expected = pixelsOf(*picture);
    std::vector<Rgba8> seen(expected.size());
    glGetTextureImage(texture.name(), 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(seen.size() * sizeof(Rgba8)), seen.data());
    EXPECT_EQ(seen, expected);
  }
  const DevicePicturePtr other = warp->drawForScreen(orbitCamera(300.0f, 0.0f, 64, 64), {}, glm::vec3(0.2f), {});
  EXPECT_THROW(interop.show(*other), InputError);
}

TEST(GlInterop, ATextureThatIsNoneIsRefused) {
  WARPSCOPE_NEEDS_GPU();
  const std::unique_ptr<gl::Context> context = gl::makeHeadlessContext(gl::Platform::egl);
  context->makeCurrent();
  if (!cuda::whyNoInterop().empty()) GTEST_SKIP() << "no interop here: " << cuda::whyNoInterop();
  EXPECT_THROW(cuda::InteropTexture(4711, 16, 16), DeviceError);
}

}  // namespace
}  // namespace warpscope
