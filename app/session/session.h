// Everything that the window shows, without the window: the scene, the camera, the knobs, the panels, and the threads that serve them.
// The window reads the state and returns edits; update() hands work to the threads and collects what they made. What is done lies in the parts:
// scene_opening, live_view, frame_requests, live_ground_truth, live_panel, live_plan, live_playback, live_ray, moving_errors, picture_timing.
#pragma once

#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/auto_choice.h"
#include "app/experiment/live_front.h"
#include "app/frames/recording.h"
#include "app/frames/recording_writer.h"
#include "app/session/fair_measuring.h"
#include "app/session/frame_requests.h"
#include "app/session/live_ground_truth.h"
#include "app/session/live_motion.h"
#include "app/session/live_panel.h"
#include "app/session/live_plan.h"
#include "app/session/live_playback.h"
#include "app/session/live_ray.h"
#include "app/session/live_view.h"
#include "app/session/moving_errors.h"
#include "app/session/picture_timing.h"
#include "app/session/replay_export.h"
#include "app/session/scene_opening.h"

namespace warpscope {

/// A pixel of a panel's picture, in shares of its width and height from the upper left corner, so that it is the same one in pictures of another size.
struct LookedAt {
  uint64_t panel = 0;  ///< its id
  glm::dvec2 place{0.0};

  bool operator==(const LookedAt&) const = default;
};

/// What the user can turn while the window is open.
struct LiveSettings {
  MarchSettings march;
  WarpSettings warp;               ///< its `reference` is not used: the reference follows `march`
  uint32_t serverSidePx = 512;     ///< longer side of the server's image
  uint32_t screenPixels = 0;       ///< edge, in screen pixels, of a pixel that the panels draw; 0: whatever keeps the display fluent
  TransportSettings transport;     ///< how frames travel from the server
  bool isFrozen = false;           ///< the server is asked for nothing: its last frame stays
  PixelMarks marks;
  bool takesShortcuts = false;     ///< where the frame itself is enough, panels show that: picture_plan.h
  double budgetMs = kDefaultBudgetMs;  ///< of a picture, for panels that choose by themselves

  bool operator==(const LiveSettings&) const = default;
};

struct SessionSettings {
  std::vector<PanelSettings> panels;  ///< 1 to kMaxPanels
  LiveSettings knobs;  ///< `march` is replaced by each scene's, but for what a hand has turned of what is sent of a frame
  gl::Platform platform = gl::Platform::automatic;
  WarpResources resources;  ///< backend and onFallback; the rest is the session's
  JudgeMaker makeJudge = warpscope::makeJudge;
};

class Session {
 public:
  using TimePoint = Clock::TimePoint;

  /// `onNews` is called on any thread whenever update() has something to collect.
  Session(const SessionSettings& settings, const std::function<void()>& onNews);

