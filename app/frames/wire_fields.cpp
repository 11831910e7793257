// Field by field.
// See wire_fields.h.
#include "app/frames/wire_fields.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "app/frames/coarsening.h"
#include "app/frames/color_bytes.h"
#include "app/frames/transport_knobs.h"
#include "render/base/error.h"
#include "render/core/parallel.h"
#include "render/march/march_knobs.h"

namespace warpscope {
namespace {

std::array<float, 3> arrayOf(const glm::vec3& v) { return {v.x, v.y, v.z}; }
std::array<double, 3> arrayOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }
glm::vec3 vec3Of(const std::array<float, 3>& a) { return {a[0], a[1], a[2]}; }
glm::dvec3 dvec3Of(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

/// The value at place `index` of a table of names.
template <class Table>
auto valueAt(const Table& table, uint8_t index, const char* what) {
  if (index >= table.size()) throw InputError(std::string("the peer names ") + what + " that this program does not know");
  return table[index].value;
}

template <class Table, class Value>
uint8_t placeOf(const Table& table, Value value) {
  uint8_t place = 0;
  while (place < table.size() && table[place].value != value) ++place;
  return place;
}

bool isDirection(const glm::dvec3& v) { return std::abs(glm::length(v) - 1.0) < 1e-3; }

/// Nothing that a terminal or a window would take for more than text.
bool isLine(const std::string& text) {
  return std::ranges::none_of(text, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f; });
}

static_assert(net::kMaxPlanes == kMaxPlanes && net::kMaxPlaneName == kMaxPlaneName, "net/ knows of no samples, and has numbers of its own");

/// No length in a frame is greater, so that no position or radius in it is beyond what can be drawn
/// (kMaxSphereCoordinate, 1e18); and no unit of radii is so small that radii vanish.
constexpr float kLongest = 1e17f;
constexpr float kSmallestUnit = 1e-30f;
/// Milliseconds that a stage may take: a year.
constexpr double kLongestStageMs = 3.2e10;

void requireLengths(const SampleFrame& frame) {
  const SampleQuantization& q = frame.quantization;
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(q.bounds.lower[axis]) > kLongest || std::abs(q.bounds.upper[axis]) > kLongest)
      throw InputError("the server's frame has bounds beyond what can be drawn");
  if (q.radiusUnit > kLongest || q.radiusUnit < kSmallestUnit || frame.voxelRadius > kLongest)
    throw InputError("the server's frame has a unit of radii, or a voxel radius, with which nothing can be drawn");
  if (q.nearDepth > kLongest || decodeDepth(kDepthCodeMax, q.depthStep) > kLongest)
    throw InputError("the server's frame has depths beyond what can be drawn");
}

void requireAtMost(uint64_t value, uint64_t most, const char* what) {
  if (value > most)
    throw InputError(std::to_string(value) + " " + what + ", where " + std::to_string(most) + " are the most");
}

/// Throws what is wrong.
void requirePossible(const net::FrameHead& head, uint64_t payloadBytes) {
  const net::StageTimes& stages = head.stages;
  for (const double ms :
       {stages.queueMs, stages.marchMs, stages.compactMs, stages.copyMs, stages.encodeMs, stages.sendMs})
    if (!(ms >= 0.0 && ms <= kLongestStageMs)) throw InputError("the server's frame has times that are none");
  const Camera camera = cameraFrom(head.camera);
  const CodecSettings coding = codecFrom(head.codec);
  if (head.wanted == net::Wanted::picture) {
    marchFrom(head.settings);
    requireAtMost(head.sampleCount, 0, "samples in a picture");
    requireAtMost(head.planes.size(), 0, "planes of samples in a picture");
    requireAtMost(payloadBytes, mostColorBytes(camera.width, camera.height), "bytes for the picture");
    return;
  }
  const SampleFrame frame = frameFrom(head);
  requireLengths(frame);
  const auto perRay = static_cast<uint64_t>(frame.settings.sample.samplesPerRay);
  requireAtMost(head.sampleCount, perRay * camera.width * camera.height, "samples");
  requireAtMost(payloadBytes, mostPayloadBytes(frame, head.sampleCount, coding), "bytes for the samples");
}

