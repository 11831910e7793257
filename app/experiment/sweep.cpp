// Running a sweep.
// See sweep.h.
#include "app/experiment/sweep.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "app/experiment/averages.h"
#include "app/experiment/ground_truth.h"
#include "app/experiment/oracle.h"
#include "app/experiment/measuring.h"
#include "app/experiment/motion.h"
#include "app/frames/backend.h"
#include "app/frames/frame_fetch.h"
#include "render/base/error.h"
#include "render/metrics/flicker.h"
#include "render/warp/kept_frames.h"

namespace warpscope {
namespace {

/// Seconds from the motion's begin to the first instant that is looked at, by when the first frames are long there, and between instants:
/// not in step with whole frames of any rate.
constexpr double kLatestInstantS = 4096.0, kFramesBefore = 3.0;
constexpr double kFirstInstantS = 2.0, kBetweenInstantsS = 0.6180339887;

/// A frame as the client gets it, and what that took.
struct Served {
  SampleFramePtr frame;
  FrameBytes bytes;
  SweepCost cost;  ///< bytes are each technique's own
};

/// All that a frame of one camera depends on.
struct FrameKind {
  MarchSettings march;
  uint32_t serverSidePx = 0;
  CodecSettings codec;
  bool operator==(const FrameKind&) const = default;
};

/// Serves frames through the codec; keeps the march of the last one, which the next codec shares.
class Server {
 public:
  Server(MarcherPtr marcher, const Measuring& measuring)
      : marcher_(std::move(marcher)), measuring_(measuring), codec_(makeTiledCoder(marcher_->backend())) {}

  Served serve(const Camera& camera, const Configuration& configuration) {
    if (!marched_.frame || !(camera == camera_) || !(configuration.march == settings_)) {
      marched_ = measureMarch(measuring_, *marcher_, camera, configuration.march);
      camera_ = camera;
      settings_ = configuration.march;
    }
    const MeasuredCoding coding = measureCoding(measuring_, codec_, marched_.frame, configuration.codec);
    Served served;
    served.frame = coding.frame;
    served.cost.samples = coding.frame->size();
    served.bytes = coding.bytes;
    served.cost.march = marched_.march;
    served.cost.compact = marched_.compact;
    served.cost.copy = marched_.copy;
    served.cost.encode = coding.encode;
    served.cost.decode = coding.decode;
    return served;
  }

  /// As above, without timing anything.
  SampleFramePtr frame(const Camera& camera, const Configuration& configuration) {
    return fetchHere(marcher_, configuration.codec)(camera, configuration.march, measuring_.withinRuns).frame;
  }

 private:
  const MarcherPtr marcher_;
  const Measuring measuring_;
  FrameCodec codec_;
  MeasuredMarch marched_;
  Camera camera_;
  MarchSettings settings_;
};

}  // namespace

class Sweep::Run {
 public:
  Run(const Scene& scene, const WarpResources& resources, const SweepSettings& settings, const std::stop_token& stop)
      : scene_(scene), resources_(resources), settings_(settings), stop_(stop), measuring_(settings.plan.draws, stop), server_(resources.marcher, measuring_),
        truth_(scene, resources.marcher, truthOf(settings.plan), settings.width, settings.height) {}

  std::vector<SweepRow> measure(const Configuration& configuration) {
    const SweepPlan& plan = settings_.plan;
    const WarpSettings warpSettings = configuration.warp(settings_.warp);
    Warp& warp = warpOf(*configuration.technique);
    SweepCost cost;
    if (configuration.technique->usesFrame) {
      const Served served = servedFor(configuration);
      cost = served.cost;
      cost.bytes = drawsPictureAlone(*configuration.technique) ? pictureBytes(served.frame, scene_.background, configuration.codec)
                                                           : bytesFor(*configuration.technique, served.bytes);
      WarpSettings ofOne = warpSettings;
      ofOne.knobs.set(kKeepKnob, 1.0);  // those before were built when they came
      const MeasuredBuild build = measureBuild(measuring_, warp, served.frame, ofOne);
      cost.upload = build.upload;
      cost.build = build.build;
      follow(warp, served.frame, 0.0, configuration, warpSettings);
    }
    std::vector<SweepRow> rows;
    for (const double angleDeg : plan.anglesDeg) {
      const Truth& truth = truth_.at(angleDeg, stop_);
      SweepRow row;
      row.configuration = configuration;
      row.angleDeg = angleDeg;
      row.cost = cost;
      const MeasuredDraw drawn = measureDraw(measuring_, {warp, warpSettings, scene_.background}, truth.camera, image_);
      if (drawn.isOnDevice) warp.draw(truth.camera, warpSettings, image_, stop_);
      row.draw = drawn.draw;
      row.draws = plan.draws;
      const Seen& seen = truth_.seenAt(angleDeg, stop_);
      row.errors = truth.judge.errorsOf(image_, &seen.visibility);
      row.disoccludedFraction = seen.disoccludedFraction;
      rows.push_back(row);
    }
    return rows;
  }

