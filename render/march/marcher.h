// What marches a volume: one interface, one implementation per backend.
// A marcher is bound to a volume and a transfer function and keeps what it derives from them; for another function it makes another marcher.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>

#include "render/core/backend.h"
#include "render/core/image.h"
#include "render/core/turns.h"
#include "render/core/transfer_function.h"
#include "render/effects/effect_plan.h"
#include "render/march/march_settings.h"
#include "render/march/sample_frame.h"
#include "render/volume/volume.h"

namespace warpscope {

class Marcher;
using MarcherPtr = std::shared_ptr<Marcher>;

/// Whether a marcher's pictures keep up with a camera that moves.
enum class MarchPace {
  afterRest,      ///< a picture takes so long that the ground truth waits until the camera rests
  followsCamera,  ///< several pictures a second: the ground truth follows the camera
};

/// Where the volume is that a marcher marches.
enum class VolumePlace {
  elsewhere,  ///< in another process: volume() is null
  here,       ///< in this one, all of it
};

/// Where a marcher's pictures are compared with others soonest.
enum class JudgePlace { host, cudaDevice };

/// Whether a marcher can be asked for one of another transfer function.
enum class FunctionChange {
  refused,   ///< the transfer function is another's to choose
  followed,  ///< in far less time than a marcher takes that is made anew
};

/// What a marcher can do, for those who plan with it and need not know what it is.
struct MarcherCapabilities {
  MarchPace pace = MarchPace::afterRest;
  VolumePlace volume = VolumePlace::here;
  JudgePlace judging = JudgePlace::host;
  FunctionChange functionChange = FunctionChange::followed;

  bool operator==(const MarcherCapabilities&) const = default;
};

class Marcher {
 public:
  virtual ~Marcher() = default;

  /// The server's work: a frame of samples for `camera`. Fills timings, leaves requestId 0.
  /// Throws UsageError for settings out of range, InputError for a camera that isUsable() refuses, OperationCancelled if `stop` is set.
  /// Safe to call from several threads; calls may wait for each other.
  virtual SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop = {}) = 0;

  /// As march(), for who hands the frame to a codec that works where it was marched (FrameCodec::codesOnDevices) and looks at no sample: what was found may be left
  /// there, see SampleFrame::device.
  virtual SampleFrame marchToCode(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop = {}) { return march(camera, settings, stop); }

  /// The same rays' colours at full precision, linear and premultiplied: the ground truth of warping. Errors as for march().
  virtual void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image,
                      const std::stop_token& stop = {}) = 0;

  /// Null where capabilities() say that it is elsewhere.
  virtual const VolumePtr& volume() const = 0;
  /// Where it marches, cpu or cuda: for reports. What depends on it asks for capabilities.
  virtual Backend backend() const = 0;
  /// May change from call to call: a marcher may go on elsewhere when a device fails.
  virtual MarcherCapabilities capabilities() const = 0;

  /// What it has to do for a picture, or a frame of such samples; nothing where another process plans. Throws UsageError for settings out of range.
  virtual std::optional<EffectPlan> plan(const RenderSettings&, const std::optional<SampleSettings>&) const { return std::nullopt; }

  /// Another marcher of the same volume: it shares what never changes, and its calls do not wait for this one's. Where there are `turns`,
  /// it marches in those alone, and its calls throw WorkLimitExceeded where they take longer than those allow.
  virtual MarcherPtr twin(TurnsPtr turns) const = 0;
  MarcherPtr twin() const { return twin(nullptr); }

  /// Another marcher of the same volume in the same turns, by another transfer function: it shares whatever does not depend on the function, and so do
  /// those that come of it; its calls do not wait for this one's. Its pictures are those of a marcher that was made with the function.
  /// Throws UsageError, with the reason, where capabilities() say that it is refused.
  virtual MarcherPtr withTransferFunction(TransferFunction function) const = 0;
};

}  // namespace warpscope
