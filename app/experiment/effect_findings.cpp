// Pairs of configurations that differ in one effect alone.
// See effect_findings.h.
#include "app/experiment/effect_findings.h"

#include <algorithm>
#include <cstdio>
#include <map>

#include "render/march/march_knobs.h"

namespace warpscope {
namespace {

/// Means over pairs.
struct Change {
  double without = 0.0, with = 0.0;
  size_t pairs = 0;

  void add(double theWithout, double theWith) {
    without += (theWithout - without) / static_cast<double>(++pairs);
    with += (theWith - with) / static_cast<double>(pairs);
  }
};

std::string sentenceOf(const MarchKnob& row, const std::vector<Summary>& summaries) {
  const auto valueOf = [&](const Summary& summary) { return row.get(summary.configuration.march); };
  const auto [least, greatest] = std::ranges::minmax(summaries, {}, valueOf);
  const double low = valueOf(least), high = valueOf(greatest);
  if (low == high) return "";
  std::map<std::string, const Summary*> ofLow;
  for (const Summary& summary : summaries)
    if (valueOf(summary) == low) ofLow[keyOf(summary.configuration)] = &summary;
  Change serverMs;
  std::vector<std::pair<std::string_view, Change>> flips;  // of each technique, in the order of the summaries
  for (const Summary& summary : summaries) {
    if (valueOf(summary) != high || !summary.configuration.technique->usesFrame) continue;
    Configuration other = summary.configuration;
    row.set(other.march, low);
    const auto pair = ofLow.find(keyOf(other));
    if (pair == ofLow.end()) continue;
    serverMs.add(pair->second->serverMs, summary.serverMs);
    const std::string_view name = summary.configuration.technique->name;
    auto place = std::ranges::find(flips, name, &std::pair<std::string_view, Change>::first);
    if (place == flips.end()) place = flips.insert(place, {name, {}});
    place->second.add(pair->second->flip, summary.flip);
  }
  if (serverMs.pairs == 0) return "";
  char text[200];
  std::snprintf(text, sizeof text, "%s at %s instead of %s: the server takes %.3g ms instead of %.3g", std::string(row.knob->label).c_str(),
                textOf(*row.knob, high).c_str(), textOf(*row.knob, low).c_str(), serverMs.with, serverMs.without);
  std::string sentence = text;
  for (size_t i = 0; i < flips.size(); ++i) {
    const auto& [name, change] = flips[i];
    std::snprintf(text, sizeof text, "%s %s is off by %+.4f (FLIP %.4f instead of %.4f)", i == 0 ? ";" : ",", std::string(name).c_str(), change.with - change.without,
                  change.with, change.without);
    sentence += text;
  }
  return sentence + ".\n";
}

}  // namespace

std::string effectSentences(const std::vector<Summary>& summaries) {
  std::string sentences;
  if (summaries.empty()) return sentences;
  for (const MarchKnob& row : marchKnobs())
    if (row.knob->owner == KnobOwner::effect) sentences += sentenceOf(row, summaries);
  return sentences;
}

}  // namespace warpscope
