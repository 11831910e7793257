// OpenGL contexts without a window: one platform at a time, each in its turn, and destructors that survive a driver which refuses.
// Mirrors render/gl/context.h.
#include "render/gl/context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/base/error.h"
#include "render/warp/points_warp.h"
#include "tests/headless.h"

namespace warpscope {
namespace {

using gl::Platform;

gl::Platform otherThan(Platform platform) { return platform == Platform::egl ? Platform::osmesa : Platform::egl; }

/// True if the current context answers.
bool canDraw() {
  GLuint name = 0;
  glCreateBuffers(1, &name);
  const bool isThere = glIsBuffer(name) == GL_TRUE;
  glDeleteBuffers(1, &name);
  return isThere && glGetError() == GL_NO_ERROR;
}

class Contexts : public OnPlatform {};
INSTANTIATE_TEST_SUITE_P(Gl, Contexts, bothPlatforms(), platformName);

TEST_P(Contexts, AnotherPlatformIsRefusedWhileOneLives) {
  const auto first = gl::makeHeadlessContext(GetParam());
  const auto second = gl::makeHeadlessContext(GetParam());  // more of the same are welcome
  try {
    gl::makeHeadlessContext(otherThan(GetParam()));
    FAIL() << "two platforms at once";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("are alive in this process"));
  }
  for (const auto& context : {first.get(), second.get()}) {
    context->makeCurrent();
    EXPECT_TRUE(canDraw());
  }
}

TEST_P(Contexts, PlatformsTakeTurns) {
  for (const Platform platform : {GetParam(), otherThan(GetParam()), GetParam()}) {
    const auto context = gl::makeHeadlessContext(platform);
    EXPECT_EQ(context->platformName() == "OSMesa", platform == Platform::osmesa);
    EXPECT_NE(context->renderer(), "?");
    EXPECT_TRUE(canDraw());
  }
}

/// A lookup that knows nothing, as of a driver without OpenGL.
GLADapiproc findNothing(const char*) { return nullptr; }

TEST_P(Contexts, AFailedLoadDoesNotStay) {
  {
    gl::EntryPoints none(findNothing, "nothing");
    EXPECT_THROW(none.load(), InputError);
    EXPECT_THROW(none.load(), InputError) << "the failure was taken for a success";
    EXPECT_THROW(gl::makeHeadlessContext(GetParam()), InputError);
  }
  const auto context = gl::makeHeadlessContext(GetParam());
  EXPECT_TRUE(canDraw());
}

/// A context whose driver can be told to refuse.
class StubbornContext final : public gl::Context {
 public:
  explicit StubbornContext(Platform platform) : context_(gl::makeHeadlessContext(platform)) {}
  void makeCurrent() override {
    if (refuses) throw InputError("no");
    context_->makeCurrent();
  }
  std::string_view platformName() const override { return context_->platformName(); }

  bool refuses = false;

 private:
  std::unique_ptr<gl::Context> context_;
};

TEST_P(Contexts, ATechniqueGoesThoughItsContextCannotBeMadeCurrent) {
  StubbornContext context(GetParam());
  WarpResources resources;
  resources.context = [&]() -> gl::Context& { return context; };
  const auto programs = [] {
    int count = 0;
    for (GLuint name = 1; name < 64; ++name) count += glIsProgram(name);
    return count;
  };
  EXPECT_TRUE(context.tryMakeCurrent());
  const int before = programs();
  std::unique_ptr<Warp> warp = makeWarp(findWarp("points"), resources);
  EXPECT_EQ(programs(), before + 1);
  warp.reset();
  EXPECT_EQ(programs(), before);

  // Names that may be another context's by now are left alone.
  warp = makeWarp(findWarp("points"), resources);
  context.refuses = true;
  EXPECT_FALSE(context.tryMakeCurrent());
  warp.reset();
  EXPECT_EQ(programs(), before + 1);
}

}  // namespace
}  // namespace warpscope
