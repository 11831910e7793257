// Axes and their products.
// See sweep_plan.h.
#include "app/experiment/sweep_plan.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/base/range.h"
#include "render/warp/multihit/nearest_hits.h"

namespace warpscope {
namespace {

constexpr Range kAngleDegRange{-360.0, 360.0};
constexpr Range kSpeedDegPerSRange{0.0, 3600.0};
constexpr Range kInstantsRange{1, 100};
constexpr Range kDrawsRange{1, 1000};

double numberOf(const std::string& text, const Range& range, std::string_view name) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size())
    throw UsageError("'" + text.substr(0, 40) + "' is no number; " + std::string(name) + " must be " + rangeText(range));
  requireRange(number, range, name);
  return number;
}

int wholeOf(const std::string& text, const Range& range, std::string_view name) {
  const double number = numberOf(text, range, name);
  if (number != std::floor(number)) throw UsageError(std::string(name) + " must be a whole number, not " + text.substr(0, 40));
  return static_cast<int>(number);
}

template <class Table>
auto namedOf(const std::string& text, const Table& table, std::string_view kind) {
  if (const auto* entry = findNamed(table, text)) return entry->value;
  throw UsageError(unknownNameIn(table, kind, text));
}

SweepLink linkOf(const std::string& text) {
  try {
    return {text, net::parseLinkSettings(text)};
  } catch (const net::LinkSettingsError& error) {
    throw UsageError("link " + text.substr(0, 80) + ": " + error.what());
  }
}

/// Replaces `values` by what `read` makes of each text, each value once.
template <class Value, class Read>
void replace(std::vector<Value>& values, std::span<const std::string> texts, const Read& read) {
  values.clear();
  for (const std::string& text : texts) {
    const Value value = read(text);
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }
}

using Texts = std::span<const std::string>;

constexpr SweepAxis kAxes[] = {
    {"techniques", "--techniques", "Techniques, by name", ',', 64,
     [](SweepPlan& plan, Texts texts) { replace(plan.techniques, texts, [](const std::string& text) { return &findWarp(text); }); }},
    {"heuristics", "--heuristics", "Heuristics, by name", ',', 64,
     [](SweepPlan& plan, Texts texts) {
       replace(plan.heuristics, texts, [](const std::string& text) { return namedOf(text, kHeuristics, "heuristic"); });
     }},
    {"radii", "--radii", "Radius policies, by name", ',', 64,
     [](SweepPlan& plan, Texts texts) {
       replace(plan.radii, texts, [](const std::string& text) { return namedOf(text, kRadiusPolicies, "radius policy"); });
     }},
    {"radiusScales", "--radius-scales", "Factors on radii", ',', 64,
     [](SweepPlan& plan, Texts texts) {
       replace(plan.radiusScales, texts, [](const std::string& text) { return static_cast<float>(numberOf(text, kRadiusScaleRange, "a radius scale")); });
     }},
    {"pointSizes", "--point-sizes", "Sizes of points in pixels", ',', 64,
     [](SweepPlan& plan, Texts texts) {
       replace(plan.pointSizes, texts, [](const std::string& text) { return wholeOf(text, {1, 16}, "a point size"); });
     }},
    {"hits", "--hit-counts", "Samples blended along a ray", ',', 64,
     [](SweepPlan& plan, Texts texts) {
       replace(plan.hits, texts, [](const std::string& text) { return wholeOf(text, {1, kMaxHits}, "the hits along a ray"); });
     }},
    {"steps", "--steps", "Distances of samples along a ray, voxels", ',', 64,
     [](SweepPlan& plan, Texts texts) {
       replace(plan.steps, texts, [](const std::string& text) { return static_cast<float>(numberOf(text, kStepRange, "a step")); });
     }},
    {"serverSides", "--server-sides", "Longer sides of the server's image, pixels", ',', 64,
     [](SweepPlan& plan, Texts texts) {
       replace(plan.serverSides, texts, [](const std::string& text) { return static_cast<uint32_t>(wholeOf(text, kServerSideRange, "a server's side")); });
     }},
    {"codecs", "--codecs", "raw, lossless, jpeg1 to jpeg100", ',', 64,
     [](SweepPlan& plan, Texts texts) { replace(plan.codecs, texts, [](const std::string& text) { return codecOfWord(text); }); }},
    {"angles", "--angles", "Degrees that the camera is turned by, away from the frame's", ',', 256,
     [](SweepPlan& plan, Texts texts) {
       replace(plan.anglesDeg, texts, [](const std::string& text) { return numberOf(text, kAngleDegRange, "an angle"); });
     }},
    {"links", "--links", "Links behind which the camera moves, as --link, joined by ';'; none: no link, but each stage's own time", ';', 64,
     [](SweepPlan& plan, Texts texts) { replace(plan.links, texts, linkOf); }},
    {"speedDegPerS", "--speed", "Degrees a second of that motion", ',', 1,
     [](SweepPlan& plan, Texts texts) { plan.speedDegPerS = numberOf(texts[0], kSpeedDegPerSRange, "the speed"); }},
    {"instants", "--instants", "How many instants of the motion are looked at", ',', 1,
     [](SweepPlan& plan, Texts texts) { plan.instants = wholeOf(texts[0], kInstantsRange, "the instants"); }},
    {"draws", "--draws", "Draws that are timed, after one that is not", ',', 1,
     [](SweepPlan& plan, Texts texts) { plan.draws = wholeOf(texts[0], kDrawsRange, "the draws"); }},
};