/// Nothing can be drawn of a sample without a radius. No marcher makes one; codecs carry it.
bool haveRadii(const TransferVector<PackedSample>& samples) {
  std::atomic<bool> haveAll = true;
  parallelForRanges(samples.size(), 1 << 16, [&](size_t begin, size_t end) {
    const PackedSample* const sample = samples.data();
    bool isNone = false;
    for (size_t i = begin; i < end; ++i) isNone |= radiusCode(sample[i]) == 0;
    if (isNone) haveAll = false;
  });
  return haveAll;
}

}  // namespace

net::CameraFields toFields(const Camera& camera) {
  return {arrayOf(camera.eye), arrayOf(camera.right), arrayOf(camera.up), arrayOf(camera.forward),
          camera.tanHalfFovY,  camera.width,          camera.height};
}

net::SettingFields toFields(const MarchSettings& settings) {
  net::SettingFields fields;
  // Of effects, and of what a frame may say besides, only what is not as it is by itself: a peer that knows fewer can have what needs no more.
  const auto isExtra = [](const MarchKnob& row) {
    return row.knob->owner == KnobOwner::effect || row.shapes == FramePart::planes || row.shapes == FramePart::segments || row.shapes == FramePart::proxy;
  };
  for (const MarchKnob& row : marchKnobs())
    if (const double value = row.get(settings); !isExtra(row) || value != row.knob->defaultValue)
      fields.push_back({std::string(row.knob->key), textOf(*row.knob, value)});
  static const MarchSettings kDefaults;
  for (const MarchText& text : marchTexts())
    if (const std::string value = text.get(settings); value != text.get(kDefaults)) fields.push_back({std::string(text.key), value});
  return fields;
}

net::SettingFields toFields(const MarchSettings& settings, const ServerWishes& wishes) {
  net::SettingFields fields = toFields(settings);
  for (const auto& row : serverKnobs())
    if (const double value = row.get(wishes); value != 0.0) fields.push_back({std::string(row.knob->key), textOf(*row.knob, value)});
  return fields;
}

net::CodecFields toFields(const CodecSettings& s) {
  return {placeOf(kPayloadFormats, s.format), placeOf(kColorCodings, s.color), static_cast<uint8_t>(s.jpegQuality)};
}

net::SceneFields toFields(const Scene& scene) {
  const VolumeGeometry& geometry = scene.geometry();
  net::SceneFields fields;
  fields.name = scene.name;
  fields.title = scene.title;
  fields.dims = {geometry.dims.x, geometry.dims.y, geometry.dims.z};
  fields.spacing = arrayOf(geometry.spacing);
  fields.origin = arrayOf(geometry.origin);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) fields.direction[static_cast<size_t>(3 * column + row)] = geometry.direction[column][row];
  fields.hasOrientation = geometry.hasOrientation;
  fields.up = arrayOf(scene.up);
  fields.front = arrayOf(scene.front);
  fields.fovYDeg = scene.fovYDeg;
  fields.background = arrayOf(scene.background);
  for (const View& view : scene.views) {
    if (fields.views.size() == net::kMaxViews) break;
    fields.views.push_back({view.angleDeg, view.elevationDeg, view.distance, view.pan.x, view.pan.y});
  }
  fields.settings = toFields(scene.march);
  return fields;
}

Camera cameraFrom(const net::CameraFields& fields) {
  Camera camera{vec3Of(fields.eye),     vec3Of(fields.right), vec3Of(fields.up), vec3Of(fields.forward),
                fields.tanHalfFovY, fields.width,         fields.height};
  requireUsable(camera);
  return camera;
}

namespace {

double valueOf(const Knob& knob, const net::SettingField& field) {
  try {
    return parseKnob(knob, field.value, "the " + std::string(knob.noun));
  } catch (const UsageError& error) {
    throw InputError("the peer's setting \"" + field.name + "\" has a value that this program does not know: " + error.what());
  }
}

}  // namespace

ServerWishes wishesFrom(const net::SettingFields& fields) {
  ServerWishes wishes;
  for (const auto& row : serverKnobs())
    if (const auto found = std::ranges::find(fields, row.knob->key, &net::SettingField::name); found != fields.end()) row.set(wishes, valueOf(*row.knob, *found));
  return wishes;
}

bool admits(const net::SettingFields& asked, const net::SettingFields& answered) {
  try {
    const ServerWishes wishes = wishesFrom(asked);
    return wishes.movingMs > 0 && wishesFrom(answered) == wishes && isCoarsened(marchFrom(asked), marchFrom(answered));
  } catch (const InputError&) {
    return false;
  }
}

