// Which hardware marches and warps: chosen by name, with a reason where the choice is not possible.
// Backends: cpu (every machine), cuda (an NVIDIA GPU), auto (the best there is).
#pragma once

#include <string>
#include <string_view>

#include "render/march/marcher.h"

namespace warpscope {

enum class Backend { automatic, cpu, cuda };

/// Why the CUDA backend cannot be used here; empty if it can.
std::string whyNoCuda();

/// A marcher on the chosen backend. Throws InputError with the reason if `backend` is cuda and it cannot be used.
MarcherPtr makeMarcher(Backend backend, VolumePtr volume, TransferFunction transferFunction);

}  // namespace warpscope