  /// `still`: the configuration's rows without a link.
  std::vector<SweepRow> measureMoving(const Configuration& configuration, const SweepLink& link, const std::vector<SweepRow>& still) {
    const SweepPlan& plan = settings_.plan;
    const bool usesFrame = configuration.technique->usesFrame;
    std::vector<double> draws;
    for (const SweepRow& row : still) draws.push_back(row.draw.medianMs);

    SweepRow row = still.front();
    row.link = link.name;
    row.draw = {measuredOf(draws).medianMs, 0.0};  // of other views: they tell nothing of the spread
    MotionStages stages;
    stages.serverMs = row.cost.serverMs();
    stages.arrivalMs = row.cost.arrivalMs();
    stages.drawMs = row.draw.medianMs;
    stages.frameBytes = row.cost.bytes;
    // Not before frames come steadily. Doubled until then, so that configurations share the truths of their instants.
    double firstS = kFirstInstantS;
    const auto isSteadyAt = [&](double timeS) {
      const std::optional<double> firstFrameS = simulateMotion({timeS}, stages, link.settings).firstFrameS;
      return firstFrameS && kFramesBefore * *firstFrameS <= timeS;
    };
    while (firstS < kLatestInstantS && !isSteadyAt(firstS)) firstS *= 2.0;
    // Each instant, and the display's next picture.
    std::vector<double> instantsS;
    for (int i = 0; i < plan.instants; ++i) {
      instantsS.push_back(firstS + kBetweenInstantsS * i);
      instantsS.push_back(instantsS.back() + kDisplayPeriodS);
    }
    const Motion motion = simulateMotion(instantsS, stages, link.settings);

    const WarpSettings warpSettings = configuration.warp(settings_.warp);
    Warp& warp = warpOf(*configuration.technique);
    MeanErrors errors;
    double ageS = 0.0, flicker = 0.0;
    std::optional<double> frameRequestedS;
    for (size_t i = 0; i < motion.pictures.size(); i += 2) {
      FlickerMeter meter(scene_.background);
      for (const ShownPictureTimes& picture : {motion.pictures[i], motion.pictures[i + 1]}) {
        if (usesFrame && (!picture.hasFrame || frameRequestedS != picture.requestedS)) {
          frameRequestedS.reset();
          SampleFramePtr frame;
          if (picture.hasFrame) {
            frameRequestedS = picture.requestedS;
            frame = server_.frame(truth_.camera(plan.speedDegPerS * picture.requestedS, configuration.serverSidePx), configuration);
          }
          follow(warp, frame, plan.speedDegPerS * picture.requestedS, configuration, warpSettings);
        }
        warp.draw(truth_.camera(plan.speedDegPerS * picture.drawnForS), warpSettings, image_, stop_);
        const Truth& truth = truth_.at(plan.speedDegPerS * picture.shownS, stop_);
        meter.add(image_.color, truth.color);
        if (picture.shownS == motion.pictures[i].shownS) errors.add(truth.judge.errorsOf(image_));
      }
      const ShownPictureTimes& picture = motion.pictures[i];
      ageS += picture.shownS - (usesFrame ? picture.requestedS : picture.drawnForS);
      flicker += *meter.mean();
    }
    const double share = 1.0 / plan.instants;
    row.errors = errors.mean();
    row.ageMs = 1e3 * ageS * share;
    row.angleDeg = plan.speedDegPerS * ageS * share;
    row.flicker = flicker * share;
    row.framesPerSecond = usesFrame ? motion.framesPerSecond : 0.0;
    row.disoccludedFraction.reset();  // each instant has another frame
    return {row};
  }

  SweepFloor floorAt(double angleDeg) { return {angleDeg, truth_.floorAt(angleDeg, stop_)}; }

