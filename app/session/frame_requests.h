// Asks the server for frames of what is wanted now, takes the newest, and knows of each frame on show what it shows and since when that is outdated.
// Where a frame may take only so many bytes, those of a camera that moves have fewer pixels. At rest each has twice the bytes of the last, until none is missing: whoever moves on
// waits no longer for what is still under way than about twice as long as the camera has rested.
// Bounded: it remembers the requests that are under way or on show, and of those that were replaced before they left no more than kMostKept, however long it lasts.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "app/frames/frame_budget.h"
#include "app/frames/frame_source.h"
#include "app/scene/scene.h"
#include "app/session/rate_meter.h"

namespace warpscope {

/// What a frame should show, and how it should come.
struct WantedFrame {
  Camera camera;
  View view;                  ///< that it is of
  MarchSettings march;
  CodecSettings codec;
  uint32_t serverSidePx = 0;  ///< longer side that the camera's size was made from
  uint64_t functionVersion = 0;  ///< of the transfer function

  bool operator==(const WantedFrame&) const = default;
};

class FrameRequests {
 public:
  using TimePoint = Clock::TimePoint;
  /// How long the camera must rest before it is shown in full, and judged.
  static constexpr std::chrono::milliseconds kRest{150};
  /// Requests that are remembered, of which few can be under way: where nobody answers, a camera that moves asks sixty times a second.
  static constexpr size_t kMostKept = 1024;

  /// From now on frames come from `source`, which must stay until the next begin(). Frames from before are forgotten.
  void begin(FrameSource& source, const TransportSettings& transport);

  void setTransport(const TransportSettings& transport);
  /// Classifies the newest frame's copy of the volume anew, so that what is drawn of it shows the function at once. What is asked for from now on is of
  /// that function. False where the source leaves no choice.
  bool setTransferFunction(const TransferFunction& function, uint64_t version);
  /// The first half of that: of frames that were recorded, whose source makes no others.
  void classify(const TransferFunction& function);
  /// Asks for `wanted` if that is something else than what was asked for last. `isFrozen`: only if there is no frame yet. Asks once more where the answer
  /// was marched coarser than it was wanted (coarsening.h) or has fewer pixels, as soon as nothing else has been wanted for kRest: a camera that rests is shown in full.
  /// True if it asked, or waits for that time.
  bool ask(const WantedFrame& wanted, bool isFrozen, TimePoint now);
  /// Collects an answer. True if there was one.
  bool take();
  /// Takes over a frame that nobody asked for here, or why it could not be had: from then on it is the newest, and what it was asked for is what is wanted.
  void show(ServedFrame served, const WantedFrame& asked);
  /// Forgets requests that neither are under way nor on show, as `isOnShow` says.
  void forgetOld(const std::function<bool(uint64_t requestId)>& isOnShow);

  /// The newest frame; null until there is one.
  const SampleFramePtr& newest() const { return frame_; }
  /// Of the newest frame, on the wire; of the copy of the volume where it has one, whichever frame that came with.
  const FrameBytes& bytesOfNewest() const { return frameBytes_; }
  /// How long ago the newest frame arrived; nothing without one.
  std::optional<double> ageOfNewestMs(TimePoint now) const;
  /// Of all sources.
  size_t received() const { return received_; }
  double perSecond(TimePoint now) const { return rate_.perSecond(now); }
  /// Why the last frame could not be had; empty if it could.
  const std::string& error() const { return error_; }
  void dismissError() { error_.clear(); }

  /// True while the newest request is not answered.
  bool isUnderWay() const { return answeredId_ < requestId_; }
  /// Whether the newest request asked for what is wanted now.
  bool isWhatIsWanted() const { return asked_ == wanted_; }
  /// Whether the newest frame, which is of what is wanted, was marched coarser or has fewer pixels, and will be asked for once more.
  bool isToBeRefined() const;
  /// For how long what the request asked for has not been wanted any more: 0 while it is.
  double ageMs(uint64_t requestId, TimePoint now) const;

  struct Arrival {
    FrameLatency latency;
    FrameBytes bytes;  ///< as bytesOfNewest()
  };
  /// Nothing of requests that are forgotten; of those under way no arrival.
  std::optional<Arrival> arrivalOf(uint64_t requestId) const;
  /// With the pixels that were asked for, which may be fewer than were wanted.
  std::optional<WantedFrame> askedBy(uint64_t requestId) const;
  size_t remembered() const { return requests_.size(); }

 private:
  struct Request {
    WantedFrame asked;
    std::optional<TimePoint> outdatedAt;  // when it stopped being what was wanted
    std::optional<Arrival> arrival;
  };
  const Request* find(uint64_t requestId) const;
  void keep(ServedFrame served);
  /// Asks for `wanted` by that camera, which has as many pixels or fewer.
  void post(const WantedFrame& wanted, const Camera& camera, TimePoint now);
  bool hasFewerPixels() const { return posted_ != asked_->camera; }

  FrameSource* source_ = nullptr;
  TransportSettings transport_;        // that the source was told last
  std::optional<WantedFrame> wanted_;  // what the newest frame should show
  std::optional<WantedFrame> asked_;   // what was asked for last
  uint64_t requestId_ = 0;             // of that request
  TimePoint wantedSince_{};            // when it was asked for first
  Camera posted_;                      // by which it was asked for last
  FrameSizeRule size_;
  bool isRefined_ = false;             // it was asked for once more
  bool isFrozen_ = false;
  uint64_t answeredId_ = 0;            // the last that was answered, by a frame or an error
  std::map<uint64_t, Request> requests_;
  SampleFramePtr frame_;
  FrameBytes frameBytes_;
  size_t proxyBytes_ = 0;  // of the copy that came last
  TimePoint frameArrivedAt_{};
  size_t received_ = 0;
  RateMeter rate_;
  std::string error_;
};

}  // namespace warpscope