  // --- Edits. Those of the same value do nothing.
  /// Opens a scene in the background; the one on show stays until it is there. The newest request wins and ends the one before it.
  void load(LoadJob job) { opening_.open(std::move(job)); }
  /// Shows the scene by that function from now on: the ground truth and copies of the volume at once, frames as they come. Throws UsageError for one that
  /// cannot be, or where it is the server's to choose.
  void setTransferFunction(TransferFunction function);
  /// Whether the scene on show is not shown by the transfer function any more that it was opened with.
  bool hasOwnFunction() const { return functionVersion_ != scenesFunctionVersion_; }
  /// Why setTransferFunction() would refuse any; empty if it would not.
  std::string whyFunctionIsFixed() const;
  /// Gives up opening; the scene on show stays.
  void cancelLoad() { opening_.cancel(); }
  /// Of all panels that have no camera of their own.
  void setView(const View& view) { view_.set(view); }
  /// Of the panel, if it has a camera of its own, or else of all that have none.
  void setView(size_t panel, const View& view);
  /// Lets the panel have a camera of its own, which begins where it is, or takes it away.
  void setOwnCamera(size_t panel, bool hasOwn);
  /// Measures all techniques on show by the newest frame, at the same angles (fair_measuring.h); panels may go on, but what they do costs time. Does nothing
  /// without a frame, or where nothing on show draws one; fair().error() says why not by a frame from before the transfer function changed.
  void measureNow();
  void cancelMeasuring() { fair_.cancel(); }
  const FairMeasuring& fair() const { return fair_; }
  /// Lets the linked camera move by itself from where it is, until it is moved otherwise. `speed`: times the usual one.
  void setMotion(CameraMotion motion, double speed = 1.0) { motion_.start(motion, speed); }
  const LiveMotion& motion() const { return motion_; }
  /// Records the linked camera's path anew, or ends that.
  void setRecording(bool isRecording) { motion_.setRecording(isRecording); }
  /// Records frames and the linked camera into a file from now on, in place of one that is there (frames/recording.h); `text` goes with it. Throws InputError
  /// where that cannot be written, an earlier one is still being written to it, or without a scene.
  void startRecording(const std::filesystem::path& file, const std::string& text);
  /// How many frames are not in the recording, because they came faster than they could be written, or went with their device.
  size_t stopRecording();
  bool isRecording() const { return recorder_ != nullptr; }
  /// Whether the end of one that was stopped is still on its way to its file.
  bool isWritingRecording() const { return !endedRecordings_.empty(); }
  /// Why the last recording is not whole, whether or not that was dismissed; empty if it is. Known of all of it after close().
  const std::string& recordingFailure() const { return recordingFailure_; }
  /// A recording that is on show in place of what a server sends; open while the scene is one.
  LivePlayback& playback() { return playback_; }
  const LivePlayback& playback() const { return playback_; }
  /// Writes the recording that is on show as a film or as pictures: by the techniques on show, side by side (replay_export.h), in place of
  /// one that is being written. Throws InputError without a recording, and as exportedAs(); what goes wrong later exporting() says.
  void startExport(const std::filesystem::path& path, const ExportLook& look = {});
  ReplayExport& exporting() { return exporting_; }
  const ReplayExport& exporting() const { return exporting_; }
  /// Why there is no ground truth of the scene on show; empty where there is, or no scene yet.
  std::string whyNoTruth() const { return opening_.current() ? opening_.current()->whyNoTruth : ""; }
  /// The link lets nothing pass for so long, on top of what is simulated.
  void beginOutage(std::chrono::milliseconds length, TimePoint now) { outageEnd_ = now + (outageLength_ = length); }
  bool hasOutage(TimePoint now) const { return now < outageEnd_; }
  /// What is simulated of what is on show: of a recording, what was when it was recorded.
  LinkSign linkSign(TimePoint now) const;
  void setKnobs(const LiveSettings& knobs);
  /// Those that the panel has for itself (Knob::isOfPanel); others have no effect.
  void setPanelKnobs(size_t panel, const KnobValues& knobs) { panels_[panel].setKnobs(knobs); }
  /// A panel after the last. False if there are kMaxPanels.
  bool addPanel(const PanelSettings& settings);
  /// False if it is the only one. Panels after it move up.
  bool removePanel(size_t panel);
  /// Takes the panel out of the row and puts it in at another place.
  void movePanel(size_t from, size_t to);
  /// Whether the panel is drawn at all.
  void setHidden(size_t panel, bool isHidden);
  /// All that is chosen for one panel.
  void setPanel(size_t panel, const PanelSettings& settings);
  /// As many panels as those, 1 to kMaxPanels, each by its settings.
  void setPanels(const std::vector<PanelSettings>& panels);
  /// The same where it is known which panels these are, by their ids: those that are there keep what they have besides (a camera of their own), those that are not come back.
  void setPanels(const std::vector<PanelSettings>& panels, const std::vector<uint64_t>& ids);
  /// The panel does not choose by itself any more.
  void setTechnique(size_t panel, const WarpDescriptor& technique);
  /// Lets the panel choose: of a sweep that was handed over, or of what was on show so far. What the server does stays as the knobs say.
  void setAutomatic(size_t panel) { panels_[panel].setAutomatic(true); }
  /// A sweep to choose by; null for none.
  void setFront(std::shared_ptr<const AutoChoice> front) { front_ = std::move(front); }
  /// What the panel shows in place of its picture, or the picture itself. `range`: what the upper end of the content's ramp stands for (content.h).
  void setContent(size_t panel, PictureContent content, std::optional<float> range = {}) { panels_[panel].setContent(content, range); }
  /// Whether somebody looks at what the stages of the march cost: it is measured only then.
  void setShowsPlan(bool shows) { showsPlan_ = shows; }
  /// Looks at the ray behind a pixel of the panel's picture: live_ray.h, as long as the panel is there. Nothing: at none.
  void lookAt(std::optional<LookedAt> pixel) { lookedAt_ = pixel; }
  /// What a configuration says: what it does not stays as it is.
  enum class Says { all, whatSweepsGoThrough };
  /// Takes over that configuration's technique for the panel, and the knobs that it depends on for all.
  void choose(size_t panel, const Configuration& configuration, Says says = Says::all);
  /// Area for each panel's picture, in screen pixels.
  void setPanelSize(const glm::uvec2& sizePx);
  /// Back to the scene's first: of the panel's own camera, or of all that have none.
  void resetView(size_t panel);
  void resetView();
  void dismissErrors();

