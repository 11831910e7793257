// Image warping: redrawing a frame's samples for another camera. One interface, one file pair per technique, one registry.
// The techniques compared by Zellmann 2020, and those added since; see each technique's header.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "render/core/backend.h"
#include "render/core/device_picture.h"
#include "render/core/image.h"
#include "render/march/marcher.h"
#include "render/march/sample_frame.h"

namespace warpscope {

namespace gl {
class Context;
}

/// Id of pixels that show something that is not one of the frame's samples (the reference).
inline constexpr uint32_t kNotASample = 0xfffffffeu;

/// A warped picture. Pixels that nothing covers are kept apart: their id is kNoSample and their colour is 0.
struct WarpedImage {
  Image<glm::vec4> color;   ///< linear, premultiplied
  Image<uint32_t> samples;  ///< index of the sample seen in each pixel, kNotASample or kNoSample
};

enum class SphereTracing {
  automatic,  ///< what is fastest where the technique runs: lbvh on the CPU, clusters on a CUDA device
  lbvh,       ///< the binary hierarchy of Karras 2012
  clusters,   ///< the hierarchy as wide as a warp, on CUDA devices only
  embree,     ///< on the CPU only
};

inline constexpr std::array<NamedValue<SphereTracing>, 4> kSphereTracings{{
    {SphereTracing::automatic, "auto", "what is fastest: lbvh on the CPU, clusters on a CUDA device"},
    {SphereTracing::lbvh, "lbvh", "the binary hierarchy of Karras 2012"},
    {SphereTracing::clusters, "clusters", "boxes of 32 neighbours each, as wide as a warp; CUDA only"},
    {SphereTracing::embree, "embree", "Embree's; CPU only"},
}};

/// The client's knobs.
struct WarpSettings {
  int pointSize = 2;                                    ///< pixels, 1..16, for `points`
  SphereTracing sphereTracing = SphereTracing::automatic;    ///< for `spheres`
  int hits = 4;                                         ///< along a ray, 1..kMaxHits, for `multihit`
  RenderSettings reference;                             ///< for `reference`

  bool operator==(const WarpSettings&) const = default;
};

/// What techniques may draw on. A technique uses the parts it needs and says in its descriptor if those cost something to make.
struct WarpResources {
  MarcherPtr marcher;                      ///< for the volume that the frames show
  std::function<gl::Context&()> context;   ///< makes (once) and returns a context for the calling thread; throws InputError
  Backend backend = Backend::cpu;          ///< where techniques draw that have the choice; a maker gets cpu or cuda, makeWarp any
  std::function<void(const std::string&)> onFallback;  ///< for makeWarp; may be empty
};

/// What a device took for its part of the last setFrame and draw, between events on the device.
struct DeviceTimings {
  double uploadMs = 0.0;  ///< copying the frame to the device
  double buildMs = 0.0;
  double drawMs = 0.0;    ///< up to the finished colours in the device's memory
};

/// One technique, bound to its resources. Used from one thread at a time: the one that made it.
class Warp {
 public:
  virtual ~Warp() = default;

  /// Takes the frame to draw from now on and builds whatever drawing it needs (a hierarchy, a vertex buffer).
  virtual void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop = {}) = 0;

  /// Draws the frame as `camera` sees it; both images get the camera's size. Without a frame nothing is covered.
  /// Throws InputError for an unusable camera, OperationCancelled if `stop` is set.
  virtual void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image,
                    const std::stop_token& stop = {}) = 0;

  /// As draw, but composited over an opaque background (linear RGB) and left on the device that drew it; pixels that nothing covers show
  /// `uncovered` if it is not 0. Null where the technique draws to host memory, or has no frame: draw() is the way then.
  virtual DevicePicturePtr drawForScreen(const Camera&, const WarpSettings&, const glm::vec3& /*background*/, Rgba8 /*uncovered*/,
                                         const std::stop_token& = {}) {
    return nullptr;
  }

  /// Nothing where no device is at work.
  virtual std::optional<DeviceTimings> deviceTimings() const { return std::nullopt; }
};

/// What of a frame and of the client's knobs a technique's picture depends on, besides colours and cameras.
struct WarpKnobs {
  bool depth = false;   ///< the samples' depths, and with them the heuristic
  bool radius = false;  ///< the samples' radii, and with them their policy
  bool pointSize = false;
  bool hits = false;
};

struct WarpDescriptor {
  std::string_view name;
  std::string_view label;    ///< as a person reads it
  std::string_view summary;  ///< one line for help texts
  bool usesFrame;            ///< false for the reference, which needs no samples
  bool runsOnCuda;           ///< its maker has an own way for the backend cuda
  WarpKnobs knobs;
  std::unique_ptr<Warp> (*make)(const WarpResources&);
};

/// Every technique, in the order in which they are shown.
std::span<const WarpDescriptor> warpRegistry();

/// The named technique; throws UsageError that lists the nearest names.
const WarpDescriptor& findWarp(std::string_view name);

/// Makes a technique on the backend that `resources` name: where that is automatic, on a CUDA device if there is one, and on the CPU from
/// the moment that the device fails, which `onFallback` is then told, once, with the reason. Throws as the technique's maker does.
std::unique_ptr<Warp> makeWarp(const WarpDescriptor& descriptor, const WarpResources& resources);

/// Throws UsageError naming the setting that is out of range.
void validate(const WarpSettings& settings);

/// Gives every covered pixel its sample's colour. `samples` is the only input; resizes `color`.
void resolveColors(const SampleFrame& frame, const Image<uint32_t>& samples, Image<glm::vec4>& color);

}  // namespace warpscope
