// What pixels show that a technique covers with nothing of its frame: the knob of every technique that leaves gaps.
// The coarse copy of the volume (proxy_fill.h), or what lies about a gap (pull_push.h).
#pragma once

#include "render/base/knob.h"
#include "render/effects/mode_settings.h"

namespace warpscope {

struct WarpDescriptor;

enum class Fill { automatic, none, proxy, pullPush };
extern const Knob kFillKnob;

/// Whether there are places of which a technique's frames do not say what is there, and for which it could be asked of others.
bool leavesGaps(const WarpDescriptor& technique);

/// How gaps of that technique are filled with its knobs set so; never `automatic`.
Fill fillOf(const WarpDescriptor& technique, const KnobValues& knobs);

/// Whether its rays go on through the copy themselves where the frame knows nothing, in frames by that mode. Not where greatest values are shown: those of parts do not add up,
/// and the whole ray's is compared instead (completed_warp.h).
bool goesOnThroughProxy(const WarpDescriptor& technique, RenderMode mode);

/// Whether its picture depends on the copy of the volume then.
bool drawsProxy(const WarpDescriptor& technique, const KnobValues& knobs);

}  // namespace warpscope
