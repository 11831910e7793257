// Naming, comparing and storing configurations.
// See configuration.h.
#include "app/experiment/configuration.h"

#include <algorithm>
#include <charconv>

#include "app/scene/json_document.h"
#include "app/scene/knob_json.h"
#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/base/range.h"
#include "render/warp/fill.h"
#include "render/warp/points_warp.h"

namespace warpscope {
namespace {

constexpr std::string_view kJpegWord = "jpeg";

/// The phrases of those knobs that `says` wants to hear of, techniques' own first.
template <class Says>
std::string phrasesOf(const Configuration& configuration, const Says& says) {
  std::string own, others;
  for (const ConfigurationKnob& row : configurationKnobs()) {
    if (row.knob().phrase.empty() || !row.matters(configuration) || !says(row)) continue;
    (row.isOfFrame() ? others : own) += phraseOf(row.knob(), row.get(configuration));
  }
  return own + others;
}

bool isInLabel(const ConfigurationKnob& row, const Configuration& configuration) {
  switch (row.knob().naming) {
    case KnobNaming::always: return true;
    case KnobNaming::unlessDefault: return row.get(configuration) != row.knob().defaultValue;
    case KnobNaming::whereDiffering: return false;
  }
  return true;
}

/// " key=value" of those knobs that matter and are wanted.
template <class Wanted>
std::string keysOf(const Configuration& configuration, const Wanted& wanted) {
  std::string text;
  for (const ConfigurationKnob& row : configurationKnobs())
    if (wanted(row) && row.matters(configuration))
      text += " " + std::string(row.knob().key) + "=" + textOf(row.knob(), row.get(configuration));
  return text;
}

}  // namespace

constinit const Knob kServerSideKnob{
    .key = "serverSide",
    .label = "Server image",
    .noun = "server's side",
    .help = "Longer side of the server's image, in pixels: one ray for each",
    .unit = " px",
    .type = KnobType::whole,
    .owner = KnobOwner::sampling,
    .stale = KnobStage::march,
    .range = kServerSideRange,
    .axis = {"serverSides", "--server-sides", "Longer sides of the server's image, pixels"},
    .phrase = ", server's image of {} px",
    .naming = KnobNaming::whereDiffering,
};

double ConfigurationKnob::get(const Configuration& configuration) const {
  if (march_ != nullptr) return march_->get(configuration.march);
  return knob_ == &kServerSideKnob ? configuration.serverSidePx : configuration.knobs[*knob_];
}

void ConfigurationKnob::set(Configuration& configuration, double value) const {
  if (march_ != nullptr)
    march_->set(configuration.march, value);
  else if (knob_ == &kServerSideKnob)
    configuration.serverSidePx = static_cast<uint32_t>(value);
  else
    configuration.knobs.set(*knob_, value);
}

bool ConfigurationKnob::concerns(const WarpDescriptor& technique) const {
  if (march_ != nullptr) return technique.dependsOn(*march_) || (march_->shapes == FramePart::proxy && technique.has(kFillKnob));
  return knob_ == &kServerSideKnob ? technique.usesFrame : technique.has(*knob_);
}

bool ConfigurationKnob::matters(const Configuration& configuration) const {
  if (march_ == nullptr) return concerns(*configuration.technique);
  return configuration.technique->dependsOn(*march_, configuration.knobs) && march_->matters(configuration.march);
}

std::vector<ConfigurationKnob> configurationKnobs() {
  std::vector<ConfigurationKnob> knobs;
  const auto addMarch = [&](KnobOwner owner) {
    for (const MarchKnob& row : marchKnobs())
      if (row.knob->owner == owner && !row.knob->axis.key.empty()) knobs.emplace_back(*row.knob, &row);
  };
  addMarch(KnobOwner::sampling);
  for (const Knob* knob : warpKnobs())
    if (!knob->axis.key.empty()) knobs.emplace_back(*knob, nullptr);
  addMarch(KnobOwner::rendering);
  addMarch(KnobOwner::effect);
  knobs.emplace_back(kServerSideKnob, nullptr);
  return knobs;
}

WarpSettings Configuration::warp(const WarpSettings& base) const {
  WarpSettings settings = base;
  for (const Knob* knob : technique->knobs)
    if (!knob->axis.key.empty()) settings.knobs.set(*knob, knobs[*knob]);
  settings.reference = march.render;
  return settings;
}

void takeOver(const Configuration& configuration, MarchSettings& march, WarpSettings& warp) {
  const WarpDescriptor& technique = *configuration.technique;
  for (const MarchKnob& row : marchKnobs())
    if (row.knob->owner == KnobOwner::sampling && technique.dependsOn(row, configuration.knobs)) row.set(march, row.get(configuration.march));
  for (const Knob* knob : technique.knobs)
    if (!knob->axis.key.empty()) warp.knobs.set(*knob, configuration.knobs[*knob]);
}

Configuration normalized(Configuration configuration) {
  const WarpDescriptor& technique = *configuration.technique;
  const MarchSettings given = configuration.march;
  for (const MarchKnob& row : marchKnobs())
    if (!technique.dependsOn(row, configuration.knobs) || !row.matters(given)) row.set(configuration.march, row.knob->defaultValue);
  for (const MarchText& row : marchTexts())
    if (const std::string usual = row.get({}); !row.matters(given) && row.get(given) != usual) row.set(configuration.march, usual, row.noun);
  std::vector<const Knob*> swept;
  for (const Knob* knob : technique.knobs)
    if (!knob->axis.key.empty()) swept.push_back(knob);
  configuration.knobs = configuration.knobs.only(swept);
  if (!technique.usesFrame) {
    configuration.serverSidePx = 0;
    configuration.codec = {};
  }
  return configuration;
}

std::string codecWord(const CodecSettings& codec) {
  if (codec.format == PayloadFormat::raw) return "raw";
  if (codec.format == PayloadFormat::tiled) return "tiled";
  if (codec.color == ColorCoding::lossless) return "lossless";
  return std::string(kJpegWord) + std::to_string(codec.jpegQuality);
}

std::string_view codecWords() {
  static const std::string kWords = [] {
    const std::string jpeg(kJpegWord);
    return "raw, lossless, tiled, " + jpeg + numberText(kJpegQualityRange.lowest) + " to " + jpeg + numberText(kJpegQualityRange.highest);
  }();
  return kWords;
}

CodecSettings codecOfWord(std::string_view word) {
  CodecSettings codec;
  if (word == "raw" || word == "tiled") {
    codec.format = word == "raw" ? PayloadFormat::raw : PayloadFormat::tiled;
    codec.color = ColorCoding::lossless;
    return codec;
  }
  if (word == "lossless") {
    codec.color = ColorCoding::lossless;
    return codec;
  }
  if (word.starts_with(kJpegWord)) {
    const std::string_view digits = word.substr(kJpegWord.size());
    int quality = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), quality);
    if (error == std::errc() && end == digits.data() + digits.size() && quality >= kJpegQualityRange.lowest && quality <= kJpegQualityRange.highest) {
      codec.jpegQuality = quality;
      return codec;
    }
  }
  throw UsageError("unknown codec '" + std::string(word.substr(0, 40)) + "'; known: " + std::string(codecWords()));
}

