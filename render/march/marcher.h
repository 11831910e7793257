// What marches a volume: one interface, one implementation per backend.
// A marcher is bound to a volume and a transfer function and keeps what it derives from them.
#pragma once

#include <memory>
#include <stop_token>

#include "render/core/image.h"
#include "render/core/transfer_function.h"
#include "render/march/march_settings.h"
#include "render/march/sample_frame.h"
#include "render/volume/volume.h"

namespace warpscope {

class Marcher {
 public:
  virtual ~Marcher() = default;

  /// The server's work: a frame of samples for `camera`. Fills timings, leaves requestId 0.
  /// Throws UsageError for settings out of range, InputError for a camera that isUsable() refuses, OperationCancelled if `stop` is set.
  /// Safe to call from several threads; calls may wait for each other.
  virtual SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop = {}) = 0;

  /// The same rays' colours at full precision, linear and premultiplied: the ground truth of warping. Errors as for march().
  virtual void render(const Camera& camera, const MarchSettings& settings, Image<glm::vec4>& image,
                      const std::stop_token& stop = {}) = 0;

  virtual const VolumePtr& volume() const = 0;
};

using MarcherPtr = std::shared_ptr<Marcher>;

/// The radius of a sample at distance t along a ray, in volume units. `cosine` is the angle's between ray and camera axis.
float sampleRadius(const Volume& volume, const Camera& camera, const MarchSettings& settings, float t, float cosine,
                   float opacity);

/// How a frame of this volume seen by this camera quantises its samples.
SampleQuantization quantizationFor(const Volume& volume, const Camera& camera, const MarchSettings& settings);

}  // namespace warpscope
