// Rows as JSON and CSV.
// See sweep_result.h.
#include "app/experiment/sweep_result.h"

#include "app/experiment/csv.h"
#include "app/scene/json_document.h"

#include <cmath>
#include <limits>

namespace warpscope {
namespace {

using Json = nlohmann::json;

constexpr double kHuge = 1e18;

/// JSON knows no infinity: equal pictures have the PSNR null.
Json orNull(const std::optional<double>& value) { return value ? finiteOrNull(*value) : Json(nullptr); }

void append(Json& json, const char* name, const Measured& measured) {
  json[std::string(name) + "Ms"] = measured.medianMs;
  json[std::string(name) + "SpreadMs"] = measured.spreadMs;
}

Measured measuredFrom(const Node& node, const std::string& name) {
  return {node.at(name + "Ms").number(0.0, kHuge), node.at(name + "SpreadMs").number(0.0, kHuge)};
}

double decibelsFrom(const Node& node) {
  return node.isNull() ? std::numeric_limits<double>::infinity() : node.number(-kHuge, kHuge);
}

std::optional<double> optionalFrom(const Node& node) {
  if (node.isNull()) return std::nullopt;
  return node.number(-kHuge, kHuge);
}

}  // namespace

Json toJson(const PictureErrors& errors) {
  return {{"psnrDb", finiteOrNull(errors.psnrDb)},
          {"psnrLinearDb", finiteOrNull(errors.psnrLinearDb)},
          {"ssim", errors.ssim},
          {"flip", errors.flip},
          {"flipVisible", orNull(errors.flipVisible)},
          {"flipDisoccluded", orNull(errors.flipDisoccluded)},
          {"psnrVisibleDb", orNull(errors.psnrVisibleDb)},
          {"psnrDisoccludedDb", orNull(errors.psnrDisoccludedDb)},
          {"holeFraction", errors.holeFraction},
          {"filledFraction", errors.filledFraction}};
}

Json toJson(const SweepFloor& floor) {
  Json json = toJson(floor.errors);
  json["angleDeg"] = floor.angleDeg;
  return json;
}

std::string_view nameOf(SweepBound::Kind kind) { return kind == SweepBound::Kind::bestDot ? "best-dot" : "perfect-warp"; }
std::string_view labelOf(SweepBound::Kind kind) {
  return kind == SweepBound::Kind::bestDot ? "one dot a ray, wherever it helps" : "all that the frame saw, right";
}

Json toJson(const SweepBound& bound) {
  Json json = toJson(bound.errors);
  json["bound"] = nameOf(bound.kind);
  json["angleDeg"] = bound.angleDeg;
  return json;
}

Json toJson(const SweepRow& row) {
  Json json = toJson(row.configuration);
  json.update(toJson(row.errors));
  json["link"] = row.link.empty() ? Json(nullptr) : Json(row.link);
  json["angleDeg"] = row.angleDeg;
  json["ageMs"] = row.link.empty() ? Json(nullptr) : Json(row.ageMs);
  json["framesPerSecond"] = row.link.empty() ? Json(nullptr) : Json(row.framesPerSecond);
  json["flicker"] = orNull(row.flicker);
  json["disoccludedFraction"] = orNull(row.disoccludedFraction);
  json["samples"] = row.cost.samples;
  json["bytes"] = row.cost.bytes;
  append(json, "march", row.cost.march);
  append(json, "compact", row.cost.compact);
  append(json, "copy", row.cost.copy);
  append(json, "encode", row.cost.encode);
  append(json, "decode", row.cost.decode);
  append(json, "upload", row.cost.upload);
  append(json, "build", row.cost.build);
  append(json, "draw", row.draw);
  json["draws"] = row.draws;
  json["serverMs"] = row.cost.serverMs();
  json["frameMs"] = row.frameMs();
  return json;
}

SweepRow sweepRowFrom(const Node& node, const MarchSettings& base) {
  SweepRow row;
  row.configuration = configurationFrom(node, base);
  if (const Node link = node.at("link"); !link.isNull()) {
    row.link = link.string();
    row.ageMs = node.at("ageMs").number(0.0, kHuge);
    row.framesPerSecond = node.at("framesPerSecond").number(0.0, kHuge);
  }
  row.angleDeg = node.at("angleDeg").number(-kHuge, kHuge);
  row.flicker = optionalFrom(node.at("flicker"));
  row.disoccludedFraction = optionalFrom(node.at("disoccludedFraction"));
  row.errors.psnrDb = decibelsFrom(node.at("psnrDb"));
  row.errors.psnrLinearDb = decibelsFrom(node.at("psnrLinearDb"));
  row.errors.ssim = node.at("ssim").number(-1.0, 1.0);
  row.errors.flip = node.at("flip").number(0.0, 1.0);
  row.errors.flipVisible = optionalFrom(node.at("flipVisible"));
  row.errors.flipDisoccluded = optionalFrom(node.at("flipDisoccluded"));
  row.errors.psnrVisibleDb = optionalFrom(node.at("psnrVisibleDb"));
  row.errors.psnrDisoccludedDb = optionalFrom(node.at("psnrDisoccludedDb"));
  row.errors.holeFraction = node.at("holeFraction").number(0.0, 1.0);
  if (const auto filled = node.find("filledFraction")) row.errors.filledFraction = filled->number(0.0, 1.0);  // not in older files
  row.cost.samples = static_cast<size_t>(node.at("samples").integer(0, int64_t{1} << 40));
  row.cost.bytes = static_cast<size_t>(node.at("bytes").integer(0, int64_t{1} << 33));  // more than any frame takes
  row.cost.march = measuredFrom(node, "march");
  row.cost.compact = measuredFrom(node, "compact");
  row.cost.copy = measuredFrom(node, "copy");
  row.cost.encode = measuredFrom(node, "encode");
  row.cost.decode = measuredFrom(node, "decode");
  if (node.find("uploadMs")) row.cost.upload = measuredFrom(node, "upload");  // sweeps without it count it as part of the build
  row.cost.build = measuredFrom(node, "build");
  row.draw = measuredFrom(node, "draw");
  row.draws = static_cast<int>(node.at("draws").integer(0, 1 << 20));
  return row;
}

std::vector<SweepRow> sweepRowsFrom(const Node& rows, const MarchSettings& base) {
  std::vector<SweepRow> read;
  for (const Node& row : rows.elements(1, 1 << 20)) read.push_back(sweepRowFrom(row, base));  // a file of the largest size holds fewer
  return read;
}

std::string csvOf(const std::vector<SweepRow>& rows) {
  // The configuration's columns: samples and techniques' own, then the rest of it.
  std::vector<std::string_view> columns{"technique"};
  for (const ConfigurationKnob& row : configurationKnobs()) columns.push_back(row.knob().key);
  columns.insert(columns.end(),
                 {"codec", "link", "angleDeg", "ageMs", "framesPerSecond", "flicker", "flip", "psnrDb", "psnrLinearDb", "ssim", "holeFraction", "filledFraction",
                  "disoccludedFraction", "flipVisible", "flipDisoccluded", "psnrVisibleDb", "psnrDisoccludedDb", "samples", "bytes", "marchMs",
                  "marchSpreadMs", "compactMs", "compactSpreadMs", "copyMs", "copySpreadMs", "encodeMs", "encodeSpreadMs", "serverMs", "decodeMs",
                  "decodeSpreadMs", "uploadMs", "uploadSpreadMs", "buildMs", "buildSpreadMs", "drawMs", "drawSpreadMs", "draws", "frameMs"});
  std::string text;
  for (const std::string_view column : columns) text += (text.empty() ? "" : ",") + std::string(column);
  text += "\r\n";
  for (const SweepRow& row : rows) {
    const Json json = toJson(row);
    std::string line;
    for (const std::string_view column : columns) line += (line.empty() ? "" : ",") + csvField(json.at(std::string(column)));
    text += line + "\r\n";
  }
  return text;
}

}  // namespace warpscope
