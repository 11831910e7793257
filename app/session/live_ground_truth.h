// The ground truth of what the panels show, marched in the background: all the time where the marcher is fast enough, elsewhere when the camera rests.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "app/session/warp_worker.h"
#include "render/base/clock.h"

namespace warpscope {

/// Whether a picture of one is worth comparing with a ground truth of the other: nothing but the camera's place differs.
bool differOnlyInPlace(const ReferenceJob& a, const ReferenceJob& b);

class LiveGroundTruth {
 public:
  using TimePoint = Clock::TimePoint;

  /// `onNews` is called on another thread after each result. `crew`: as makeReferenceWorker().
  explicit LiveGroundTruth(std::function<void()> onNews, std::shared_ptr<Crew> crew = nullptr);

  /// Forgets all; what is at work ends.
  void clear();
  /// What is wanted from now on; marches it when it is time. True if it waits for that time or has just begun.
  bool follow(ReferenceJob wanted, TimePoint now);
  /// Collects a result. True if there was one that is of use.
  bool take();

  /// True where it is marched all the time, because the marcher is fast enough. Elsewhere it is when the camera rests.
  bool followsCamera() const;
  const ReferenceJob& wanted() const { return wanted_; }
  /// Whether what is wanted was asked for.
  bool isAsked() const { return asked_ == wanted_; }
  /// The newest; null while there is none. Its camera may be an earlier one where it follows the camera.
  const std::shared_ptr<const ReferenceImage>& image() const { return image_; }

  /// Why the last could not be had, or judged by; empty if it could.
  const std::string& error() const { return error_; }
  void setError(std::string error) { error_ = std::move(error); }

  void requestStop() { worker_->requestStop(); }
  bool waitForEnd(std::chrono::steady_clock::time_point time) const { return worker_->waitForEnd(time); }

 private:
  ReferenceJob wanted_, asked_;
  TimePoint movedAt_{};  // when wanted_ changed last
  TimePoint askedAt_{};
  std::shared_ptr<const ReferenceImage> image_;
  std::string error_;
  std::unique_ptr<ReferenceWorker> worker_;
};

}  // namespace warpscope
