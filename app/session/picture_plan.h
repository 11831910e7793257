// What a panel has to do for its next picture: the smallest set of stages after what it did last, each with the reason
// for which it is in or out. As data, so that its worker goes by it, tests hold it to account and people read it. For
// the march: render/effects/effect_plan.h.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "app/session/warp_job.h"
#include "render/base/knob.h"
#include "render/effects/effect_plan.h"

namespace warpscope {

/// Whether shortcuts may take a technique's place. Off unless the window's user wants them: what is compared is what
/// techniques draw.
extern const Knob kShortcutsKnob;

/// Where a picture comes from.
enum class PictureWay {
  technique,   ///< which draws it
  ownPicture,  ///< the frame's, whose camera it has
  rotation,    ///< of that, where the eye is the frame's and the camera is another
};

/// What the window says of a picture that no technique drew; empty for the others. Half a sentence.
std::string_view shortcutText(PictureWay way);

/// In the order in which they are decided.
enum class PictureStage {
  ownPicture,  ///< of the frame
  rotation,    ///< of the frame's own picture
  technique,   ///< making it
  build,       ///< what it derives from a frame
  draw,        ///< by the technique
  toScreen,    ///< colours over what lies behind them
  judge,       ///< an image for the ground truth's camera
};

struct PictureStageDescriptor {
  PictureStage stage;
  std::string_view name;     ///< as JSON says it
  std::string_view summary;  ///< what it is
};

/// Every stage, in their order.
inline constexpr std::array<PictureStageDescriptor, 7> kPictureStages{{
    {PictureStage::ownPicture, "own-picture", "showing the frame as its own camera sees it"},
    {PictureStage::rotation, "rotation", "turning the frame's own picture"},
    {PictureStage::technique, "technique", "making the technique"},
    {PictureStage::build, "build", "deriving from the frame what is drawn from"},
    {PictureStage::draw, "draw", "drawing by the technique"},
    {PictureStage::toScreen, "to-screen", "putting colours over what lies behind them"},
    {PictureStage::judge, "judge", "an image to be compared with the ground truth"},
}};

/// What a panel's worker has in hand when a job comes. Pictures and techniques themselves are the worker's.
struct EaselState {
  const WarpDescriptor* technique = nullptr;  ///< that is made; null: none is
  uint64_t scene = 0;                         ///< that it was made for
  MarcherPtr marcher;                         ///< that it was made with

  bool isBuilt = false;  ///< it was given a frame:
  SampleFramePtr built;
  KnobValues builtWith;  ///< the techniques' knobs at that time

  bool hasPicture = false;
  PictureWay way = PictureWay::technique;  ///< of that picture, as all that follows
  SampleFramePtr frame;
  Camera camera;
  WarpSettings settings;
  glm::vec3 background{0.0f};
  PixelMarks marks;
  bool isOnDevice = false;  ///< which put it over its background as it drew

  std::shared_ptr<const ReferenceImage> reference;  ///< that was judged against last
};

class PicturePlan {
 public:
  /// Nothing is in, without a reason.
  PicturePlan() = default;
  PicturePlan(const EaselState& last, const WarpJob& job);

  PictureWay way() const { return way_; }
  bool has(PictureStage stage) const { return (*this)[stage].isIn; }
  const PlannedStage& operator[](PictureStage stage) const { return stages_[static_cast<size_t>(stage)]; }

 private:
  PictureWay way_ = PictureWay::technique;
  std::array<PlannedStage, kPictureStages.size()> stages_;
};

}  // namespace warpscope
