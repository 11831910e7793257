// Everything that the window shows, without the window: the scene, the camera, the knobs, two panels, and the threads that serve them.
// Panels read the state and return edits; update() hands work to the threads and collects what they made.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/auto_choice.h"
#include "app/experiment/live_front.h"
#include "app/session/error_history.h"
#include "app/session/judge_worker.h"
#include "app/session/rate_meter.h"
#include "app/session/scene_loader.h"
#include "app/session/warp_worker.h"
#include "render/base/clock.h"

namespace warpscope {

/// What the user can turn while the window is open.
struct LiveSettings {
  MarchSettings march;
  WarpSettings warp;               ///< its `reference` is not used: the reference follows `march`
  uint32_t serverSidePx = 512;     ///< longer side of the server's image
  uint32_t screenPixels = 0;       ///< edge, in screen pixels, of a pixel that the panels draw; 0: whatever keeps the display fluent
  TransportSettings transport;     ///< how frames travel from the server
  bool isFrozen = false;           ///< the server is asked for nothing: its last frame stays
  Rgba8 uncovered = 0;             ///< 0: the scene's background
  double budgetMs = kDefaultBudgetMs;  ///< of a picture, for panels that choose by themselves

  bool operator==(const LiveSettings&) const = default;
};

inline constexpr size_t kPanelCount = 2;

/// What one panel shows.
struct Panel {
  const WarpDescriptor* technique = nullptr;
  ShownPicture picture;                         ///< none until the first is there; stays until the next
  const WarpDescriptor* drawn = nullptr;        ///< the technique that drew it
  uint64_t requestId = 0;                       ///< of the frame that it was drawn from
  FrameLatency latency;                         ///< of that frame
  size_t frameBytes = 0;                        ///< of that frame on the wire
  double buildMs = 0.0;
  double drawMs = 0.0;
  double displayMs = 0.0;                       ///< from the picture's end until the display took it
  std::optional<Configuration> configuration;   ///< that drew it; nothing while it is not known, or `drawn` uses no frames
  std::string error;                            ///< empty if the last picture succeeded

  bool isAutomatic = false;                     ///< `technique` is chosen for each picture by what was measured
  std::optional<Configuration> choice;          ///< what was chosen; nothing if nothing fits
  std::string choiceText;                       ///< what, and why: a sentence without its full stop

  std::optional<PictureErrors> errors;  ///< the last that were found
  /// They are those of the picture that is shown or, where the ground truth follows the moving camera (Session::isReferenceLive), of one shown
  /// less than kLiveErrors ago by the same technique.
  bool errorsAreCurrent = false;
  ShownPicture heatMap;                 ///< FLIP pixel by pixel, of `errors`
  bool showsHeatMap = false;            ///< the user wants it instead of the picture
  ErrorHistory history;                 ///< of FLIP

  bool hasHeatMapOnShow() const { return showsHeatMap && errorsAreCurrent && heatMap; }
};

inline constexpr std::chrono::seconds kLiveErrors(1);

struct SessionSettings {
  std::array<const WarpDescriptor*, kPanelCount> techniques{};
  std::array<bool, kPanelCount> isAutomatic{};  ///< which panels choose by themselves
  LiveSettings knobs;  ///< `march` is replaced by each scene's
  gl::Platform platform = gl::Platform::automatic;
  WarpResources resources;  ///< backend and onFallback; the rest is the session's
  JudgeMaker makeJudge = warpscope::makeJudge;
};

class Session {
 public:
  using TimePoint = Clock::TimePoint;

  /// `onNews` is called on any thread whenever update() has something to collect.
  Session(SessionSettings settings, std::function<void()> onNews);

  // --- Edits. Those of the same value do nothing.
  /// Opens a scene in the background; the one on show stays until it is there. The newest request wins and ends the one before it.
  void load(LoadJob job);
  /// Gives up opening; the scene on show stays.
  void cancelLoad();
  void setView(const View& view) { view_ = view; }
  void setKnobs(const LiveSettings& knobs) { knobs_ = knobs; }
  /// The panel does not choose by itself any more.
  void setTechnique(size_t panel, const WarpDescriptor& technique);
  /// Lets the panel choose: of a sweep that was handed over, or of what was on show so far. What the server does stays as the knobs say.
  void setAutomatic(size_t panel);
  /// A sweep to choose by; null for none.
  void setFront(std::shared_ptr<const AutoChoice> front) { front_ = std::move(front); }
  void setShowsHeatMap(size_t panel, bool shows) { panels_[panel].showsHeatMap = shows; }
  /// Takes over that configuration's technique for the panel, and the knobs that it depends on for all.
  void choose(size_t panel, const Configuration& configuration);
  /// Area for each panel's picture, in screen pixels.
  void setPanelSize(const glm::uvec2& sizePx) { panelSizePx_ = sizePx; }
  void resetView();
  void dismissErrors();

