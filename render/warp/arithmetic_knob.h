// The knob of techniques that can also be drawn by the forms of textbooks: core/arithmetic.h.
// One row for all of them: several techniques list it as theirs.
#pragma once

#include "render/base/knob.h"
#include "render/core/arithmetic.h"

namespace warpscope {

/// An Arithmetic. Each panel has its own.
extern const Knob kArithmeticKnob;

}  // namespace warpscope