  /// Collects results and hands out work. Call it once for each frame of the display; it never waits. True if anything happened.
  bool update(TimePoint now);

  /// Asks all threads to end, and waits until they have or `patience` is over. False if a scene that cannot be interrupted is still
  /// being read; then destroying the session waits for it.
  bool close(std::chrono::milliseconds patience);

  // --- State.
  /// Null until the first scene is there.
  const Scene* scene() const { return opening_.current() ? &opening_.current()->scene : nullptr; }
  /// How many scenes there have been, the one on show among them.
  uint64_t sceneCount() const { return sceneCount_; }
  /// By what the scene on show can be opened again; nothing if it cannot.
  const std::optional<SceneOrigin>& origin() const { return opening_.origin(); }
  /// Name of the scene that is being opened; empty if none is.
  const std::string& loading() const { return opening_.name(); }
  /// Why the last scene, view, frame or ground truth could not be had; empty if it could.
  const std::string& error() const;
  const View& view() const { return view_.get(); }
  const View& view(size_t panel) const { return viewOf(panels_[panel]).get(); }
  bool hasOwnCamera(size_t panel) const { return panels_[panel].ownCamera() != nullptr; }
  const LiveSettings& knobs() const { return knobs_; }
  size_t panelCount() const { return panels_.size(); }
  const Panel& panel(size_t index) const { return panels_[index].shown(); }
  /// Of the panel with that id; nothing if it is gone.
  std::optional<size_t> placeOf(uint64_t id) const;
  /// Accuracy against time of what was on show since the scene was opened. Pictures are timed when everything has come to rest, one panel after the other.
  const LiveFront& liveFront() const { return liveFront_; }
  /// Frames, and how they come.
  const FrameRequests& frames() const { return frames_; }
  const LiveGroundTruth& groundTruth() const { return truth_; }
  /// What the panel's picture is judged against.
  const LiveGroundTruth& groundTruth(size_t panel) const { return truthOf(panels_[panel]); }
  /// What the newest frame's march has to do, and what that costs.
  const LivePlan& plan() const { return plan_; }
  bool showsPlan() const { return showsPlan_; }
  const std::optional<LookedAt>& lookedAt() const { return lookedAt_; }
  /// What there is along the ray that is looked at.
  const LiveRay& ray() const { return ray_; }
  /// Of the connection to the server; nothing without a scene.
  std::optional<SourceStatus> sourceStatus() const;
  /// Size of the panels' pictures and of the server's images; 0 until a panel has a size.
  glm::uvec2 pictureSize() const { return view_.pictureSize(); }
  glm::uvec2 serverSize() const { return view_.sizeOfSide(knobs_.serverSidePx); }
  /// Whether the newest frame has fewer pixels than that, so that it takes no more bytes than it may.
  bool isFrameSmaller() const { return knobs_.transport.frameKib > 0 && frames_.newest() && longerSide(frames_.newest()->camera) < knobs_.serverSidePx; }
  /// How many screen pixels a picture's pixel is wide.
  uint32_t screenPixels() const { return view_.screenPixels(); }
  /// For how long the camera of the frame in `panel` has not been the current one any more: 0 while it is. Nothing without a frame.
  std::optional<double> ageMs(size_t panel, TimePoint now) const;
  /// Between the newest frame's camera and that of the panel's view (angleBetweenDeg). Nothing without a frame.
  std::optional<double> angleDeg(size_t panel) const;

 private:
  /// What is drawn for the window goes after the window itself, and what is marched after that. Null where there are cores for all of it.
  static std::shared_ptr<Crew> makeCrew(int nice);

  const LiveView& viewOf(const LivePanel& panel) const { return panel.ownCamera() != nullptr ? panel.ownCamera()->view : view_; }
  const LiveGroundTruth& truthOf(const LivePanel& panel) const { return panel.ownCamera() != nullptr ? panel.ownCamera()->truth : truth_; }
  /// The user's, with an outage while there is one.
  TransportSettings transportAt(TimePoint now) const;
  ReferenceJob truthFrom(const LiveView& view) const;
  LivePanel makePanel(const PanelSettings& settings, uint64_t id);
  void addPanel(LivePanel panel);
  /// Lets panels go that were removed, once their threads have ended.
  void bury();
  /// What the techniques on show need of a frame.
  std::vector<TechniqueInUse> techniquesInUse() const;

