// Naming, comparing and storing configurations.
// See configuration.h.
#include "app/experiment/configuration.h"

#include <charconv>

#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/warp/multihit/nearest_hits.h"

namespace warpscope {
namespace {

constexpr std::string_view kJpegWord = "jpeg";

template <class Table>
auto valueNamed(const Node& node, const Table& table, std::string_view kind) {
  const std::string name = node.string();
  if (const auto* entry = findNamed(table, name)) return entry->value;
  node.fail(unknownNameIn(table, kind, name));
}

}  // namespace

WarpSettings Configuration::warp(const WarpSettings& base) const {
  WarpSettings settings = base;
  settings.pointSize = pointSize;
  settings.hits = hits;
  settings.reference = march.render;
  return settings;
}

void takeOver(const Configuration& configuration, MarchSettings& march, WarpSettings& warp) {
  const WarpKnobs& knobs = configuration.technique->knobs;
  if (knobs.depth) {
    march.sample.heuristic = configuration.march.sample.heuristic;
    march.sample.threshold = configuration.march.sample.threshold;
  }
  if (knobs.radius) {
    march.sample.radiusPolicy = configuration.march.sample.radiusPolicy;
    march.sample.radiusScale = configuration.march.sample.radiusScale;
  }
  if (knobs.pointSize) warp.pointSize = configuration.pointSize;
  if (knobs.hits) warp.hits = configuration.hits;
}

Configuration normalized(Configuration configuration) {
  const WarpDescriptor& technique = *configuration.technique;
  const WarpKnobs& knobs = technique.knobs;
  if (!knobs.depth) {
    configuration.march.sample.heuristic = SampleSettings{}.heuristic;
    configuration.march.sample.threshold = SampleSettings{}.threshold;
  }
  if (!knobs.radius) {
    configuration.march.sample.radiusPolicy = SampleSettings{}.radiusPolicy;
    configuration.march.sample.radiusScale = SampleSettings{}.radiusScale;
  }
  if (!knobs.pointSize) configuration.pointSize = WarpSettings{}.pointSize;
  if (!knobs.hits) configuration.hits = WarpSettings{}.hits;
  if (!technique.usesFrame) {
    configuration.serverSidePx = 0;
    configuration.codec = {};
  }
  return configuration;
}

std::string codecWord(const CodecSettings& codec) {
  if (codec.format == PayloadFormat::raw) return "raw";
  if (codec.color == ColorCoding::lossless) return "lossless";
  return std::string(kJpegWord) + std::to_string(codec.jpegQuality);
}

CodecSettings codecOfWord(std::string_view word) {
  CodecSettings codec;
  if (word == "raw") {
    codec.format = PayloadFormat::raw;
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
    if (error == std::errc() && end == digits.data() + digits.size() && quality >= 1 && quality <= 100) {
      codec.jpegQuality = quality;
      return codec;
    }
  }
  throw UsageError("unknown codec '" + std::string(word.substr(0, 40)) + "'; known: raw, lossless, jpeg1 to jpeg100");
}

std::string keyOf(const Configuration& given) {
  const Configuration configuration = normalized(given);
  const WarpDescriptor& technique = *configuration.technique;
  const WarpKnobs& knobs = technique.knobs;
  std::string key(technique.name);
  if (knobs.depth) {
    key += " " + std::string(nameOf(configuration.march.sample.heuristic));
    const bool hasThreshold = configuration.march.sample.heuristic == Heuristic::threshold || configuration.march.sample.heuristic == Heuristic::relThreshold;
    if (hasThreshold) key += "=" + numberText(configuration.march.sample.threshold);
  }
  if (knobs.radius) key += " " + std::string(nameOf(configuration.march.sample.radiusPolicy)) + "*" + numberText(configuration.march.sample.radiusScale);
  if (knobs.pointSize) key += " size=" + std::to_string(configuration.pointSize);
  if (knobs.hits) key += " hits=" + std::to_string(configuration.hits);
  key += " step=" + numberText(configuration.march.render.step);
  if (technique.usesFrame) key += " side=" + std::to_string(configuration.serverSidePx) + " " + codecWord(configuration.codec);
  return key;
}

std::string labelOf(const Configuration& given) {
  const Configuration configuration = normalized(given);
  const WarpKnobs& knobs = configuration.technique->knobs;
  std::string label(configuration.technique->name);
  if (knobs.pointSize) label += " of " + std::to_string(configuration.pointSize) + " px";
  if (knobs.hits) label += " of " + std::to_string(configuration.hits);
  if (knobs.depth) label += ", " + std::string(nameOf(configuration.march.sample.heuristic));
  if (knobs.radius) {
    label += ", " + std::string(nameOf(configuration.march.sample.radiusPolicy));
    if (configuration.march.sample.radiusScale != 1.0f) label += " x " + numberText(configuration.march.sample.radiusScale);
  }
  return label;
}

nlohmann::json toJson(const Configuration& given) {
  using Json = nlohmann::json;
  const Configuration configuration = normalized(given);
  const WarpDescriptor& technique = *configuration.technique;
  const WarpKnobs& knobs = technique.knobs;
  const auto orNull = [](bool depends, auto value) { return depends ? Json(value) : Json(nullptr); };
  return {{"technique", technique.name},
          {"heuristic", orNull(knobs.depth, nameOf(configuration.march.sample.heuristic))},
          {"threshold", orNull(knobs.depth, configuration.march.sample.threshold)},
          {"radius", orNull(knobs.radius, nameOf(configuration.march.sample.radiusPolicy))},
          {"radiusScale", orNull(knobs.radius, configuration.march.sample.radiusScale)},
          {"pointSize", orNull(knobs.pointSize, configuration.pointSize)},
          {"hits", orNull(knobs.hits, configuration.hits)},
          {"step", configuration.march.render.step},
          {"serverSide", orNull(technique.usesFrame, configuration.serverSidePx)},
          {"codec", orNull(technique.usesFrame, codecWord(configuration.codec))}};
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
  if (const auto found = given("heuristic")) configuration.march.sample.heuristic = valueNamed(*found, kHeuristics, "heuristic");
  if (const auto found = given("threshold")) configuration.march.sample.threshold = static_cast<float>(found->number(kThresholdRange));
  if (const auto found = given("radius")) configuration.march.sample.radiusPolicy = valueNamed(*found, kRadiusPolicies, "radius policy");
  if (const auto found = given("radiusScale")) configuration.march.sample.radiusScale = static_cast<float>(found->number(kRadiusScaleRange));
  if (const auto found = given("pointSize")) configuration.pointSize = static_cast<int>(found->integer(1, 16));
  if (const auto found = given("hits")) configuration.hits = static_cast<int>(found->integer(1, kMaxHits));
  if (const auto found = given("step")) configuration.march.render.step = static_cast<float>(found->number(kStepRange));
  if (const auto found = given("serverSide")) configuration.serverSidePx = static_cast<uint32_t>(found->integer(1, kMaxImageSide));
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
  const MarchSettings& march = configuration.march;
  return configuration.technique->name == "spheres" && march.sample.heuristic == Heuristic::gradient && march.sample.radiusPolicy == RadiusPolicy::voxel &&
         march.sample.radiusScale == 1.0f;
}

bool isPointBaseline(const Configuration& configuration) {
  return configuration.technique->name == "points" && configuration.march.sample.heuristic == Heuristic::median && configuration.pointSize == 2;
}

}  // namespace warpscope
