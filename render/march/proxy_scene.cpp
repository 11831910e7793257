// The copy as a marched volume.
// See proxy_scene.h.
#include "render/march/proxy_scene.h"

#include <algorithm>

#include "render/march/march_setup.h"

namespace warpscope {

ProxyScene::ProxyScene(Proxy proxy, const TransferFunction& function)
    : proxy_(std::move(proxy)), marched_(std::make_shared<const MarchedVolume>(proxy_.volume, functionOfCodes(function, proxy_.scale))) {}

RenderSettings ProxyScene::settingsFor(const RenderSettings& settings) const {
  const glm::vec3 edges = proxy_.volume->geometry().voxelEdges();
  RenderSettings own = settings;
  own.step = std::max(settings.step, 0.5f * std::min({edges.x, edges.y, edges.z}));
  own.effects.jitter = 0.0f;
  own.effects.preIntegration = false;
  return own;
}

}  // namespace warpscope
