// The registry of techniques and what they share.
// See warp.h. A new technique is one file pair and one line here.
#include "render/warp/warp.h"

#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/core/parallel.h"
#include "render/cuda/devices.h"
#include "render/warp/fallback_warp.h"
#include "render/warp/hold_warp.h"
#include "render/warp/multihit/nearest_hits.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/points_warp.h"
#include "render/warp/reference_warp.h"
#include "render/warp/spheres_warp.h"
#include "render/warp/splats_warp.h"

namespace warpscope {
namespace {

constexpr WarpDescriptor kWarps[] = {
    {"reference", "Reference", "the volume marched at the current camera: the ground truth", false, false, {}, makeReferenceWarp},
    {"hold", "Hold", "the last image, not warped: what image-streaming viewers show", true, false, {}, makeHoldWarp},
    {"points", "Points", "OpenGL points of a fixed size in pixels (2012)", true, false, {.depth = true, .pointSize = true},
     makePointsWarp},
    {"spheres", "Spheres", "first hit of rays with spheres over an LBVH (2020)", true, true, {.depth = true, .radius = true},
     makeSpheresWarp},
    {"splats", "Splats", "the picture of spheres without a hierarchy: each is intersected with the pixels that it may cover", true, true,
     {.depth = true, .radius = true}, makeSplatsWarp},
    {"multihit", "Multihit", "the nearest few spheres along each ray, blended", true, true,
     {.depth = true, .radius = true, .hits = true}, makeMultihitWarp},
};

}  // namespace

std::span<const WarpDescriptor> warpRegistry() { return kWarps; }

const WarpDescriptor& findWarp(std::string_view name) {
  if (const WarpDescriptor* warp = findNamed(kWarps, name)) return *warp;
  throw UsageError(unknownNameIn(kWarps, "technique", name));
}

std::unique_ptr<Warp> makeWarp(const WarpDescriptor& descriptor, const WarpResources& resources) {
  const auto makeOn = [&descriptor, resources](Backend backend) {
    WarpResources bound = resources;
    bound.backend = backend;
    return descriptor.make(bound);
  };
  if (resources.backend != Backend::automatic) return makeOn(resources.backend);
  if (!cuda::whyUnavailable().empty()) return makeOn(Backend::cpu);
  return makeFallbackWarp([makeOn] { return makeOn(Backend::cuda); }, [makeOn] { return makeOn(Backend::cpu); }, resources.onFallback);
}

void validate(const WarpSettings& settings) {
  if (settings.pointSize < 1 || settings.pointSize > 16)
    throw UsageError("the point size must be between 1 and 16 pixels, not " + std::to_string(settings.pointSize));
  if (settings.hits < 1 || settings.hits > kMaxHits)
    throw UsageError("the hits along a ray must be between 1 and " + std::to_string(kMaxHits) + ", not " + std::to_string(settings.hits));
  validate(settings.reference);
}

void resolveColors(const SampleFrame& frame, const Image<uint32_t>& samples, Image<glm::vec4>& color) {
  color.reshape(samples.width(), samples.height());
  const ColorTables& tables = ColorTables::instance();
  parallelForRanges(samples.size(), 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      color[i] = samples[i] < frame.size() ? tables.decode(frame.colors[samples[i]]) : glm::vec4(0.0f);
  });
}

}  // namespace warpscope