  std::vector<SweepBound> bounds() {
    const SweepPlan& plan = settings_.plan;
    Configuration configuration;
    configuration.technique = &findWarp("spheres");
    configuration.march.render = truthOf(plan);
    configuration.march.sample.segments = 16;
    configuration.codec.format = PayloadFormat::raw;
    configuration.codec.color = ColorCoding::lossless;
    double sidePx = 1.0;
    for (const double side : plan.values(kServerSideKnob)) sidePx = std::max(sidePx, side);
    configuration.serverSidePx = static_cast<uint32_t>(sidePx);
    const SampleFramePtr frame = server_.frame(truth_.camera(0.0, configuration.serverSidePx), configuration);
    Oracle oracle(frame, wholeCopyOf(*scene_.volume, scene_.transferFunction, stop_), scene_.background);
    std::vector<SweepBound> bounds;
    for (const double angleDeg : plan.anglesDeg) {
      const Truth& truth = truth_.at(angleDeg, stop_);
      const Seen& seen = truth_.seenAt(angleDeg, stop_);
      const WarpedImage dots = oracle.bestDots(truth.camera, truth.color, stop_);
      bounds.push_back({SweepBound::Kind::bestDot, angleDeg, truth.judge.errorsOf(dots, &seen.visibility)});
      bounds.push_back({SweepBound::Kind::perfectWarp, angleDeg, truth.judge.errorsOf(oracle.perfectlyWarped(truth.camera, stop_), &seen.visibility)});
    }
    return bounds;
  }

  std::vector<SweepPicture> pictures(const Configuration& configuration) {
    Warp& warp = warpOf(*configuration.technique);
    const WarpSettings warpSettings = configuration.warp(settings_.warp);
    if (configuration.technique->usesFrame) {
      const Camera camera = truth_.camera(0.0, configuration.serverSidePx);
      follow(warp, server_.frame(camera, configuration), 0.0, configuration, warpSettings);
    }
    std::vector<SweepPicture> pictures;
    for (const double angleDeg : settings_.plan.anglesDeg) {
      const Truth& truth = truth_.at(angleDeg, stop_);
      SweepPicture& picture = pictures.emplace_back();
      warp.draw(truth.camera, warpSettings, picture.image, stop_);
      picture.flip = truth.judge.errorsOf(picture.image, nullptr, &picture.flipMap).flip;
    }
    return pictures;
  }

 private:
  /// The truth has the finest step of all.
  static RenderSettings truthOf(const SweepPlan& plan) {
    RenderSettings render = plan.base.render;
    for (const double step : plan.values(kStepKnob)) render.step = std::min(render.step, static_cast<float>(step));
    return render;
  }

  /// Gives the technique a frame whose camera was turned by that angle, as a client has it that keeps frames (kept_frames.h): after those which it would have
  /// kept from a camera that came turning from smaller angles.
  void follow(Warp& warp, const SampleFramePtr& frame, double angleDeg, const Configuration& configuration, const WarpSettings& settings) {
    const int before = configuration.knobs.whole(kKeepKnob) - 1;
    if (frame && before > 0) {
      warp.setFrame(nullptr, settings, stop_);
      std::vector<SampleFramePtr> kept;
      for (int i = 0; i < before; ++i) {
        const double turnDeg = turnToNextKept(angleDeg, *frame, configuration.serverSidePx);
        if (turnDeg == 0.0) break;
        angleDeg -= turnDeg;
        kept.push_back(server_.frame(truth_.camera(angleDeg, configuration.serverSidePx), configuration));
      }
      for (auto one = kept.rbegin(); one != kept.rend(); ++one) warp.setFrame(*one, settings, stop_);
    }
    warp.setFrame(frame, settings, stop_);
  }

  /// By how much less a camera is turned that is the nearest to be kept beside one at that angle; 0 where none is: that turns on the spot, seen from above.
  double turnToNextKept(double angleDeg, const SampleFrame& frame, uint32_t sidePx) {
    constexpr double kStepDeg = 0.5, kMostDeg = 90.0;
    const Camera camera = truth_.camera(angleDeg, sidePx);
    for (double turnDeg = kKeptApartDeg; turnDeg <= kMostDeg; turnDeg += kStepDeg)
      if (apartDeg(truth_.camera(angleDeg - turnDeg, sidePx), camera, frame.quantization.bounds) >= kKeptApartDeg) return turnDeg;
    return 0.0;
  }

