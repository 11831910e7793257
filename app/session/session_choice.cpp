// The part of a session that lets panels choose their technique by themselves.
// See session.h and experiment/auto_choice.h.
#include "app/session/session.h"

namespace warpscope {
namespace {

/// What draws while nothing is known: the paper's picture in the least time.
constexpr std::string_view kUnmeasured = "splats";
/// How many times the error of the best a panel's technique may have and stay.
constexpr double kWorthChanging = 1.1;

/// What was on show at this size, as rows of a sweep. Whoever chooses takes each angle by itself: all points count, whether they are ranked or not.
std::vector<SweepRow> rowsOf(const LiveFront& live) {
  std::vector<SweepRow> rows;
  for (const LiveFront::Point& point : live.points())
    for (const LiveFront::Bucket& bucket : point.buckets) {
      if (point.standing == LiveFront::Standing::otherSize) continue;
      SweepRow& row = rows.emplace_back();
      row.configuration = point.configuration;
      row.angleDeg = bucket.fromDeg + 0.5 * LiveFront::kBucketDeg;
      row.errors.flip = bucket.flip;
      row.draw.medianMs = bucket.frameMs;
    }
  return rows;
}

/// Whether a frame that was marched with `settings` can be drawn as `configuration` was.
bool fits(const Configuration& configuration, const MarchSettings& settings) {
  for (const MarchKnob& row : marchKnobs())
    if (configuration.technique->dependsOn(row) && row.matters(settings) && row.get(configuration.march) != row.get(settings)) return false;
  return true;
}

}  // namespace

void Session::setAutomatic(size_t panel) { panels_[panel].isAutomatic = true; }

void Session::chooseTechnique(size_t index) {
  if (!frame_) return;
  Panel& panel = panels_[index];
  const Camera camera = cameraOfSize(pictureSize());
  ChoiceInput input{frame_, camera, knobs_.budgetMs, front_, front_ ? 0 : liveFront_.version()};
  if (input == choiceInputs_[index]) return;
  choiceInputs_[index] = std::move(input);
  const AutoChoice live(front_ ? std::vector<SweepRow>() : rowsOf(liveFront_));
  const AutoChoice& known = front_ ? *front_ : live;
  const uint32_t sidePx = front_ ? front_->largestSidePx() : knobs_.serverSidePx;
  const double angleDeg = angleBetweenDeg(frame_->camera, camera);
  const auto mayBe = [&](const Configuration& configuration) {
    return configuration.serverSidePx == sidePx && fits(configuration, frame_->settings);
  };
  auto choice = known.choose(angleDeg, knobs_.budgetMs, mayBe);
  if (choice && panel.choice && !(*panel.choice == choice->configuration)) {
    // A technique that is hardly worse stays: taking turns at each frame's arrival would cost more than it gains.
    const auto before = known.choose(angleDeg, knobs_.budgetMs, [&](const Configuration& configuration) {
      return configuration == *panel.choice && mayBe(configuration);
    });
    const bool isKept = before && before->frameMs <= knobs_.budgetMs && before->flip <= kWorthChanging * choice->flip;
    if (isKept) choice = before;
  }
  panel.choice.reset();
  if (choice) {
    panel.choice = choice->configuration;
    panel.choiceText = choice->reason;
  } else {
    panel.choiceText = std::string(kUnmeasured) + ": nothing was measured yet with this frame's heuristic, radius and step";
  }
  useTechnique(index, choice ? *choice->configuration.technique : findWarp(kUnmeasured));
}

}  // namespace warpscope
