// Frames that came before the newest: what a moving camera has already seen needs no guess. The knob of every technique that leaves gaps.
// Accumulation over frames as in McMillan 1997 and the render caches of Walter, Drettakis, Parker 1999; here each frame keeps a technique of its own, and
// pictures are completed pixel by pixel, the newest frame first.
#pragma once

#include <deque>
#include <memory>

#include "render/warp/warp.h"

namespace warpscope {

/// Frames that are drawn from, the newest included.
extern const Knob kKeepKnob;
inline constexpr int kMostKept = 8;

/// Frames are worth keeping that were seen from at least this far beside one another: nearer ones hardly see more.
inline constexpr double kKeptApartDeg = 4.0;

/// How far two cameras are from one another as things in the middle of the bounds see them: the angle between their eyes there, or what a like change of
/// distance is. Degrees.
double apartDeg(const Camera& a, const Camera& b, const Box& bounds);

/// Frames before the newest, each with a technique that draws it. One thread at a time.
class KeptFrames {
 public:
  /// Whether one frame's picture may complete another's: the same volume and settings.
  static bool fit(const SampleFrame& frame, const SampleFrame& newest);

  /// Takes the frame that was the newest until now, with its technique, before `newest`; at most `most` are kept. Returns a technique that is not needed
  /// any more, if there is one. What does not fit the newest goes.
  std::unique_ptr<Warp> take(SampleFramePtr frame, std::unique_ptr<Warp> warp, const SampleFrame& newest, size_t most);
  /// Keeps `most` at most, the newest.
  void limitTo(size_t most);
  /// After a change of knobs that what was built is of no use with.
  void rebuild(const WarpSettings& settings, const std::stop_token& stop);
  bool empty() const { return kept_.empty(); }

  /// Gives pixels that nothing covers, or a guess, what kept frames show there, the newest of those that do.
  void complete(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop);

 private:
  struct Kept {
    SampleFramePtr frame;
    std::unique_ptr<Warp> warp;
  };
  std::deque<Kept> kept_;  // newest first
  WarpedImage image_;
};

}  // namespace warpscope
