// In which form formulas are evaluated: the one that this program stands for, or the one that textbooks print.
// Forms that are equal on paper, and not in floating point (Higham 2002, chapter 1); `textbook` is there to be compared with.
#pragma once

#include <array>

#include "render/base/named_value.h"

namespace warpscope {

enum class Arithmetic {
  stable,    ///< each formula in a form whose error is bounded
  textbook,  ///< in single precision: b^2 - 4ac, t += dt, 1 - (1 - a)^ds, accumulated opacity, one table over the range
};

inline constexpr std::array<NamedValue<Arithmetic>, 2> kArithmetics{{
    {Arithmetic::stable, "stable", "forms whose rounding errors are bounded"},
    {Arithmetic::textbook, "textbook", "forms as textbooks print them, in single precision, to be compared with"},
}};

}  // namespace warpscope
