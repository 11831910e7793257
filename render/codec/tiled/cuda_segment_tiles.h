// Tiles of a frame's segments made and read by a CUDA device: the bytes of tiled_segments.h. For .cu files.
#pragma once

#include <vector>

#include "render/codec/codec.h"
#include "render/codec/tiled/cuda_tiles.h"
#include "render/march/cuda_frame.h"

namespace warpscope {

struct SegmentView;

/// In steps, between which the device works: begin, and append or take, of the same frame.
class CudaSegmentTiles : public CudaTiles {
 public:
  CudaSegmentTiles() : CudaTiles(cuda::Urgency::first) {}  // they take longer than samples, and both are waited for

  /// False for a frame that is not for a device: without segments, or with more bytes than it counts.
  static bool takes(const SampleFrame& frame);

  void beginToAppend(const SampleFrame& frame, Placement placement);
  /// At most `most`, to `held`, which must stay until take(), and to the host unless that is not their place.
  DecodeError beginToTake(ByteReader& reader, Placement placement, bool hasNormals, size_t most, const SampleFrame& frame, CudaFrame& held, DecodedPlace place);
  /// Waits until it is known how many there are; from then on the device needs nobody.
  DecodeError goOnTaking(const SampleFrame& frame, CudaFrame& held);
  /// Fills the frame's segments with what came to the host. After goOnTaking().
  DecodeError take(SampleFrame& frame, CudaFrame& held);
  /// Waits for what is under way, and drops it.
  void settle() noexcept {
    wait();
    taken_.segments = {};
  }

 private:
  struct Memory {
    uint8_t* rays;
    SegmentDepths* depths;
    Rgba8* colors;
    NormalCode* normals;  // null where there are none
  };
  static Memory roomIn(CudaFrameBuffers& held, size_t pixels, size_t count, bool hasNormals);
  SegmentView viewOf(const SampleFrame& frame, Placement placement, size_t pixels, size_t count, const Memory& memory);
  void hash(const SegmentView& segments, cudaStream_t stream);

  CudaFrameBuffers uploaded_;  // of frames that are not on the device
  struct Taken {
    Placement placement = Placement::depth;
    bool hasNormals = false;
    size_t most = 0;
    uint64_t hashSent = 0;
    DecodedPlace place = DecodedPlace::host;
    size_t pixels = 0, count = 0;
    FrameSegments segments;
  };
  Taken taken_;
};

}  // namespace warpscope