MarchSettings marchFrom(const net::SettingFields& fields) {
  MarchSettings settings;
  wishesFrom(fields);
  for (const net::SettingField& field : fields) {
    if (std::ranges::any_of(serverKnobs(), [&](const auto& wish) { return wish.knob->key == field.name; })) continue;
    const MarchText* const text = findMarchText(field.name);
    const auto row = std::ranges::find_if(marchKnobs(), [&](const MarchKnob& known) { return known.knob->key == field.name; });
    if (text == nullptr && row == marchKnobs().end()) throw InputError("the peer names a setting \"" + field.name + "\" that this program does not know");
    if (text == nullptr) {
      row->set(settings, valueOf(*row->knob, field));
      continue;
    }
    try {
      text->set(settings, field.value, "the " + std::string(text->noun));
    } catch (const UsageError& error) {
      throw InputError("the peer's setting \"" + field.name + "\" has a value that this program does not know: " + error.what());
    }
  }
  return settings;  // each was checked as it was read
}

CodecSettings codecFrom(const net::CodecFields& fields) {
  CodecSettings settings{valueAt(kPayloadFormats, fields.format, "a format"), valueAt(kColorCodings, fields.color, "a colour coding"),
                         fields.quality};
  validate(settings);
  return settings;
}

VolumeGeometry geometryFrom(const net::SceneFields& fields) {
  VolumeGeometry geometry;
  geometry.dims = {fields.dims[0], fields.dims[1], fields.dims[2]};
  geometry.spacing = dvec3Of(fields.spacing);
  geometry.origin = dvec3Of(fields.origin);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row) geometry.direction[column][row] = fields.direction[static_cast<size_t>(3 * column + row)];
  geometry.hasOrientation = fields.hasOrientation;
  validate(geometry, VoxelType::uint8, "the server's scene");
  for (int column = 0; column < 3; ++column)
    if (!isDirection(geometry.direction[column])) throw InputError("the server's scene has axes that are none");
  return geometry;
}

Scene sceneFrom(const net::SceneFields& fields) {
  Scene scene;
  if (fields.name.empty() || !isLine(fields.name) || !isLine(fields.title))
    throw InputError("the server's scene has a name or a title that is none");
  scene.name = fields.name;
  scene.title = fields.title;
  scene.elsewhere = geometryFrom(fields);
  scene.up = dvec3Of(fields.up);
  scene.front = dvec3Of(fields.front);
  if (!(glm::length(glm::cross(scene.up, scene.front)) > 1e-6) || !std::isfinite(glm::length(scene.up) * glm::length(scene.front)))
    throw InputError("the server's scene has directions that are none");
  scene.fovYDeg = fields.fovYDeg;
  if (!(scene.fovYDeg >= kFovYDegRange.lowest && scene.fovYDeg <= kFovYDegRange.highest))
    throw InputError("the server's scene has no usable field of view");
  scene.background = vec3Of(fields.background);
  for (const float channel : fields.background)
    if (!(channel >= 0.0f && channel <= 1.0f)) throw InputError("the server's scene has a background that is no colour");
  for (const net::ViewFields& view : fields.views) {
    // Written so that NaN fails. Files allow no more (scene.cpp), and fitting views moves cameras by less than the
    // rest.
    constexpr double kMostDeg = 1e6, kMostElevationDeg = 90.5, kMostDistance = 1e6, kMostPan = 1e6;
    if (!(std::abs(view.angleDeg) <= kMostDeg && std::abs(view.elevationDeg) <= kMostElevationDeg &&
          view.distance > 0.0 && view.distance <= kMostDistance && std::abs(view.panRight) <= kMostPan &&
          std::abs(view.panUp) <= kMostPan))
      throw InputError("the server's scene has a view that is none");
    scene.views.push_back({view.angleDeg, view.elevationDeg, view.distance, {view.panRight, view.panUp}});
  }
  scene.march = marchFrom(fields.settings);
  return scene;
}

