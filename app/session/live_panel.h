// A panel and its threads: one draws its pictures, one judges them against the ground truth, and one marches that where the panel has a camera of its own.
// Hands out jobs, collects results into the panel's state, and never waits.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "app/session/frame_requests.h"
#include "app/session/judge_worker.h"
#include "app/session/live_ground_truth.h"
#include "app/session/live_view.h"
#include "app/session/moving_errors.h"
#include "app/session/panel.h"
#include "app/session/technique_choice.h"
#include "app/session/warp_worker.h"

namespace warpscope {

class LivePanel {
 public:
  using TimePoint = Clock::TimePoint;

  /// `onNews` is called on other threads whenever there is something to collect.
  LivePanel(uint64_t id, const PanelSettings& settings, std::unique_ptr<WarpWorker> warp, std::unique_ptr<JudgeWorker> judge);

  const Panel& shown() const { return shown_; }
  void setKnobs(const KnobValues& knobs) { shown_.knobs = knobs; }
  /// A hidden panel draws nothing, and keeps what it showed.
  void setHidden(bool isHidden) { shown_.isHidden = isHidden; }
  /// What is shown in place of the picture, or the picture itself, and how far its ramp goes.
  void setContent(PictureContent content, std::optional<float> range);
  void setAutomatic(bool isAutomatic) { shown_.isAutomatic = isAutomatic; }
  /// What a panel that chooses by itself chose, and why.
  void setChoice(std::optional<Configuration> choice, std::string text);
  /// True if it is another one than before.
  bool setTechnique(const WarpDescriptor& technique);
  /// Forgets what belongs to a scene; how the panel was set up stays.
  void clear();

  /// A camera that the panel has for itself, from `view` on, with its own ground truth.
  struct OwnCamera {
    LiveView view;
    LiveGroundTruth truth;
  };
  void giveCamera(const View& view, const std::function<void()>& onNews, const std::shared_ptr<Crew>& crew);
  /// The panel follows the others' again.
  void takeCamera();
  /// Null while the panel has none.
  OwnCamera* ownCamera() { return hasOwnCamera_ ? ownCamera_.get() : nullptr; }
  const OwnCamera* ownCamera() const { return hasOwnCamera_ ? ownCamera_.get() : nullptr; }

  /// What chooses the technique where the panel is automatic.
  TechniqueChoice& chooser() { return chooser_; }

  /// Whether that job is another one than was posted last.
  bool isNew(const WarpJob& job) const { return !(job == job_); }
  void post(WarpJob job);
  /// Collects a picture, or the time that one took; nothing if there is none.
  std::optional<WarpResult> take() { return warp_->tryTake(); }
  /// Takes over a picture for the screen, drawn from a frame that came so, and has it judged if its job wanted that. `leftOut`: see Panel.
  void show(WarpResult drawn, const std::optional<FrameRequests::Arrival>& arrival, std::optional<Configuration> configuration,
            std::string leftOut);

  /// Errors that were found since the last call and that may be shown.
  struct NewErrors {
    Configuration configuration;  ///< whose they are
    glm::uvec2 sizePx{0};
    double angleDeg = 0.0;        ///< between the frame's camera and the picture's
    double flip = 0.0;
  };
  struct ErrorNews {
    bool happened = false;           ///< there are new ones, or the old ones are not current any more
    std::optional<NewErrors> found;  ///< those whose configuration is known
    std::string error;               ///< why they could not be found
  };
  /// What was found of a picture that moved.
  void note(const MovingErrors::Found& found, TimePoint now);
  ErrorNews takeErrors(const LiveGroundTruth& truth, TimePoint now);

  /// Whether the panel shows that request's frame, or may come to.
  bool mayShow(uint64_t requestId) const;
  /// True if what is wanted is drawn and judged, or cannot be drawn.
  bool isAtRest(const LiveGroundTruth& truth) const;

  /// Whether the picture on show is worth timing: it was not timed yet, and it is known what drew it.
  bool wantsTime() const;
  void startTiming();
  void stopTiming() { warp_->cancel(); }
  /// The picture on show was timed, or could not be: it would fail again.
  void finishTiming() { timed_ = shown_.picture; }

  void requestStop();
  bool waitForEnd(std::chrono::steady_clock::time_point time) const;

 private:
  struct Judged {
    JudgeJob job;
    TimePoint at{};
  };
  /// Whether these errors are those of the picture that is shown, against the ground truth that is wanted.
  bool isJudged(const JudgeJob& job, const LiveGroundTruth& truth) const;
  /// Whether these errors may be shown for what the panel shows now.
  bool areCurrent(const Judged& judged, const LiveGroundTruth& truth, TimePoint now) const;

  Panel shown_;
  TechniqueChoice chooser_;
  bool hasOwnCamera_ = false;
  std::unique_ptr<OwnCamera> ownCamera_;  // kept once it was made: its thread need not be waited for
  WarpJob job_;                   // last posted
  bool isDrawing_ = false;        // that job is not answered yet
  uint64_t drawnId_ = 0;          // of the frame that was drawn last, or that could not be drawn
  std::optional<Judged> judged_;  // what the panel's errors are of
  TimePoint movingErrorsAt_{};
  std::optional<JudgeJob> posted_;  // to the judge, last
  ShownPicture timed_;            // that was timed last
  std::unique_ptr<WarpWorker> warp_;
  std::unique_ptr<JudgeWorker> judge_;
};

}  // namespace warpscope
