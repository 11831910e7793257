// Axes and their products.
// See sweep_plan.h.
#include "app/experiment/sweep_plan.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "render/base/error.h"
#include "render/base/range.h"
#include "render/warp/points_warp.h"

namespace warpscope {
namespace {

constexpr Range kAngleDegRange{-360.0, 360.0};
constexpr Range kSpeedDegPerSRange{0.0, 3600.0};
constexpr Range kInstantsRange{1, 100};
constexpr Range kDrawsRange{1, 1000};

double numberOf(const std::string& text, const Range& range, std::string_view name) {
  const double number = requireNumber(text, range, name);
  requireRange(number, range, name);
  return number;
}

int wholeOf(const std::string& text, const Range& range, std::string_view name) {
  const double number = numberOf(text, range, name);
  if (number != std::floor(number)) throw UsageError(std::string(name) + " must be a whole number, not " + text.substr(0, 40));
  return static_cast<int>(number);
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

/// The axis of one knob.
SweepAxis axisOf(const Knob& knob) {
  return {knob.axis.key, knob.axis.option, knob.axis.help, ',', 64, [&knob](SweepPlan& plan, Texts texts) {
            replace(plan.values(knob), texts, [&](const std::string& text) { return parseKnob(knob, text, "a " + std::string(knob.noun)); });
          }};
}

template <class Value, class Write>
nlohmann::json listed(const std::vector<Value>& values, const Write& write) {
  nlohmann::json list = nlohmann::json::array();
  for (const Value& value : values) list.push_back(write(value));
  return list;
}

constexpr auto kItself = [](const auto& value) { return value; };

/// The value that comes closest to the knob's default.
double closestToDefault(const KnobValuesAxis& axis) {
  return *std::min_element(axis.values.begin(), axis.values.end(), [&](double a, double b) {
    return std::abs(a - axis.knob->defaultValue) < std::abs(b - axis.knob->defaultValue);
  });
}

template <class Plan>
auto& valuesIn(Plan& plan, const Knob& knob) {
  for (auto& axis : plan.knobs)
    if (axis.knob == &knob) return axis.values;
  throw std::logic_error("the plan has no axis of the knob " + std::string(knob.key));
}

}  // namespace

std::vector<double>& SweepPlan::values(const Knob& knob) { return valuesIn(*this, knob); }
const std::vector<double>& SweepPlan::values(const Knob& knob) const { return valuesIn(*this, knob); }

std::vector<SweepAxis> sweepAxes() {
  std::vector<SweepAxis> axes{
      {"techniques", "--techniques", "Techniques, by name", ',', 64, [](SweepPlan& plan, Texts texts) {
         replace(plan.techniques, texts, [](const std::string& text) { return &findWarp(text); });
       }}};
  for (const ConfigurationKnob& row : configurationKnobs()) axes.push_back(axisOf(row.knob()));
  axes.push_back({"codecs", "--codecs", codecWords(), ',', 64,
                  [](SweepPlan& plan, Texts texts) { replace(plan.codecs, texts, [](const std::string& text) { return codecOfWord(text); }); }});
  axes.push_back({"angles", "--angles", "Degrees that the camera is turned by, away from the frame's", ',', 256, [](SweepPlan& plan, Texts texts) {
                    replace(plan.anglesDeg, texts, [](const std::string& text) { return numberOf(text, kAngleDegRange, "an angle"); });
                  }});
  axes.push_back({"links", "--links", "Links behind which the camera moves, as --link (none: no link, but each stage's own time)", ';', 64,
                  [](SweepPlan& plan, Texts texts) { replace(plan.links, texts, linkOf); }});
  axes.push_back({"speedDegPerS", "--speed", "Degrees a second of that motion", ',', 1,
                  [](SweepPlan& plan, Texts texts) { plan.speedDegPerS = numberOf(texts[0], kSpeedDegPerSRange, "the speed"); }});
  axes.push_back({"instants", "--instants", "How many instants of the motion are looked at", ',', 1,
                  [](SweepPlan& plan, Texts texts) { plan.instants = wholeOf(texts[0], kInstantsRange, "the instants"); }});
  axes.push_back({"draws", "--draws", "Draws that are timed, after one that is not", ',', 1,
                  [](SweepPlan& plan, Texts texts) { plan.draws = wholeOf(texts[0], kDrawsRange, "the draws"); }});
  return axes;
}

SweepPlan defaultPlan(const MarchSettings& base, uint32_t width, uint32_t height) {
  SweepPlan plan;
  plan.base = base;
  for (const WarpDescriptor& technique : warpRegistry()) plan.techniques.push_back(&technique);
  Configuration usual;
  usual.march = base;
  usual.serverSidePx = std::max(width, height);
  for (const ConfigurationKnob& row : configurationKnobs()) {
    const std::span<const double> swept = row.knob().axis.values;
    plan.knobs.push_back({&row.knob(), {swept.begin(), swept.end()}});
    if (swept.empty()) plan.knobs.back().values = {row.get(usual)};
  }
  if (usual.serverSidePx > 1) plan.values(kServerSideKnob).push_back(usual.serverSidePx / 2);
  plan.codecs = {CodecSettings{}};
  plan.anglesDeg = {0.0, 5.0, 10.0, 25.0, 45.0};
  plan.links = {linkOf("4g")};
  return plan;
}

SweepPlan quickPlan(const MarchSettings& base, uint32_t width, uint32_t height, double angleDeg) {
  SweepPlan plan = defaultPlan(base, width, height);
  std::erase_if(plan.techniques, [](const WarpDescriptor* technique) { return !technique->usesFrame; });
  plan.values(kServerSideKnob).resize(1);
  for (KnobValuesAxis& axis : plan.knobs)
    if (axis.knob->owner == KnobOwner::technique) axis.values = {closestToDefault(axis)};
  plan.anglesDeg = {angleDeg};
  plan.links.clear();
  plan.draws = 2;
  return plan;
}

void applyPlanFile(const Node& root, SweepPlan& plan) {
  const std::vector<SweepAxis> axes = sweepAxes();
  std::vector<std::string_view> keys;
  for (const SweepAxis& axis : axes) keys.push_back(axis.key);
  root.requireObject(keys);
  for (const SweepAxis& axis : axes) {
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
    if (!lackOf(*configuration.technique, configuration.march, configuration.knobs).empty()) return;
    if (keys.insert(keyOf(configuration)).second) configurations.push_back(configuration);
  };
  Configuration configuration;
  configuration.march = plan.base;
  const std::vector<ConfigurationKnob> rows = configurationKnobs();
  // Sets the knobs from the `place`-th on to each combination of their values, the last one turning fastest.
  const std::function<void(size_t)> turn = [&](size_t place) {
    if (place == rows.size()) {
      for (const CodecSettings& codec : plan.codecs) {
        configuration.codec = codec;
        add(configuration);
      }
      return;
    }
    const ConfigurationKnob& row = rows[place];
    if (!row.concerns(*configuration.technique)) return turn(place + 1);
    for (const double value : plan.values(row.knob())) {
      row.set(configuration, value);
      turn(place + 1);
    }
  };
  for (const WarpDescriptor* technique : plan.techniques) {
    configuration.technique = technique;
    turn(0);
  }

  Configuration baseline;
  baseline.march = plan.base;
  baseline.march.render.step = static_cast<float>(plan.values(kStepKnob).front());
  baseline.march.sample = {};  // of the paper, whatever the scene says
  const std::vector<double>& sidesPx = plan.values(kServerSideKnob);
  baseline.serverSidePx = static_cast<uint32_t>(*std::max_element(sidesPx.begin(), sidesPx.end()));
  baseline.codec = plan.codecs.front();
  baseline.technique = &findWarp("spheres");
  baseline.march.sample.heuristic = Heuristic::gradient;
  add(baseline);
  baseline.technique = &findWarp("points");
  baseline.march.sample.heuristic = Heuristic::median;
  baseline.knobs.set(kPointSizeKnob, 2.0);
  add(baseline);
  return configurations;
}

nlohmann::json toJson(const SweepPlan& plan) {
  nlohmann::json json{{"techniques", listed(plan.techniques, [](const WarpDescriptor* technique) { return technique->name; })},
                      {"codecs", listed(plan.codecs, codecWord)},
                      {"angles", listed(plan.anglesDeg, kItself)},
                      {"links", listed(plan.links, [](const SweepLink& link) { return link.name; })},
                      {"speedDegPerS", plan.speedDegPerS},
                      {"instants", plan.instants},
                      {"draws", plan.draws}};
  for (const KnobValuesAxis& axis : plan.knobs)
    json[std::string(axis.knob->axis.key)] = listed(axis.values, [&](double value) { return jsonOf(*axis.knob, value); });
  return json;
}

}  // namespace warpscope