std::vector<net::ProcessFields> toFields(std::span<const RankWork> processes) {
  const auto cellsOf = [](const glm::ivec3& cells) { return std::array{static_cast<uint32_t>(cells.x), static_cast<uint32_t>(cells.y), static_cast<uint32_t>(cells.z)}; };
  static_assert(WorkTimeline::kSlots == net::kProcessSlots);
  std::vector<net::ProcessFields> fields;
  for (const RankWork& work : processes) {
    const WorkTimeline& timeline = work.timeline;
    const double most = timeline.mostThreads();
    const auto shares = [&](const std::array<float, WorkTimeline::kSlots>& slots) {
      std::array<uint8_t, net::kProcessSlots> codes{};
      for (size_t i = 0; i < slots.size() && most > 0.0; ++i)
        codes[i] = static_cast<uint8_t>(std::lround(255.0 * std::min(1.0, static_cast<double>(slots[i]) / (timeline.slotMs * most))));
      return codes;
    };
    fields.push_back({cellsOf(work.block.lower), cellsOf(work.block.upper), work.tiles, work.deviceTiles, work.marchMs, work.waitMs, work.sentBytes,
                      static_cast<float>(timeline.slotMs), static_cast<float>(most), shares(timeline.marchMs), shares(timeline.waitMs)});
  }
  return fields;
}

net::FrameHead headOf(const SampleFrame& frame, const CodecSettings& codec, const ServerWishes& wishes) {
  net::FrameHead head;
  head.camera = toFields(frame.camera);
  head.settings = toFields(frame.settings, wishes);
  head.codec = toFields(codec);
  const Box& bounds = frame.quantization.bounds;
  head.bounds = {bounds.lower.x, bounds.lower.y, bounds.lower.z, bounds.upper.x, bounds.upper.y, bounds.upper.z};
  head.radiusUnit = frame.quantization.radiusUnit;
  head.nearDepth = frame.quantization.nearDepth;
  head.depthStep = frame.quantization.depthStep;
  head.voxelRadius = frame.voxelRadius;
  head.sampleCount = frame.size();
  head.stages.marchMs = frame.timings.marchMs;
  head.stages.compactMs = frame.timings.compactMs;
  head.stages.copyMs = frame.timings.copyMs;
  for (const SamplePlane& plane : frame.planes) head.planes.push_back({plane.name, static_cast<uint8_t>(plane.element)});
  return head;
}

SampleFrame frameFrom(const net::FrameHead& head) {
  SampleFrame frame;
  frame.requestId = head.id;
  frame.camera = cameraFrom(head.camera);
  frame.settings = marchFrom(head.settings);
  const auto& b = head.bounds;
  frame.quantization = {{{b[0], b[1], b[2]}, {b[3], b[4], b[5]}}, head.radiusUnit, head.nearDepth, head.depthStep};
  if (!isUsable(frame.quantization)) throw InputError("the server's frame has bounds, a unit of radii or depths that are none");
  if (!(head.voxelRadius > 0.0f) || !std::isfinite(head.voxelRadius)) throw InputError("the server's frame has an impossible voxel radius");
  frame.voxelRadius = head.voxelRadius;
  frame.timings = {head.stages.marchMs, head.stages.compactMs, head.stages.copyMs};
  // Elements that are not known are kept: who decodes skips their planes.
  for (const net::PlaneFields& plane : head.planes) frame.planes.push_back({plane.name, static_cast<PlaneElement>(plane.element), {}});
  return frame;
}

std::string faultOf(const net::FrameHead& head, uint64_t payloadBytes) {
  try {
    requirePossible(head, payloadBytes);
    return {};
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

SampleFrame decodedFrom(const net::FrameHead& head, net::ByteView payload, FrameCodec& codec, DecodedPlace place) {
  SampleFrame frame = frameFrom(head);
  if (payload.empty() || std::to_integer<uint8_t>(payload[0]) != static_cast<uint8_t>(codecFrom(head.codec).format))
    throw InputError("the server's frame: the payload has another format than its head says");
  DecodeLimits limits = decodeLimitsFor(frame);
  limits.place = place;
  if (const DecodeError error = codec.decode(payload, head.sampleCount, frame, limits))
    throw InputError("the server's frame: " + *error);
  if (!(frame.isAway ? frame.device->haveRadii() : haveRadii(frame.samples))) throw InputError("the server's frame has samples without a radius");
  return frame;
}

DecodeLimits decodeLimitsFor(const SampleFrame& frame) {
  DecodeLimits limits;
  const auto perRay = static_cast<size_t>(frame.settings.sample.samplesPerRay);
  limits.maxSamples = std::min(limits.maxSamples, perRay * frame.camera.width * frame.camera.height);
  limits.maxSegments = std::min(limits.maxSegments, static_cast<size_t>(frame.settings.sample.segments) * frame.camera.width * frame.camera.height);
  return limits;
}

}  // namespace warpscope
