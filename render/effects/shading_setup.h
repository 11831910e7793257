// From settings to what shading's formulas want: lights in volume space, the gradient that is noise. Host only.
// See shading.h.
#pragma once

#include "render/core/camera.h"
#include "render/effects/shading.h"
#include "render/volume/value_scale.h"
#include "render/volume/volume.h"

namespace warpscope {

/// For a picture of the volume, whose interpolants are those of `scale`.
ShadingSetup prepareShading(const Shading& shading, const Lights& lights, const Volume& volume, const ValueScale& scale, const Camera& camera);

/// The same of normals, for places of a volume of that geometry, where they are known without its voxels: gradients of any length, nothing of them noise.
ShadingSetup prepareLights(const Shading& shading, const Lights& lights, const VolumeGeometry& geometry, const Camera& camera);

}  // namespace warpscope
