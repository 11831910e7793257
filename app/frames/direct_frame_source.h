// Frames without a network: marches in a thread of its own, behind the models of a link, run by a clock. For tests and measurements in
// virtual time; what it delays are times, not bytes.
#pragma once

#include <functional>
#include <memory>

#include "app/frames/frame_source.h"
#include "render/march/marcher.h"

namespace warpscope {

/// A request takes the link's way up, then its turn; the frame is marched, and takes the way down with as many bytes as its samples have in the
/// raw format. `clock` must outlive the source. `onNews` is called on its thread after each answer.
std::unique_ptr<FrameSource> makeDirectFrameSource(MarcherPtr marcher, Clock& clock, std::function<void()> onNews);

}  // namespace warpscope
