// Marching on a CUDA device, a thread for each ray.
// The rays' loop and its formulas are those of the CPU, bit for bit; see march_kernels.cuh.
#pragma once

#include "render/march/marcher.h"

namespace warpscope {

/// Copies the volume to the first CUDA device and keeps it there; twins share it. Throws DeviceError if there is no device, no CUDA in
/// this build, or not enough memory. Besides what marcher.h says, its calls throw DeviceError when the device fails them.
/// Frames' samples lie in page-locked memory (cuda/pinned_memory.h); those of marchToCode() stay on the device (march/cuda_frame.h).
MarcherPtr makeCudaMarcher(VolumePtr volume, TransferFunction transferFunction);

}  // namespace warpscope
