// How large a frame's image may be so that the frame takes no more bytes than its client allows.
// Feedback on what frames took: bytes are taken to grow as pixels^kExponent, which is less than in proportion: the fewer the pixels, the less their neighbours predict.
#pragma once

#include <cstdint>

#include "app/frames/frame_fetch.h"
#include "render/core/camera.h"
#include "render/march/march_settings.h"

namespace warpscope {

/// What `frameKib` says, above 0.
inline uint64_t bytesOfFrame(const TransportSettings& transport) { return uint64_t{1024} * static_cast<uint64_t>(transport.frameKib); }

/// The longer side of the camera's image, in pixels.
uint32_t longerSide(const Camera& camera);
/// The same view on an image whose longer side is `sidePx`, at least a pixel each way.
Camera ofLongerSide(const Camera& camera, uint32_t sidePx);

/// Of one client. One frame after another tells what the next will take: views follow each other closely. Frames of other numbers of segments are foreseen in
/// proportion to what such frames usually take.
class FrameSizeRule {
 public:
  static constexpr double kExponent = 0.85;
  static constexpr uint32_t kLeastSidePx = 64;
  /// What is aimed at, as a share of the budget; and a size stays as long as what is foreseen of it is above kLeastShare, so that pictures do not flicker.
  static constexpr double kAim = 0.92, kLeastShare = 0.8;

  /// The camera of a frame that is foreseen to fit: `full`, or with fewer pixels, but not below kLeastSidePx. `budgetBytes`: above 0.
  Camera choose(const Camera& full, const MarchSettings& settings, double budgetBytes);
  /// What a frame took, without the copy of the volume.
  void note(const Camera& camera, const MarchSettings& settings, double tookBytes);
  /// The camera of a frame with about `factor` times the bytes, above 1, and more pixels; at most `full`.
  static Camera grown(const Camera& camera, const Camera& full, double factor);

 private:
  double foreseen(const Camera& camera, const MarchSettings& settings) const;

  double share_ = 1.0;   // of bytes in what a frame is taken for without any knowledge
  uint32_t lastPx_ = 1;  // the side that was chosen
};

/// Frames of `fetch` that take no more than `budgetBytes` without the copy of the volume: asked for again with fewer pixels until one does, and that is at
/// least 0.9 of it or all pixels, or eight were asked for. The same frames, whatever was fetched before. Throws InputError where that of the fewest pixels is too large, and
/// whatever `fetch` throws.
FrameFetch withinBudget(FrameFetch fetch, uint64_t budgetBytes);

}  // namespace warpscope
