// Gaps of a picture filled from what lies about them.
// Pull-push (Gortler, Grzeszczuk, Szeliski, Cohen 1996, "The Lumigraph", 3.3): averages over ever larger squares, and back. Deviation: only gaps that are
// enclosed are filled, because what lies beside a thing is mostly background, and a picture does not tell background from a gap.
#pragma once

#include <stop_token>

#include "render/warp/warp.h"

namespace warpscope {

/// A gap is a pixel without a sample that sees covered ones in at least so many of the four directions along its row and column.
inline constexpr int kEnclosedBy = 3;

/// Gives the gaps of `image` colours, and the id kFilled. Colours are averaged premultiplied. Throws OperationCancelled if `stop` is set: then the picture is
/// as it was.
void fillGaps(WarpedImage& image, const std::stop_token& stop = {});

}  // namespace warpscope