std::string keyOf(const Configuration& given) {
  const Configuration configuration = normalized(given);
  std::string key = std::string(configuration.technique->name) + keysOf(configuration, [](const ConfigurationKnob&) { return true; });
  if (configuration.technique->usesFrame) key += " " + codecWord(configuration.codec);
  return key;
}

std::string frameKeyOf(const Configuration& configuration) {
  return keysOf(configuration, [](const ConfigurationKnob& row) { return row.isOfFrame(); }) + " " + codecWord(configuration.codec);
}

std::string labelOf(const Configuration& given) {
  const Configuration configuration = normalized(given);
  return std::string(configuration.technique->name) +
         phrasesOf(configuration, [&](const ConfigurationKnob& row) { return isInLabel(row, configuration); });
}

std::string fullNameOf(const Configuration& given) {
  const Configuration configuration = normalized(given);
  std::string name = labelOf(configuration);
  if (configuration.technique->usesFrame)
    name += ", " + std::to_string(configuration.serverSidePx) + std::string(kServerSideKnob.unit) + ", " + codecWord(configuration.codec);
  return name + phrasesOf(configuration, [&](const ConfigurationKnob& row) {
           return row.knob().naming == KnobNaming::whereDiffering && &row.knob() != &kServerSideKnob;
         });
}

