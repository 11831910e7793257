// The row, and what it means for each technique.
// See fill.h.
#include "render/warp/fill.h"

#include "render/warp/warp.h"

namespace warpscope {
namespace {

constexpr std::array<NamedValue<Fill>, 4> kFills{{
    {Fill::automatic, "auto", "as the technique is meant: segments go on through the copy, samples leave gaps"},
    {Fill::none, "none", "gaps stay gaps"},
    {Fill::proxy, "proxy", "the coarse copy of the volume"},
    {Fill::pullPush, "pull-push", "what lies about them, where they are enclosed"},
}};
constexpr auto kChoices = choicesOf(kFills);
constexpr double kSwept[] = {static_cast<double>(Fill::automatic)};

}  // namespace

constinit const Knob kFillKnob{
    .key = "fill",
    .option = "--fill",
    .label = "Fill",
    .noun = "filling of gaps",
    .help = "What pixels show that no frame says anything about (pull-push: Gortler, Grzeszczuk, Szeliski, Cohen 1996)",
    .type = KnobType::choice,
    .isOfPanel = true,
    .defaultValue = static_cast<double>(Fill::automatic),
    .choices = kChoices,
    .axis = {"fills", "--fills", "Fillings of gaps, by name", kSwept},
    .phrase = ", filled by {}",
    .naming = KnobNaming::unlessDefault,
};

bool leavesGaps(const WarpDescriptor& technique) { return technique.uses.depth || technique.uses.segments; }

Fill fillOf(const WarpDescriptor& technique, const KnobValues& knobs) {
  const auto fill = knobs.choice<Fill>(kFillKnob);
  if (fill != Fill::automatic) return fill;
  return technique.uses.proxy ? Fill::proxy : Fill::none;
}

bool goesOnThroughProxy(const WarpDescriptor& technique, RenderMode mode) { return technique.uses.proxy && mode != RenderMode::mip; }

bool drawsProxy(const WarpDescriptor& technique, const KnobValues& knobs) {
  return leavesGaps(technique) ? fillOf(technique, knobs) == Fill::proxy : technique.uses.proxy;
}

}  // namespace warpscope
