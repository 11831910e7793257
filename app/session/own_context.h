// An OpenGL context of a worker's own, made when it is first needed.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "render/gl/context.h"

namespace warpscope {

/// For WarpResources: called and destroyed on one thread. All copies have one context, in which techniques' objects are. `onMade` is called with it once.
inline std::function<gl::Context&()> makeOwnContext(gl::Platform platform, std::function<void(const gl::Context&)> onMade = {}) {
  return [platform, onMade = std::move(onMade), context = std::make_shared<std::unique_ptr<gl::Context>>()]() -> gl::Context& {
    if (!*context) {
      *context = gl::makeHeadlessContext(platform);
      if (onMade) onMade(**context);
    }
    return **context;
  };
}

}  // namespace warpscope
