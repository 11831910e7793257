// OpenGL contexts without a window: one platform at a time, and each in its turn.
// Mirrors render/gl/context.h.
#include "render/gl/context.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/core/error.h"
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

}  // namespace
}  // namespace warpscope
