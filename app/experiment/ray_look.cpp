// Which ray, and its JSON.
// See ray_look.h.
#include "app/experiment/ray_look.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "app/picture/pixel_report.h"
#include "app/scene/json_document.h"

namespace warpscope {
namespace {

using Json = nlohmann::json;

Json toJson(const glm::vec3& v) { return {v.x, v.y, v.z}; }
Json toJson(const glm::vec4& v) { return {v.x, v.y, v.z, v.w}; }

}  // namespace

RayOfPixel rayBehind(const ContentInputs& inputs, const glm::uvec2& place) {
  const PixelReport report = pixelReport(inputs, place);
  if (report.server) return {true, inputs.frame->camera, report.server->place, report.server->sample};
  return {false, inputs.camera, place, std::nullopt, report.kind == PixelKind::hole || report.kind == PixelKind::guess};
}

std::optional<float> depthBy(const RayTrace& trace, Heuristic heuristic) {
  for (const TracedDepth& depth : trace.depths)
    if (depth.heuristic == heuristic && depth.result.hasDepth) return depth.result.depth;
  return std::nullopt;
}

LightAbout lightAbout(const RayTrace& trace, float depth) {
  double nearer = 0.0, within = 0.0, farther = 0.0;
  for (const CountingSample& sample : trace.samples) {
    double& share = sample.t < depth - kLightReach ? nearer : sample.t > depth + kLightReach ? farther : within;
    share += static_cast<double>(sample.contribution());
  }
  const double all = nearer + within + farther;
  if (!(all > 0.0)) return {};
  return {static_cast<float>(nearer / all), static_cast<float>(within / all), static_cast<float>(farther / all)};
}

SeenByFrame seenByFrame(const SampleFrame& frame, const glm::vec3& place) {
  const Camera& camera = frame.camera;
  const Projection at = project(camera, place);
  const bool isInside = at.forwardDepth > 0.0f && at.pixel.x >= 0.0f && at.pixel.x < static_cast<float>(camera.width) && at.pixel.y >= 0.0f && at.pixel.y < static_cast<float>(camera.height);
  if (!isInside) return {};
  SeenByFrame seen{SeenByFrame::Kind::nothing, {static_cast<uint32_t>(at.pixel.x), static_cast<uint32_t>(at.pixel.y)}};
  const float distance = glm::length(place - camera.eye);
  const SampleGrid grid = frame.grid();
  float nearest = std::numeric_limits<float>::infinity();  // difference of distances, with its sign
  for (const PackedSample sample : frame.samples) {
    if (pixelKey(sample) != pixelKey(seen.pixel.x, seen.pixel.y)) continue;
    const Sphere sphere = unpackSample(sample, grid);
    const float behind = distance - glm::length(sphere.center - camera.eye);
    if (!(std::abs(behind) < std::abs(nearest))) continue;
    nearest = behind;
    seen.radius = sphere.radius;
  }
  if (!std::isfinite(nearest)) return seen;
  seen.apart = std::abs(nearest);
  seen.kind = seen.apart <= std::max(kLightReach, seen.radius) ? SeenByFrame::Kind::there : nearest > 0.0f ? SeenByFrame::Kind::nearer : SeenByFrame::Kind::farther;
  return seen;
}

Json toJson(const RayTrace& trace, const RayOfPixel& ray, const MarchSettings& settings) {
  Json places = Json::array(), samples = Json::array(), depths = Json::object(), segments = Json::array();
  for (const RayPlace& place : trace.places)
    places.push_back({{"depth", place.t}, {"value", finiteOrNull(place.value)}, {"color", toJson(glm::vec3(place.look))}, {"opacity", place.look.a}});
  for (const CountingSample& sample : trace.samples)
    samples.push_back({{"depth", sample.t}, {"length", sample.ds}, {"opacity", sample.alpha}, {"transmittance", sample.transmittance}});
  for (const TracedDepth& depth : trace.depths) depths[std::string(nameOf(depth.heuristic))] = depth.result.hasDepth ? Json(depth.result.depth) : Json(nullptr);
  Json light(nullptr);
  if (const std::optional<float> depth = depthBy(trace, settings.sample.heuristic)) {
    const LightAbout about = lightAbout(trace, *depth);
    light = {{"nearer", about.nearer}, {"within", about.within}, {"farther", about.farther}, {"reach", kLightReach}};
  }
  for (const RaySegment& segment : trace.segments)
    segments.push_back({{"begin", segment.begin}, {"end", segment.end}, {"opacity", segment.opacity}, {"transmittance", segment.through}, {"color", toJson(segment.color)}});
  return {{"of", ray.isServers ? "server" : "picture"},
          {"pixel", {ray.pixel.x, ray.pixel.y}},
          {"sample", ray.sample ? Json(*ray.sample) : Json(nullptr)},
          {"origin", toJson(trace.ray.origin)},
          {"originFromEye", glm::length(trace.ray.origin - ray.camera.eye)},
          {"direction", toJson(trace.ray.direction)},
          {"forwardDepthOverDepth", trace.cosine},
          {"begin", trace.begin},
          {"end", trace.end},
          {"heuristic", nameOf(settings.sample.heuristic)},
          {"depths", depths},
          {"light", light},
          {"color", toJson(trace.color)},
          {"isEnded", trace.isEnded},
          {"samples", samples},
          {"segments", segments},
          {"places", places}};
}

}  // namespace warpscope
