// What marchers have in common whose rays are marched piece by piece (ray_relay.h), wherever the pieces are: frames and pictures of what a picture's tiles leave.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string_view>

#include "render/march/finished_ray.h"
#include "render/march/march_setup.h"
#include "render/march/marcher.h"

namespace warpscope {

/// What rays of a tile have left, where they have found anything.
struct PieceOutcome {
  PixelArea area;                       ///< the tile's
  std::span<const uint32_t> finished;   ///< rays, by their places in it
  const DenseRays& found;               ///< of each of these; where samples are wanted
  std::span<const glm::vec4> colors;    ///< likewise; where they are not
};

class PiecewiseMarcher : public Marcher {
 public:
  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override;
  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override;

  const VolumePtr& volume() const final { return marched_->volume; }
  std::optional<EffectPlan> plan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const final;

 protected:
  using OnOutcome = std::function<void(const PieceOutcome&)>;

  /// `whyPieces`: why pieces are marched, for who asks for what cannot be: "the volume is spread over several processes".
  PiecewiseMarcher(MarchedVolumePtr marched, std::string_view whyPieces) : marched_(std::move(marched)), whyPieces_(whyPieces) {}

  /// Marches all rays of the picture, with samples or for their colours alone; `onOutcome` gets what they leave, one call at a time. Throws as Marcher::march().
  virtual void marchTiles(const Camera& camera, const RenderSettings& settings, const std::optional<SampleSettings>& sample, const std::stop_token& stop,
                          const OnOutcome& onOutcome) = 0;
  virtual ProxyPtr proxyFor(int longest, const std::stop_token& stop) = 0;

  const MarchedVolumePtr& marched() const { return marched_; }

 private:
  void requirePieces(const RenderSettings& settings) const;

  const MarchedVolumePtr marched_;
  const std::string_view whyPieces_;
  std::mutex mutex_;  // of what follows
  DenseRays dense_;
};

}  // namespace warpscope
