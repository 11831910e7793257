// A coarse copy of a volume and how its values look: what a client knows of a scene where no frame has seen it.
// It is marched as the volume is, with the same formulas, by a longer step.
#pragma once

#include <memory>

#include "render/march/march_settings.h"
#include "render/volume/proxy.h"

namespace warpscope {

struct MarchedVolume;

class ProxyScene {
 public:
  ProxyScene(Proxy proxy, const TransferFunction& function);

  const Proxy& proxy() const { return proxy_; }
  /// The copy and its function, as marchers want them.
  const std::shared_ptr<const MarchedVolume>& marched() const { return marched_; }
  /// What pictures of the copy are marched by where those of the volume are by `settings`: half of the copy's shortest voxel edge is step enough, and what is
  /// not worth its time is left out.
  RenderSettings settingsFor(const RenderSettings& settings) const;
  /// Of its voxels.
  size_t sizeBytes() const { return proxy_.volume->sizeBytes(); }

 private:
  Proxy proxy_;
  std::shared_ptr<const MarchedVolume> marched_;
};

using ProxyScenePtr = std::shared_ptr<const ProxyScene>;

}  // namespace warpscope