template <class Value, class Write>
nlohmann::json listed(const std::vector<Value>& values, const Write& write) {
  nlohmann::json list = nlohmann::json::array();
  for (const Value& value : values) list.push_back(write(value));
  return list;
}

constexpr auto kItself = [](const auto& value) { return value; };
constexpr auto kItsName = [](const auto& value) { return nameOf(value); };

}  // namespace

std::span<const SweepAxis> sweepAxes() { return kAxes; }

SweepPlan defaultPlan(const MarchSettings& base, uint32_t width, uint32_t height) {
  SweepPlan plan;
  plan.base = base;
  for (const WarpDescriptor& technique : warpRegistry()) plan.techniques.push_back(&technique);
  plan.heuristics = {Heuristic::gradient, Heuristic::median, Heuristic::expected};
  plan.radii = {RadiusPolicy::voxel, RadiusPolicy::opacity};
  plan.radiusScales = {base.sample.radiusScale};
  plan.pointSizes = {1, 2, 3};
  plan.hits = {2};
  plan.steps = {base.render.step};
  plan.serverSides = {std::max(width, height)};
  if (plan.serverSides[0] > 1) plan.serverSides.push_back(plan.serverSides[0] / 2);
  plan.codecs = {CodecSettings{}};
  plan.anglesDeg = {0.0, 5.0, 10.0, 25.0, 45.0};
  plan.links = {linkOf("4g")};
  return plan;
}

SweepPlan quickPlan(const MarchSettings& base, uint32_t width, uint32_t height, double angleDeg) {
  SweepPlan plan = defaultPlan(base, width, height);
  std::erase_if(plan.techniques, [](const WarpDescriptor* technique) { return !technique->usesFrame; });
  plan.serverSides.resize(1);
  plan.pointSizes = {2};
  plan.anglesDeg = {angleDeg};
  plan.links.clear();
  plan.draws = 2;
  return plan;
}

