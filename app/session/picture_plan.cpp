// The rules of the plan: one for each stage, after those that it depends on.
// See picture_plan.h.
#include "app/session/picture_plan.h"

#include <utility>

namespace warpscope {
namespace {

PlannedStage in(std::string reason) { return {true, std::move(reason)}; }
PlannedStage out(std::string reason) { return {false, std::move(reason)}; }

constexpr const char* kOnShow = "what is on show is it already";
constexpr const char* kShortcut = "a shortcut takes the technique's place";

/// What a rule is asked about.
struct PictureQuestion {
  const EaselState& last;
  const WarpJob& job;
  const PicturePlan& plan;  ///< of the stages before this one

  std::string name() const { return std::string(job.technique->name); }

  /// Why the frame itself does not say what this camera sees, or must not; empty if it may.
  std::string whyNoShortcut() const {
    if (!job.technique->usesFrame) return name() + " draws from no frame";
    if (!job.frame) return "there is no frame";
    if (!job.takesShortcuts) return "shortcuts are switched off: the technique is shown";
    return {};
  }
  // Where there is a frame:
  bool isFramesCamera() const { return job.camera == job.frame->camera; }
  bool isFramesEye() const { return job.camera.eye == job.frame->camera.eye; }

  bool isShortcut() const { return plan.way() != PictureWay::technique; }
  /// Whether the last picture came the same way, and shows that frame to that camera.
  bool isOfSameView() const {
    return last.hasPicture && last.way == plan.way() && last.frame == job.frame && last.camera == job.camera;
  }
  bool isBehindChanged() const { return last.background != job.background || last.marks != job.marks; }
};

PictureWay wayOf(const PictureQuestion& q) {
  if (!q.whyNoShortcut().empty()) return PictureWay::technique;
  if (q.isFramesCamera()) return PictureWay::ownPicture;
  return q.isFramesEye() ? PictureWay::rotation : PictureWay::technique;
}

struct PictureRule {
  PictureStage stage;
  PlannedStage (*plan)(const PictureQuestion&);
};

/// One for each stage, in their order.
constexpr std::array<PictureRule, kPictureStages.size()> kRules{{
    {PictureStage::ownPicture,
     [](const PictureQuestion& q) {
       if (std::string why = q.whyNoShortcut(); !why.empty()) return out(std::move(why));
       if (!q.isFramesCamera()) return out("the camera is not the frame's");
       return q.isOfSameView() ? out(kOnShow) : in("the camera is the frame's own");
     }},
    {PictureStage::rotation,
     [](const PictureQuestion& q) {
       if (std::string why = q.whyNoShortcut(); !why.empty()) return out(std::move(why));
       if (q.isFramesCamera()) return out("the camera is the frame's own: nothing is turned");
       if (!q.isFramesEye()) return out("the eye is not the frame's: what is seen depends on depths");
       return q.isOfSameView() ? out(kOnShow) : in("the eye is the frame's: what is seen depends on no depth");
     }},
    {PictureStage::technique,
     [](const PictureQuestion& q) {
       if (q.isShortcut()) return out(kShortcut);
       if (q.last.technique == nullptr) return in("there is none yet");
       if (q.last.technique != q.job.technique) return in("it was " + std::string(q.last.technique->name));
       if (q.last.scene != q.job.scene) return in("the scene is another one");
       if (q.job.technique->usesFrame) return out("it is there");
       return q.last.marcher != q.job.marcher ? in("it marches, and by another transfer function") : out("it is there");
     }},
    {PictureStage::build,
     [](const PictureQuestion& q) {
       if (q.isShortcut()) return out(kShortcut);
       if (!q.job.technique->usesFrame) return out(q.name() + " draws from no frame");
       if (q.plan.has(PictureStage::technique)) return in("the technique is new");
       if (!q.last.isBuilt || q.last.built != q.job.frame) return in("the frame is new");
       if (q.job.technique->isBuiltAnew(q.last.builtWith, q.job.settings.knobs))
         return in("a knob was turned that it is built by");
       return out("the frame is the one that it was built from");
     }},
    {PictureStage::draw,
     [](const PictureQuestion& q) {
       if (q.isShortcut()) return out(kShortcut);
       if (q.plan.has(PictureStage::technique)) return in("the technique is new");
       if (q.plan.has(PictureStage::build)) return in("what it draws from is new");
       if (!q.last.hasPicture || q.last.way != PictureWay::technique) return in("it has drawn nothing of this yet");
       if (q.last.camera != q.job.camera) return in("the camera moved");
       if (q.last.settings != q.job.settings) return in("a knob was turned that it draws by");
       if (q.last.isOnDevice && q.isBehindChanged()) return in("the device that drew it put it over another colour");
       return out(kOnShow);
     }},
    {PictureStage::toScreen,
     [](const PictureQuestion& q) {
       for (const PictureStage stage : {PictureStage::ownPicture, PictureStage::rotation, PictureStage::draw})
         if (q.plan.has(stage)) return in("its colours are new");
       return q.isBehindChanged() ? in("another colour lies behind it") : out(kOnShow);
     }},
    {PictureStage::judge,
     [](const PictureQuestion& q) {
       if (!q.job.reference) return out("there is no ground truth");
       if (q.job.reference->job().camera == q.job.camera) return in("the ground truth is of this camera");
       if (q.job.reference == q.last.reference) return out("the ground truth is an earlier camera's, and was judged");
       if (q.isShortcut()) return out("the ground truth is an earlier camera's, and the technique is not at work");
       return in("the ground truth is new, though an earlier camera's");
     }},
}};

constexpr bool areInOrder() {
  for (size_t i = 0; i < kRules.size(); ++i)
    if (kRules[i].stage != kPictureStages[i].stage || static_cast<size_t>(kRules[i].stage) != i ||
        kRules[i].plan == nullptr)
      return false;
  return true;
}
static_assert(areInOrder(), "each stage has a row and a rule, in the order of PictureStage");

}  // namespace

constinit const Knob kShortcutsKnob{
    .key = "shortcuts",
    .option = "--shortcuts",
    .label = "Shortcuts",
    .noun = "shortcuts",
    .help =
        "Where the eye is the frame's, show the frame's own picture, turned if need be, instead of drawing by the "
        "technique",
    .type = KnobType::flag,
    .owner = KnobOwner::display,
    .stale = KnobStage::draw,
    .defaultValue = 0.0,
};

std::string_view shortcutText(PictureWay way) {
  switch (way) {
    case PictureWay::technique:
      return "";
    case PictureWay::ownPicture:
      return "the frame's own picture";
    case PictureWay::rotation:
      return "the frame's picture, turned: no depth";
  }
  return "";
}

PicturePlan::PicturePlan(const EaselState& last, const WarpJob& job) {
  const PictureQuestion question{last, job, *this};
  way_ = wayOf(question);
  for (const PictureRule& rule : kRules) stages_[static_cast<size_t>(rule.stage)] = rule.plan(question);
}

}  // namespace warpscope