  /// Collects results and hands out work. Call it once for each frame of the display; it never waits. True if anything happened.
  bool update(TimePoint now);

  /// Asks all threads to end, and waits until they have or `patience` is over. False if a scene that cannot be interrupted is still
  /// being read; then destroying the session waits for it.
  bool close(std::chrono::milliseconds patience);

  // --- State.
  /// Null until the first scene is there.
  const Scene* scene() const { return loaded_ ? &loaded_->scene : nullptr; }
  /// Name of the scene that is being opened; empty if none is.
  const std::string& loading() const { return loading_; }
  /// Why the last scene, view, frame or ground truth could not be had; empty if it could.
  const std::string& error() const;
  const View& view() const { return view_; }
  const LiveSettings& knobs() const { return knobs_; }
  const Panel& panel(size_t index) const { return panels_[index]; }
  /// Accuracy against time of what was on show since the scene was opened. Pictures are timed when everything has come to rest, one panel after the other.
  const LiveFront& liveFront() const { return liveFront_; }
  /// True where the ground truth is marched all the time, because the marcher is fast enough. Elsewhere it is when the
  /// camera rests.
  bool isReferenceLive() const { return loaded_ && loaded_->display->capabilities().pace == MarchPace::followsCamera; }
  /// The newest frame; null until there is one.
  const SampleFramePtr& frame() const { return frame_; }
  /// Of the connection to the server; nothing without a scene.
  std::optional<SourceStatus> sourceStatus() const;
  /// Of the newest frame, on the wire.
  size_t frameBytes() const { return frameBytes_; }
  /// How long ago the newest frame arrived; nothing without one.
  std::optional<double> frameAgeMs(TimePoint now) const;
  /// Of all scenes.
  size_t framesReceived() const { return framesReceived_; }
  double serverFramesPerSecond(TimePoint now) const { return serverRate_.perSecond(now); }
  /// True while the newest request is not answered.
  bool isServerAtWork() const { return answeredId_ < requestId_; }
  /// Size of the panels' pictures and of the server's images; 0 until a panel has a size.
  glm::uvec2 pictureSize() const;
  glm::uvec2 serverSize() const;
  /// How many screen pixels a picture's pixel is wide.
  uint32_t screenPixels() const;
  /// For how many requests the session remembers when they were outdated: no more than are under way or on show, however long it lasts.
  size_t rememberedRequests() const { return outdatedAt_.size(); }
  /// For how long the camera of the frame in `panel` has not been the current one any more: 0 while it is. Nothing without a frame.
  std::optional<double> ageMs(size_t panel, TimePoint now) const;

 private:
  struct Wanted {
    FrameSourcePtr source;
    Camera camera;
    MarchSettings settings;
    CodecSettings codec;
    bool operator==(const Wanted&) const = default;
  };
  struct Arrival {
    FrameLatency latency;
    size_t bytes = 0;
  };
  /// What a request asked for, as configurations name it.
  struct Asked {
    MarchSettings march;
    CodecSettings codec;
    uint32_t serverSidePx = 0;
  };