void applyPlanFile(const Node& root, SweepPlan& plan) {
  std::vector<std::string_view> keys;
  for (const SweepAxis& axis : kAxes) keys.push_back(axis.key);
  root.requireObject(keys);
  for (const SweepAxis& axis : kAxes) {
    const std::optional<Node> node = root.find(axis.key);
    if (!node) continue;
    const auto textOf = [](const Node& value) { return value.isString() ? value.string() : numberText(value.number(-1e12, 1e12)); };
    std::vector<std::string> texts;
    if (node->isArray())
      for (const Node& element : node->elements(axis.key == "links" ? 0 : 1, axis.most)) texts.push_back(textOf(element));
    else
      texts.push_back(textOf(*node));
    try {
      axis.set(plan, texts);
    } catch (const UsageError& error) {
      node->fail(std::string("cannot be used: ") + error.what());
    }
  }
}

void applyPlanOption(const SweepAxis& axis, std::string_view text, SweepPlan& plan) {
  std::vector<std::string> texts;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(axis.separator, begin), text.size());
    texts.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  const std::string option(axis.option);
  if (texts.size() > axis.most) throw UsageError(option + ": at most " + std::to_string(axis.most) + (axis.most == 1 ? " value" : " values"));
  try {
    axis.set(plan, texts);
  } catch (const UsageError& error) {
    throw UsageError(option + ": " + error.what());
  }
}

std::vector<Configuration> configurationsOf(const SweepPlan& plan) {
  std::vector<Configuration> configurations;
  std::set<std::string> keys;
  const auto add = [&](Configuration configuration) {
    configuration = normalized(configuration);
    if (keys.insert(keyOf(configuration)).second) configurations.push_back(configuration);
  };
  Configuration configuration;
  configuration.march = plan.base;
  const auto each = [](const auto& values, auto& member, const auto& inner) {
    for (const auto& value : values) {
      member = value;
      inner();
    }
  };
  MarchSettings& march = configuration.march;
  each(plan.techniques, configuration.technique, [&] {
    each(plan.heuristics, march.sample.heuristic, [&] {
      each(plan.radii, march.sample.radiusPolicy, [&] {
        each(plan.radiusScales, march.sample.radiusScale, [&] {
          each(plan.pointSizes, configuration.pointSize, [&] {
            each(plan.hits, configuration.hits, [&] {
              each(plan.steps, march.render.step, [&] {
                each(plan.serverSides, configuration.serverSidePx, [&] {
                  each(plan.codecs, configuration.codec, [&] { add(configuration); });
                });
              });
            });
          });
        });
      });
    });
  });

  Configuration baseline;
  baseline.march = plan.base;
  baseline.march.render.step = plan.steps.front();
  baseline.march.sample.radiusScale = 1.0f;
  baseline.march.sample.radiusPolicy = RadiusPolicy::voxel;
  baseline.serverSidePx = *std::max_element(plan.serverSides.begin(), plan.serverSides.end());
  baseline.codec = plan.codecs.front();
  baseline.technique = &findWarp("spheres");
  baseline.march.sample.heuristic = Heuristic::gradient;
  add(baseline);
  baseline.technique = &findWarp("points");
  baseline.march.sample.heuristic = Heuristic::median;
  baseline.pointSize = 2;
  add(baseline);
  return configurations;
}

nlohmann::json toJson(const SweepPlan& plan) {
  return {{"techniques", listed(plan.techniques, [](const WarpDescriptor* technique) { return technique->name; })},
          {"heuristics", listed(plan.heuristics, kItsName)},
          {"radii", listed(plan.radii, kItsName)},
          {"radiusScales", listed(plan.radiusScales, kItself)},
          {"pointSizes", listed(plan.pointSizes, kItself)},
          {"hits", listed(plan.hits, kItself)},
          {"steps", listed(plan.steps, kItself)},
          {"serverSides", listed(plan.serverSides, kItself)},
          {"codecs", listed(plan.codecs, codecWord)},
          {"angles", listed(plan.anglesDeg, kItself)},
          {"links", listed(plan.links, [](const SweepLink& link) { return link.name; })},
          {"speedDegPerS", plan.speedDegPerS},
          {"instants", plan.instants},
          {"draws", plan.draws}};
}

}  // namespace warpscope
