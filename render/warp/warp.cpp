// The registry of techniques and what they share.
// See warp.h. A new technique is one file pair and one line here.
#include "render/warp/warp.h"

#include <algorithm>
#include <deque>
#include <stdexcept>

#include "render/base/error.h"
#include "render/base/nearest_name.h"
#include "render/core/parallel.h"
#include "render/cuda/devices.h"
#include "render/warp/completed_warp.h"
#include "render/warp/fallback_warp.h"
#include "render/warp/host_frame_warp.h"
#include "render/warp/fill.h"
#include "render/warp/hold_warp.h"
#include "render/warp/kept_frames.h"
#include "render/warp/mesh_warp.h"
#include "render/warp/multihit_warp.h"
#include "render/warp/points_warp.h"
#include "render/warp/proxy_warp.h"
#include "render/warp/reference_warp.h"
#include "render/warp/rotate_warp.h"
#include "render/warp/segments_warp.h"
#include "render/warp/spheres_warp.h"
#include "render/warp/splats_warp.h"
#include "render/warp/sprites_warp.h"

namespace warpscope {
namespace {

/// In the order in which they are shown; the first nine have keys in the window.
constexpr const WarpDescriptor* kWarps[] = {&kReferenceWarp, &kHoldWarp,     &kRotateWarp, &kPointsWarp,  &kSpheresWarp, &kSplatsWarp,
                                            &kMeshWarp,      &kSegmentsWarp, &kProxyWarp,  &kSpritesWarp, &kMultihitWarp};

/// `technique` with the knobs of all that leave gaps, if it does.
WarpDescriptor completed(WarpDescriptor technique) {
  if (!leavesGaps(technique)) return technique;
  static std::deque<std::vector<const Knob*>> lists;  // stay where they are
  std::vector<const Knob*>& knobs = lists.emplace_back(technique.knobs.begin(), technique.knobs.end());
  knobs.push_back(&kFillKnob);
  knobs.push_back(&kKeepKnob);
  technique.knobs = knobs;
  return technique;
}

/// Descriptors stay where they are as long as there is room, and those that were added last go first: others point to them.
constexpr size_t kMostWarps = 64;

std::vector<WarpDescriptor>& registered() {
  static std::vector<WarpDescriptor> warps = [] {
    std::vector<WarpDescriptor> all;
    all.reserve(kMostWarps);
    for (const WarpDescriptor* warp : kWarps) all.push_back(completed(*warp));
    return all;
  }();
  return warps;
}

/// Whether some knob has that key or option already.
bool isKnobTaken(const Knob& knob) {
  const auto clashes = [&](const Knob& other) { return other.key == knob.key || (!knob.option.empty() && other.option == knob.option); };
  for (const MarchKnob& row : marchKnobs())
    if (clashes(*row.knob)) return true;
  for (const MarchText& text : marchTexts())
    if (text.key == knob.key || text.option == knob.option) return true;
  const std::vector<const Knob*> known = warpKnobs();
  return std::any_of(known.begin(), known.end(), [&](const Knob* other) { return (other != &knob || !knob.isOfPanel) && clashes(*other); });
}

}  // namespace

bool WarpDescriptor::has(const Knob& knob) const { return std::find(knobs.begin(), knobs.end(), &knob) != knobs.end(); }

bool WarpDescriptor::dependsOn(const MarchKnob& knob, const KnobValues& own) const {
  switch (knob.shapes) {
    case FramePart::picture: return true;
    case FramePart::depth: return uses.depth;
    case FramePart::radius: return uses.radius;
    case FramePart::samples: return usesFrame;
    case FramePart::planes: return uses.spread;  // the only one that a knob asks for
    case FramePart::segments: return uses.segments;
    case FramePart::proxy: return drawsProxy(*this, own);
  }
  return true;
}

bool WarpDescriptor::isBuiltAnew(const KnobValues& before, const KnobValues& now) const {
  return std::any_of(knobs.begin(), knobs.end(), [&](const Knob* knob) { return knob->stale < KnobStage::draw && before[*knob] != now[*knob]; });
}

std::span<const WarpDescriptor> warpRegistry() { return registered(); }

WarpRegistration::WarpRegistration(const WarpDescriptor& technique) : name_(technique.name) {
  if (registered().size() == kMostWarps) throw std::logic_error("no room for another technique");
  if (findNamed(registered(), technique.name) != nullptr) throw std::logic_error("there is a technique of this name already");
  for (const Knob* knob : technique.knobs)
    if (isKnobTaken(*knob)) throw std::logic_error("there is a knob of this key already: " + std::string(knob->key));
  registered().push_back(completed(technique));
}

WarpRegistration::~WarpRegistration() {
  std::erase_if(registered(), [this](const WarpDescriptor& warp) { return warp.name == name_; });
}

std::vector<const Knob*> warpKnobs() {
  std::vector<const Knob*> knobs;
  for (const WarpDescriptor& warp : registered())
    for (const Knob* knob : warp.knobs)
      if (std::find(knobs.begin(), knobs.end(), knob) == knobs.end()) knobs.push_back(knob);
  return knobs;
}

std::vector<std::string_view> ownersOf(const Knob& knob) {
  std::vector<std::string_view> owners;
  for (const WarpDescriptor& warp : registered())
    if (warp.has(knob)) owners.push_back(warp.name);
  return owners;
}

const WarpDescriptor& findWarp(std::string_view name) {
  if (const WarpDescriptor* warp = findNamed(warpRegistry(), name)) return *warp;
  throw UsageError(unknownNameIn(warpRegistry(), "technique", name));
}

std::unique_ptr<Warp> makeWarp(const WarpDescriptor& descriptor, const WarpResources& resources) {
  const auto makeOn = [&descriptor, resources](Backend backend) {
    WarpResources bound = resources;
    bound.backend = backend;
    std::unique_ptr<Warp> warp = descriptor.make(bound);
    return backend == Backend::cuda && descriptor.runsOnCuda ? std::move(warp) : makeHostFrameWarp(std::move(warp));
  };
  // One device for all that are made so: of each frame that is kept there is one.
  const auto make = [&descriptor, backend = resources.backend, onFallback = resources.onFallback, makeOn, hasFailed = std::make_shared<bool>(false)] {
    if (backend != Backend::automatic) return makeOn(backend);
    if (!descriptor.runsOnCuda || !cuda::whyUnavailable().empty()) return makeOn(Backend::cpu);
    return makeFallbackWarp([makeOn] { return makeOn(Backend::cuda); }, [makeOn] { return makeOn(Backend::cpu); }, onFallback, hasFailed);
  };
  return leavesGaps(descriptor) ? makeCompletedWarp(descriptor, make) : make();
}

MarchSettings neededBy(std::span<const TechniqueInUse> techniques, MarchSettings settings) {
  for (const MarchKnob& row : marchKnobs()) {
    if (row.shapes != FramePart::segments && row.shapes != FramePart::proxy) continue;
    if (std::ranges::none_of(techniques, [&](const TechniqueInUse& one) { return one.technique->dependsOn(row, one.knobs); }))
      row.set(settings, row.knob->defaultValue);
  }
  return settings;
}

std::string lackOf(const WarpDescriptor& technique, const MarchSettings& settings, const KnobValues& knobs) {
  const auto without = [](std::string_view what, const Knob& knob) { return "there " + std::string(what) + " (" + std::string(knob.option) + " 0)"; };
  if (technique.uses.segments && settings.sample.segments == 0) return without("are no segments", kSegmentsKnob);
  if (settings.sample.proxy > 0) return "";
  if (leavesGaps(technique)) return knobs.choice<Fill>(kFillKnob) == Fill::proxy ? without("is no copy of the volume to fill gaps with", kProxyKnob) : "";
  return technique.uses.proxy ? without("is no copy of the volume", kProxyKnob) : "";
}

void validate(const WarpSettings& settings) { validate(settings.reference); }

void resolveColors(const SampleFrame& frame, const Image<uint32_t>& samples, Image<glm::vec4>& color) {
  color.reshape(samples.width(), samples.height());
  const ColorTables& tables = ColorTables::instance();
  parallelForRanges(samples.size(), 1 << 15, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      color[i] = samples[i] < frame.size() ? tables.decode(frame.colors[samples[i]]) : glm::vec4(0.0f);
  });
}

}  // namespace warpscope
