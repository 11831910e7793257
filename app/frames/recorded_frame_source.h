// Frames of a recording in place of a server's: whatever is asked for, what comes is the frame that was the newest at the time that was sought.
// Reads and decodes in a thread of its own; newest wins.
#pragma once

#include <functional>
#include <memory>

#include "app/frames/frame_source.h"
#include "app/frames/recording.h"
#include "render/base/newest_worker.h"

namespace warpscope {

class RecordedFrameSource final : public FrameSource {
 public:
  /// `onNews` is called on its thread after each answer.
  RecordedFrameSource(std::shared_ptr<const Recording> recording, std::function<void()> onNews);

  /// Asks for the frame that was the newest then, unless that was asked for last. On one thread, as tryTake().
  void seek(double seconds);
  /// Whether what was sought last has not been taken yet.
  bool isSeeking() const { return sought_ && sought_ != taken_; }
  const Recording& recording() const { return *recording_; }
  const std::shared_ptr<const Recording>& sharedRecording() const { return recording_; }

  struct Taken {
    ServedFrame served;
    size_t view = 0;  ///< of the recorded path, the one that the frame was asked with as far as its camera tells: the likest, of several the last before it came
  };
  /// As tryTake().
  std::optional<Taken> take();

  void post(const FrameRequest& /*request*/, Clock::TimePoint /*now*/) override {}
  std::optional<ServedFrame> tryTake() override;
  void setTransport(const TransportSettings& /*transport*/) override {}
  SourceStatus status() const override { return {}; }
  void requestStop() override { worker_.requestStop(); }

 private:
  struct Result {
    size_t index = 0;
    Taken taken;
    std::string error;
  };

  const std::shared_ptr<const Recording> recording_;
  std::optional<size_t> sought_, taken_;  // indices
  NewestWorker<size_t, Result> worker_;
};

}  // namespace warpscope
