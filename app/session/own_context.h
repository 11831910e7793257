// An OpenGL context of a worker's own, made when it is first needed.
#pragma once

#include <functional>
#include <memory>

#include "render/gl/context.h"

namespace warpscope {

/// For WarpResources: called and destroyed on one thread. All copies have one context, in which techniques' objects are.
inline std::function<gl::Context&()> makeOwnContext(gl::Platform platform) {
  return [platform, context = std::make_shared<std::unique_ptr<gl::Context>>()]() -> gl::Context& {
    if (!*context) *context = gl::makeHeadlessContext(platform);
    return **context;
  };
}

}  // namespace warpscope