std::string othersOf(const Configuration& given) {
  const Configuration configuration = normalized(given);
  std::string text;
  for (const MarchKnob& row : marchKnobs())
    if (const double value = row.get(configuration.march); row.knob->axis.key.empty() && value != row.knob->defaultValue)
      text += ", " + std::string(row.knob->noun) + " " + textOf(*row.knob, value);
  for (const MarchText& row : marchTexts())
    if (const std::string value = row.get(configuration.march); value != row.get(MarchSettings{})) text += ", " + std::string(row.noun) + " " + value;
  return text;
}

std::string nameAmong(const Configuration& given, const std::vector<Configuration>& others) {
  const Configuration configuration = normalized(given);
  const bool usesFrame = configuration.technique->usesFrame;
  const auto differs = [&](const ConfigurationKnob& row) {
    return std::any_of(others.begin(), others.end(), [&](const Configuration& other) {
      return row.matters(other) && row.get(other) != row.get(configuration);
    });
  };
  std::string name = labelOf(configuration);
  // The server's image before the rest: it says most.
  for (const bool isServerSide : {true, false})
    name += phrasesOf(configuration, [&](const ConfigurationKnob& row) {
      return row.knob().naming == KnobNaming::whereDiffering && (&row.knob() == &kServerSideKnob) == isServerSide && differs(row);
    });
  const bool codecTells = usesFrame && std::any_of(others.begin(), others.end(), [&](const Configuration& other) {
                            return other.technique->usesFrame && other.codec != configuration.codec;
                          });
  return codecTells ? name + ", " + codecWord(configuration.codec) : name;
}

nlohmann::json toJson(const Configuration& given) {
  using Json = nlohmann::json;
  const Configuration configuration = normalized(given);
  const WarpDescriptor& technique = *configuration.technique;
  Json json{{"technique", technique.name}, {"codec", technique.usesFrame ? Json(codecWord(configuration.codec)) : Json(nullptr)}};
  for (const ConfigurationKnob& row : configurationKnobs())
    json[std::string(row.knob().key)] = row.concerns(technique) ? jsonOf(row.knob(), row.get(configuration)) : Json(nullptr);
  return json;
}

Configuration configurationFrom(const Node& node, const MarchSettings& base) {
  Configuration configuration;
  configuration.march = base;
  const Node technique = node.at("technique");
  configuration.technique = findNamed(warpRegistry(), technique.string());
  if (configuration.technique == nullptr) technique.fail(unknownNameIn(warpRegistry(), "technique", technique.string()));
  const auto given = [&](std::string_view key) {
    const std::optional<Node> found = node.find(key);
    return found && !found->isNull() ? found : std::nullopt;
  };
  for (const ConfigurationKnob& row : configurationKnobs())
    if (const auto found = given(row.knob().key)) row.set(configuration, readKnob(*found, row.knob()));
  if (const auto found = given("codec")) {
    try {
      configuration.codec = codecOfWord(found->string());
    } catch (const UsageError& error) {
      found->fail(error.what());
    }
  }
  return normalized(configuration);
}

bool isPapersMethod(const Configuration& configuration) {
  const SampleSettings& sample = configuration.march.sample;
  return configuration.technique->name == "spheres" && sample.heuristic == Heuristic::gradient && sample.radiusPolicy == RadiusPolicy::voxel &&
         sample.radiusScale == 1.0f && sample.samplesPerRay == 1;
}

bool isPointBaseline(const Configuration& configuration) {
  const SampleSettings& sample = configuration.march.sample;
  return configuration.technique->name == "points" && sample.heuristic == Heuristic::median && sample.samplesPerRay == 1 &&
         configuration.knobs.whole(kPointSizeKnob) == 2;
}

}  // namespace warpscope