  /// Frames of one kind come one after the other.
  Served servedFor(const Configuration& configuration) {
    const FrameKind kind{configuration.march, configuration.serverSidePx, configuration.codec};
    if (!last_.frame || !(kind == lastKind_)) last_ = server_.serve(truth_.camera(0.0, kind.serverSidePx), configuration);
    lastKind_ = kind;
    return last_;
  }

  Warp& warpOf(const WarpDescriptor& technique) {
    std::unique_ptr<Warp>& warp = warps_[&technique];
    if (!warp) warp = makeWarp(technique, resources_);
    return *warp;
  }

  const Scene& scene_;
  const WarpResources resources_;
  const SweepSettings& settings_;
  const std::stop_token stop_;
  const Measuring measuring_;
  Server server_;
  GroundTruth truth_;
  std::map<const WarpDescriptor*, std::unique_ptr<Warp>> warps_;
  Served last_;
  FrameKind lastKind_;
  WarpedImage image_;
};

std::string SweepUnit::name() const { return keyOf(configuration) + (link == nullptr ? std::string() : " behind " + link->name); }

bool SweepUnit::hasRows(const std::vector<SweepRow>& rows, const SweepPlan& plan) const {
  if (rows.size() != (link == nullptr ? plan.anglesDeg.size() : 1)) return false;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (keyOf(rows[i].configuration) != keyOf(configuration) || rows[i].link != (link == nullptr ? std::string() : link->name)) return false;
    if (link == nullptr && rows[i].angleDeg != plan.anglesDeg[i]) return false;
  }
  return true;
}

std::vector<SweepUnit> unitsOf(const SweepPlan& plan) {
  std::vector<SweepUnit> units;
  for (const Configuration& configuration : configurationsOf(plan)) {
    units.push_back({configuration, nullptr});
    for (const SweepLink& link : plan.links) units.push_back({configuration, &link});
  }
  return units;
}

Sweep::Sweep(const Scene& scene, const WarpResources& resources, SweepSettings settings, std::stop_token stop)
    : settings_(std::move(settings)), stop_(std::move(stop)), run_(std::make_unique<Run>(scene, resources, settings_, stop_)) {}

Sweep::~Sweep() = default;

std::vector<SweepUnit> Sweep::unfinished(const SweepJournal& journal) const {
  std::vector<SweepUnit> units = unitsOf(settings_.plan);
  std::erase_if(units, [&](const SweepUnit& unit) {
    const std::vector<SweepRow>* done = journal.find(unit.name());
    return done != nullptr && unit.hasRows(*done, settings_.plan);
  });
  return units;
}

std::vector<SweepRow> Sweep::run(SweepJournal& journal, const Step& onStep) {
  // Configurations that take the same frame one after the other; those that stand still first, because the others need their times.
  std::vector<SweepUnit> order = unfinished(journal);
  const auto frameOf = [](const SweepUnit& unit) {
    return std::pair(unit.link != nullptr, frameKeyOf(unit.configuration));
  };
  std::stable_sort(order.begin(), order.end(), [&](const SweepUnit& a, const SweepUnit& b) { return frameOf(a) < frameOf(b); });
  for (const SweepUnit& unit : order) {
    if (stop_.stop_requested()) throw OperationCancelled();
    onStep(labelOf(unit.configuration) + (unit.link == nullptr ? std::string() : " behind " + unit.link->name));
    if (unit.link == nullptr)
      journal.add(unit.name(), run_->measure(unit.configuration));
    else
      journal.add(unit.name(), run_->measureMoving(unit.configuration, *unit.link, *journal.find(keyOf(unit.configuration))));
  }

  std::vector<SweepRow> rows;
  for (const SweepUnit& unit : unitsOf(settings_.plan)) {
    const std::vector<SweepRow>& ofUnit = *journal.find(unit.name());
    rows.insert(rows.end(), ofUnit.begin(), ofUnit.end());
  }
  return rows;
}

std::vector<SweepBound> Sweep::bounds() { return run_->bounds(); }

std::vector<SweepFloor> Sweep::floors() {
  std::vector<SweepFloor> floors;
  for (const double angleDeg : settings_.plan.anglesDeg) floors.push_back(run_->floorAt(angleDeg));
  return floors;
}

std::vector<SweepPicture> Sweep::pictures(const Configuration& configuration) { return run_->pictures(configuration); }

}  // namespace warpscope
