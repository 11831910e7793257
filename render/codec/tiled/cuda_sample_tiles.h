// Tiles of a frame's samples made and read by a CUDA device: the bytes of tiled_samples.h. For .cu files.
#pragma once

#include <vector>

#include "render/codec/codec.h"
#include "render/codec/tiled/cuda_tiles.h"
#include "render/march/cuda_frame.h"

namespace warpscope {

struct SampleView;

/// In two steps, between which the device works: begin, and append or take, of the same frame.
class CudaSampleTiles : public CudaTiles {
 public:
  CudaSampleTiles() : CudaTiles(cuda::Urgency::usual) {}

  /// False for a frame that is not for a device: without tiles, or with more bytes than it counts.
  static bool takes(const SampleFrame& frame);

  void beginToAppend(const SampleFrame& frame, Placement placement);

  /// `count` samples, to `held`, which must stay until take(), and to the host unless that is not their place.
  DecodeError beginToTake(ByteReader& reader, Placement placement, size_t count, const SampleFrame& frame, CudaFrame& held, DecodedPlace place);
  /// Fills samples and colours of the frame, and kLayerPlane if it has that, with what came to the host.
  DecodeError take(SampleFrame& frame, CudaFrame& held);
  /// Waits for what is under way, and drops it.
  void settle() noexcept {
    wait();
    takenSamples_ = {};
    takenColors_ = {};
    takenLayers_ = {};
  }

 private:
  struct Memory {
    PackedSample* samples;
    Rgba8* colors;
    uint8_t* layers;  // null where each sample is its ray's only one
  };
  static Memory roomIn(CudaFrameBuffers& held, size_t count, bool hasLayers);
  SampleView viewOf(const SampleFrame& frame, Placement placement, uint32_t count, const Memory& memory);

  CudaFrameBuffers uploaded_;  // of frames that are not on the device
  // Of what is taken.
  size_t count_ = 0;
  uint64_t hashSent_ = 0;
  TransferVector<PackedSample> takenSamples_;
  TransferVector<Rgba8> takenColors_;
  TransferVector<std::byte> takenLayers_;
};

}  // namespace warpscope