  // Each is true if anything happened.
  bool takeScene();
  /// Lets go of the scene on show; its threads end in the background.
  void retireScene();
  /// False if no picture can be made of the view; error() says why, and the last good view is back.
  bool placeCamera();
  bool takeFrame();
  bool takeReference();
  bool takePicture(size_t index);
  bool takeErrors(size_t index, TimePoint now);
  bool ask(TimePoint now);
  bool askReference(TimePoint now);
  bool postJob(size_t index);
  void useTechnique(size_t index, const WarpDescriptor& technique);
  /// For a panel that chooses by itself.
  void chooseTechnique(size_t index);
  /// True if nothing is under way, and what is on show is what was wanted and is judged: what is timed now is timed alone.
  bool isAtRest() const;
  bool isJudged(const Panel& panel, const JudgeJob& job) const;
  /// After a while of quiet lets a panel time its picture, if it has not yet; the other waits.
  void timePictures(TimePoint now);
  /// Takes what a panel found.
  void takeTime(size_t index, const WarpResult& result);
  void stopTiming();
  /// Hands a picture to the panel's judge.
  void judge(size_t index, WarpResult drawn);
  /// Whether these errors may be shown for what the panel shows now.
  bool areCurrent(const Panel& panel, const JudgeJob& job, TimePoint judgedAt, TimePoint now) const;
  std::optional<Configuration> configurationOf(const WarpJob& drawn) const;
  ReferenceJob wantedReference() const;
  /// Whether a panel shows that request's frame, or may come to: it is on its way from the server or to the panel.
  bool mayBeShown(uint64_t requestId) const;
  void forgetOldRequests();
  /// Of the view. One camera for all sizes: its distance depends on the picture's shape, which rounding changes a little.
  Camera cameraOfSize(const glm::uvec2& size) const;
  bool isCurrent(uint64_t requestId) const { return requestId == requestId_ && wanted_ == asked_; }

  std::shared_ptr<const ConnectedScene> loaded_;
  std::string loading_, loadError_, viewError_, serverError_, referenceError_;
  View view_, usableView_;
  Camera camera_;  // of the panels' pictures
  LiveSettings knobs_;
  glm::uvec2 panelSizePx_{0};
  std::array<Panel, kPanelCount> panels_;

  Wanted wanted_;            // what the server's newest frame should show
  Wanted asked_;             // what it was last asked for
  uint64_t requestId_ = 0;   // of that request
  uint64_t answeredId_ = 0;  // the last that was answered, by a frame or an error
  std::map<uint64_t, TimePoint> outdatedAt_;  // when each request stopped being what was wanted; of those alone that mayBeShown()
  std::array<uint64_t, kPanelCount> drawnIds_{};  // of the frame that each panel's worker drew last, or failed to draw
  SampleFramePtr frame_;
  size_t frameBytes_ = 0;
  size_t framesReceived_ = 0;
  TimePoint frameArrivedAt_{};
  std::map<uint64_t, Arrival> arrivals_;  // of frames that are on show or may come to be
  std::map<uint64_t, Asked> askedFor_;    // likewise
  TransportSettings transport_;           // that the source was told last
  RateMeter serverRate_;

  ReferenceJob referenceWanted_, referenceAsked_;
  TimePoint movedAt_{};             // when referenceWanted_ changed last
  TimePoint referenceAskedAt_{};
  std::shared_ptr<const ReferenceImage> reference_;
  struct Judged {
    JudgeJob job;
    TimePoint at{};
  };
  std::array<std::optional<Judged>, kPanelCount> judged_;  // what each panel's errors are of
  LiveFront liveFront_;
  std::shared_ptr<const AutoChoice> front_;
  /// What a panel's choice depends on, so that it is made anew only where it may change.
  struct ChoiceInput {
    SampleFramePtr frame;
    Camera camera;
    double budgetMs = 0.0;
    std::shared_ptr<const AutoChoice> front;
    uint64_t liveFront = 0;  ///< LiveFront::version()
    bool operator==(const ChoiceInput&) const = default;
  };
  std::array<ChoiceInput, kPanelCount> choiceInputs_;
  std::array<WarpJob, kPanelCount> jobs_;        // last posted
  std::array<bool, kPanelCount> isDrawing_{};  // that job is not answered yet
  TimePoint quietSince_{};                       // when something happened last
  std::optional<size_t> timing_;                 // the panel that times its picture
  std::array<ShownPicture, kPanelCount> timed_;  // that each panel timed last

  // Last: their threads call onNews_.
  std::vector<std::future<void>> retired_;  // scenes that end
  std::unique_ptr<SceneLoader> loader_;
  std::unique_ptr<ReferenceWorker> referenceWorker_;
  std::array<std::unique_ptr<WarpWorker>, kPanelCount> warpWorkers_;
  std::array<std::unique_ptr<JudgeWorker>, kPanelCount> judgeWorkers_;
};

}  // namespace warpscope
