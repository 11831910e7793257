// The row.
// See arithmetic_knob.h.
#include "render/warp/arithmetic_knob.h"

namespace warpscope {
namespace {

constexpr auto kChoices = choicesOf(kArithmetics);

}  // namespace

constinit const Knob kArithmeticKnob{
    .key = "arithmetic",
    .option = "--arithmetic",
    .label = "Arithmetic",
    .noun = "arithmetic",
    .help = "In which form formulas are evaluated: stable, or as textbooks print them",
    .type = KnobType::choice,
    .stale = KnobStage::build,
    .isOfPanel = true,
    .defaultValue = static_cast<double>(Arithmetic::stable),
    .choices = kChoices,
    .axis = {"arithmetics", "--arithmetics", "Arithmetics, by name"},
    .phrase = ", {} arithmetic",
    .naming = KnobNaming::unlessDefault,
};

}  // namespace warpscope
