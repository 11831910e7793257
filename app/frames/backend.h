// The hardware that marches, and saying when a choice had to be given up.
// Backends: core/backend.h.
#pragma once

#include <string>

#include "render/codec/tiled/tiled_coder.h"
#include "render/core/backend.h"
#include "render/march/marcher.h"
#include "render/march/ray_relay.h"

namespace warpscope {

/// As makeMarcher() of render/march/marcher_registry.h; a fallback is reported as below.
MarcherPtr makeMarcher(Backend backend, VolumePtr volume, TransferFunction transferFunction);

/// What a process that has a part of a volume marches it by. Throws DeviceError where `backend` cannot be used; of automatic, a fallback is reported as below.
PieceMaker makePieces(Backend backend);

/// Who makes tiles of frames there (tiled_coder.h); automatic: on a device, if there is one. A fallback is reported as below.
TiledCoderPtr makeTiledCoder(Backend backend);

/// What works on that backend, in words: "16 CPU threads", or the first device and its driver.
std::string deviceText(Backend backend);

/// Says on stderr, once for each reason, that the device failed and the CPU goes on.
void reportFallback(const std::string& reason);

}  // namespace warpscope
