// Image warping: redrawing a frame's samples for another camera. One interface, one file pair per technique, one registry.
// The techniques compared by Zellmann 2020, and those added since; see each technique's header.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/knob.h"
#include "render/core/backend.h"
#include "render/core/device_picture.h"
#include "render/core/image.h"
#include "render/march/march_knobs.h"
#include "render/march/marcher.h"
#include "render/march/sample_frame.h"

namespace warpscope {

namespace gl {
class Context;
}

/// Id of pixels that show something that is not one of the frame's samples (the reference).
inline constexpr uint32_t kNotASample = 0xfffffffeu;
/// Id of pixels that show something which no frame has: a guess (fill.h).
inline constexpr uint32_t kFilled = 0xfffffffdu;
/// Ids of pixels that show a frame before the newest (kept_frames.h): this one of the last that was kept, one more for each further back.
inline constexpr uint32_t kOfEarlierFrame = 0xfffffff0u;
/// Which of the frames that were kept the pixel's is, counted back from the newest frame; 0 for the newest's own, and for ids that say nothing of it.
inline uint32_t framesBack(uint32_t id) { return id >= kOfEarlierFrame && id < kFilled ? id - kOfEarlierFrame + 1 : 0; }

/// A warped picture. Pixels that nothing covers are kept apart: their id is kNoSample and their colour is 0.
struct WarpedImage {
  Image<glm::vec4> color;   ///< linear, premultiplied
  Image<uint32_t> samples;  ///< index of the sample seen in each pixel, kNotASample, kOfEarlierFrame and following, kFilled or kNoSample
};

/// Colours that show how pixels came about; 0: as they are.
struct PixelMarks {
  Rgba8 uncovered = 0;  ///< of pixels that nothing covers
  Rgba8 filled = 0;     ///< of those that show a guess

  bool operator==(const PixelMarks&) const = default;
  /// The colour of a pixel with that id, opaque; 0: as it is. For host and device.
  WARPSCOPE_HD Rgba8 of(uint32_t sample) const {
    const Rgba8 mark = sample == kNoSample ? uncovered : sample == kFilled ? filled : 0;
    return mark != 0 ? mark | 0xff000000u : 0;
  }
};

/// The client's knobs.
struct WarpSettings {
  KnobValues knobs;          ///< of the techniques; each reads its own
  RenderSettings reference;  ///< what the ground truth is, for `reference`

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

  /// Takes the frame to draw from now on and builds whatever drawing it needs (a hierarchy, a vertex buffer). Techniques on a device take frames that are away
  /// (SampleFrame::isAway) as well; whatever makeWarp makes takes all.
  virtual void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop = {}) = 0;

  /// Draws the frame as `camera` sees it; both images get the camera's size. Without a frame nothing is covered.
  /// Throws InputError for an unusable camera, OperationCancelled if `stop` is set.
  virtual void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image,
                    const std::stop_token& stop = {}) = 0;

  /// As draw, but composited over an opaque background (linear RGB), with marks, and left on the device that drew it. Null where the technique draws to
  /// host memory, or has no frame: draw() is the way then.
  virtual DevicePicturePtr drawForScreen(const Camera&, const WarpSettings&, const glm::vec3& /*background*/, const PixelMarks&,
                                         const std::stop_token& = {}) {
    return nullptr;
  }

  /// Nothing where no device is at work.
  virtual std::optional<DeviceTimings> deviceTimings() const { return std::nullopt; }
};

/// What of a frame's samples a technique's picture depends on, besides their colours.
struct SampleUse {
  bool depth = false;
  bool radius = false;
  bool segments = false;
  bool proxy = false;
  bool spread = false;  ///< of depth, where frames have it
};

/// A technique, as its own file describes it.
struct WarpDescriptor {
  std::string_view name;
  std::string_view label;    ///< as a person reads it
  std::string_view summary;  ///< one line for help texts
  bool usesFrame = true;     ///< false for the reference, which needs no samples
  bool runsOnCuda = false;   ///< its maker has an own way for the backend cuda
  bool usesOpenGl = false;   ///< its maker asks for a context
  SampleUse uses{};
  std::span<const Knob* const> knobs{};  ///< its own; the registry adds those of all that leave gaps (fill.h, kept_frames.h)
  std::unique_ptr<Warp> (*make)(const WarpResources&) = nullptr;

  bool has(const Knob& knob) const;
  /// Whether its picture changes with that knob of the marching, where its own are set so.
  bool dependsOn(const MarchKnob& knob, const KnobValues& own = {}) const;
  /// Whether what it derived from a frame with `before` is of no use with `now`.
  bool isBuiltAnew(const KnobValues& before, const KnobValues& now) const;
};

/// Every technique, in the order in which they are shown.
std::span<const WarpDescriptor> warpRegistry();

/// Adds a technique while it lives; not beside other threads. Those that live at once end in the opposite order. For extensions and tests: the program's own are lines of the registry.
class WarpRegistration {
 public:
  /// Throws std::logic_error for a name, or the key of another knob, that there is already, or where there is no room.
  explicit WarpRegistration(const WarpDescriptor& technique);
  ~WarpRegistration();
  WarpRegistration(const WarpRegistration&) = delete;
  WarpRegistration& operator=(const WarpRegistration&) = delete;

 private:
  const std::string_view name_;
};

/// Every technique's own knobs, in the order of the techniques; one of several techniques once.
std::vector<const Knob*> warpKnobs();

/// The names of the techniques whose own knob it is.
std::vector<std::string_view> ownersOf(const Knob& knob);

/// The named technique; throws UsageError that lists the nearest names.
const WarpDescriptor& findWarp(std::string_view name);

/// Makes a technique on the backend that `resources` name: where that is automatic, on a CUDA device if there is one, and on the CPU from
/// the moment that the device fails, which `onFallback` is then told, once, with the reason. Throws as the technique's maker does.
std::unique_ptr<Warp> makeWarp(const WarpDescriptor& descriptor, const WarpResources& resources);

/// A technique, and how its knobs are set.
struct TechniqueInUse {
  const WarpDescriptor* technique = nullptr;
  KnobValues knobs;
};

/// `settings` without the parts of frames that none of the techniques draws: segments, and the copy of the volume.
MarchSettings neededBy(std::span<const TechniqueInUse> techniques, MarchSettings settings);

/// Why the technique, with its knobs set so, would show nothing of frames that are marched so, or not what its knobs say: half a sentence, "there are no
/// segments (--segments 0)". Empty where it shows something.
std::string lackOf(const WarpDescriptor& technique, const MarchSettings& settings, const KnobValues& knobs = {});

/// Throws UsageError naming the setting that is out of range: of `reference`, which techniques of frames do not look at.
void validate(const WarpSettings& settings);

/// Gives every covered pixel its sample's colour. `samples` is the only input; resizes `color`.
void resolveColors(const SampleFrame& frame, const Image<uint32_t>& samples, Image<glm::vec4>& color);

}  // namespace warpscope