  // Each is true if anything happened.
  bool takeScene();
  bool followOwnCamera(LivePanel& panel, TimePoint now);
  bool followFrames(TimePoint now);
  /// The scene, marched by `display`, by that function; what was measured was of the one before.
  void showFunction(TransferFunction function, MarcherPtr display);
  /// Shows the scene by the function that a recording says it had then.
  void followRecordedFunction();
  bool followRay();
  void record(TimePoint now);
  /// Collects why recordings that have ended are not whole; waits for those that are still written, but not beyond `until`. True if one had ended.
  bool takeEndedRecordings(std::chrono::steady_clock::time_point until);
  bool takePicture(LivePanel& panel, size_t index);
  void seeMoving(const LivePanel& panel, const WarpResult& result);
  bool followMoving(TimePoint now);
  bool takeErrors(LivePanel& panel, TimePoint now);
  bool postJob(size_t index);
  /// Of the technique that a panel shows.
  WarpSettings warpSettingsOf(size_t panel) const;

  bool chooseTechnique(size_t panel);
  /// Turns the knobs that the panel has for itself as the configuration has them.
  void takePanelKnobs(LivePanel& panel, const Configuration& configuration);
  void useTechnique(LivePanel& panel, const WarpDescriptor& technique);
  /// True if nothing is under way, and what is on show is what was wanted and is judged: what is timed now is timed alone.
  bool isAtRest() const;
  void takeTime(size_t index, const WarpResult& result);
  /// Whether what was asked for is of the transfer function of now: a frame from before is wrong beside today's ground truth, and no technique's fault. Recorded frames know no versions.
  bool isOfFunctionNow(const WantedFrame& asked) const { return playback_.isOpen() || asked.functionVersion == functionVersion_; }
  /// Nothing where it is not known, or where no configuration did it: it gets no point in the plot.
  std::optional<Configuration> configurationOf(const WarpResult& result) const;

  const gl::Platform platform_;
  const WarpResources resources_;
  const JudgeMaker makeJudge_;
  const std::function<void()> onNews_;
  const std::shared_ptr<Crew> marchCrew_ = makeCrew(Crew::kOfMarches);  // of what is marched and judged here beside frames, and of loads
  LiveSettings knobs_;
  LiveView view_;
  glm::uvec2 areaPx_{0};  // of each panel's picture
  SceneOpening opening_;
  FrameRequests frames_;
  LiveGroundTruth truth_;
  LivePlan plan_;
  bool showsPlan_ = false;
  LiveRay ray_;
  FairMeasuring fair_;
  MovingErrors moving_;
  ReplayExport exporting_;
  std::optional<LookedAt> lookedAt_;
  std::vector<LivePanel> panels_;
  std::vector<LivePanel> removed_;  // whose threads have not ended yet
  LiveMotion motion_;
  LivePlayback playback_;
  std::unique_ptr<RecordingWriter> recorder_;
  std::filesystem::path recordingFile_;
  std::optional<TimePoint> recordingSince_;  // nothing until its first view
  std::optional<uint64_t> recordedFrame_;    // the last one's request
  TransferFunction recordedFunction_;        // the last one
  LinkSign recordedLink_;                    // likewise
  static constexpr std::chrono::milliseconds kRecordingPatience{30000};  // when the window closes: what was recorded is not given up for the sake of a second
  struct EndedRecording {
    std::filesystem::path file;
    std::future<std::string> trouble;  // why it is not whole
  };
  std::vector<EndedRecording> endedRecordings_;  // that are still written
  std::string recordingError_, recordingFailure_;
  TimePoint outageEnd_{};
  std::chrono::milliseconds outageLength_{0};
  uint64_t lastPanelId_ = 0;
  uint64_t sceneCount_ = 0;
  MarchSettings ownMarch_;  // of the scene on show, as it began
  uint64_t functionVersion_ = 0;  ///< of all scenes' transfer functions, the newest
  uint64_t scenesFunctionVersion_ = 0;  ///< when the scene on show began
  PictureTiming timing_;
  LiveFront liveFront_;
  std::shared_ptr<const AutoChoice> front_;
};

}  // namespace warpscope
