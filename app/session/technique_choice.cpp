// What may be chosen, and when it is worth changing.
// See technique_choice.h.
#include "app/session/technique_choice.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

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

/// Whether a frame that was marched with `settings`, or the next one, can be drawn as `configuration` was.
bool fits(const Configuration& configuration, const MarchSettings& settings, const MarchSettings& askable) {
  const auto isOther = [&](const MarchText& text) { return text.matters(settings) && text.get(configuration.march) != text.get(settings); };
  return std::ranges::none_of(marchTexts(), isOther) && std::ranges::all_of(marchKnobs(), [&](const MarchKnob& row) {
    if (!configuration.technique->dependsOn(row, configuration.knobs) || !row.matters(settings)) return true;
    const double wanted = row.get(configuration.march);
    const bool isOnTop = row.shapes == FramePart::segments || row.shapes == FramePart::proxy;
    return wanted == row.get(settings) || (isOnTop && wanted == row.get(askable));
  });
}

}  // namespace

std::optional<TechniqueChoice::Choice> TechniqueChoice::choose(const Input& input, const LiveFront& live) {
  Seen seen{input.frame, input.askable, input.camera, input.budgetMs, input.front, input.front ? 0 : live.version()};
  if (seen_ == seen) return std::nullopt;
  seen_ = std::move(seen);

  const AutoChoice liveChoice(input.front ? std::vector<SweepRow>() : rowsOf(live));
  const AutoChoice& known = input.front ? *input.front : liveChoice;
  const uint32_t sidePx = input.front ? input.front->largestSidePx() : input.serverSidePx;
  const double angleDeg = angleBetweenDeg(input.frame->camera, input.camera);
  const auto mayBe = [&](const Configuration& configuration) {
    return configuration.serverSidePx == sidePx && fits(configuration, input.frame->settings, input.askable);
  };
  auto best = known.choose(angleDeg, {.ms = input.budgetMs}, mayBe);
  if (best && last_ && !(*last_ == best->configuration)) {
    // A technique that is hardly worse stays: taking turns at each frame's arrival would cost more than it gains.
    const auto before = known.choose(angleDeg, {.ms = input.budgetMs}, [&](const Configuration& configuration) {
      return configuration == *last_ && mayBe(configuration);
    });
    const bool isKept = before && before->frameMs <= input.budgetMs && before->flip <= kWorthChanging * best->flip;
    if (isKept) best = before;
  }
  last_.reset();
  if (!best)
    return Choice{&findWarp(kUnmeasured), std::nullopt,
                  std::string(kUnmeasured) + ": nothing was measured yet with this frame's heuristic, radius and step"};
  last_ = best->configuration;
  return Choice{best->configuration.technique, best->configuration, best->reason};
}

}  // namespace warpscope
