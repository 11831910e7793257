// `multihit` on a CUDA device.
// See multihit_warp.h; without a hierarchy: multihit/splatted_surfaces.cuh; with one: clusters/cluster_tree.h.
#pragma once

#include "render/warp/spheres_warp.h"
#include "render/warp/warp.h"

namespace warpscope {

/// `way`: footprints, clusters, or automatic for what is faster for the view; the pictures are the same. Throws DeviceError if there is no device or no CUDA in this build.
std::unique_ptr<Warp> makeCudaMultihitWarp(SphereTracing way = SphereTracing::automatic);

}  // namespace warpscope
