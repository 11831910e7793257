// The frame's samples as OpenGL sprites: as large as each sphere is seen, every fragment at the depth where its ray enters the sphere.
// Discussed as variable sizes and geometry shaders by Zellmann 2020; the bounds are those of Mara, McGuire 2013. A sprite is two triangles instead of a
// GL_POINT: those have a largest size, and vanish with their centre.
#pragma once

#include "render/warp/warp.h"

namespace warpscope {

extern const WarpDescriptor kSpritesWarp;

}  // namespace warpscope
