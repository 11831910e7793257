// A frame's spheres in Morton order, sorted on the device: what hierarchies are built over. For .cu files and what they include.
// Codes as lbvh.h defines them; CUB's radix sort (Merrill, Grimshaw 2011; Adinets, Merrill 2022, "Onesweep").
#pragma once

#include "render/warp/device/device_frame.h"
#include "render/warp/lbvh/lbvh.h"

namespace warpscope {

class SortedCloud {
 public:
  /// Sorts by the `codeBits` highest of the codes' 63 bits; equal ones keep the frame's order. In stream order, without waiting.
  void build(const DeviceFrameView& frame, int codeBits, cudaStream_t stream);

  uint32_t count() const { return count_; }
  const uint64_t* codes() const { return codes_.data(); }
  /// Place in the frame of each.
  const uint32_t* ids() const { return ids_.data(); }
  /// At least the distance of any point of any sphere from the coordinates' origin.
  float reach() const { return reach_; }

 private:
  uint32_t count_ = 0;
  float reach_ = 0.0f;
  cuda::DeviceBuffer<uint32_t> bounds_{6};  // of the centres, as ordered integers: three lower, three upper
  cuda::DeviceBuffer<uint64_t> codes_, unsortedCodes_;
  cuda::DeviceBuffer<uint32_t> ids_, unsortedIds_;
  cuda::Scratch scratch_;
};

}  // namespace warpscope
