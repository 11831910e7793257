// Errors of pictures whose camera moves on before their ground truth could be marched: found at every n-th pixel of what was on show (sparse_pixels.h), in a thread
// of its own, a few times a second. For marchers that do not follow the camera (LiveGroundTruth::followsCamera).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/picture/sparse_pixels.h"
#include "app/session/warp_job.h"
#include "render/base/clock.h"
#include "render/base/newest_worker.h"
#include "render/core/crew.h"

namespace warpscope {

class MovingErrors {
 public:
  using TimePoint = Clock::TimePoint;
  /// Pixels along a picture's longer edge that are looked at, about: a march takes a few milliseconds then.
  static constexpr uint32_t kPixels = 96;
  /// From the end of one finding to the beginning of the next.
  static constexpr std::chrono::milliseconds kPause{250};

  /// `onNews` is called on another thread after each result. `crew`: that its loops run on.
  MovingErrors(std::function<void()> onNews, std::shared_ptr<Crew> crew);

  /// A picture that was on show.
  struct Seen {
    uint64_t panel = 0;  ///< its id
    const WarpDescriptor* technique = nullptr;
    Camera camera;       ///< of the whole picture
    std::shared_ptr<const WarpedImage> sparse;  ///< its sparsePixels(), kPixels
  };
  /// Remembers what a panel shows, in place of what it showed before.
  void see(Seen seen);
  /// The panel shows something that a whole ground truth is for.
  void forget(uint64_t panel);
  /// Begins, where something was seen and it is time. `truth`: what a ground truth is marched by; its camera does not matter.
  void follow(const ReferenceJob& truth, TimePoint now);

  struct Found {
    uint64_t panel = 0;
    const WarpDescriptor* technique = nullptr;
    PictureErrors errors;
  };
  /// What was found since the last call; nothing where it failed: what is wrong then is said where pictures rest.
  std::vector<Found> take(TimePoint now);

  bool isAtWork() const { return isAtWork_; }
  /// Forgets what was seen and what is at work.
  void clear();
  void requestStop() { worker_->requestStop(); }
  bool waitForEnd(std::chrono::steady_clock::time_point time) const { return worker_->waitForEnd(time); }

 private:
  struct Job {
    ReferenceJob truth;
    std::vector<Seen> seen;
  };
  struct Result {
    std::vector<Found> found;
    std::string error;
  };

  static void findErrors(const Job& job, Result& result, const std::stop_token& stop);

  std::vector<Seen> seen_;  // one for each panel, that was not looked at yet
  bool isAtWork_ = false;
  TimePoint endedAt_{};
  std::unique_ptr<NewestWorker<Job, Result>> worker_;
};

}  // namespace warpscope
