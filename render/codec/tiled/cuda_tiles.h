// What tiles of samples and tiles of segments share on a device: a stream, a sheet, what rays of a frame are, a hash. For .cu files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/codec/pixel_path.h"
#include "render/codec/tiled/device_sheet.h"
#include "render/codec/tiled/device_sum.h"
#include "render/codec/tiled/tile_fronts.h"
#include "render/core/transfer_vector.h"
#include "render/cuda/memory.h"
#include "render/cuda/pinned_memory.h"
#include "render/march/sample_frame.h"

namespace warpscope {

inline constexpr uint64_t kMostDeviceBytes = ~uint32_t{0};  ///< of streams: a device counts them in 32 bits
inline constexpr const char* kDamagedTiles = "a tile of the payload is damaged";

/// One frame at a time; keeps its buffers.
class CudaTiles {
 public:
  /// What was begun, to a payload. Waits. Of the words that are summed the device knows what they add up to.
  SummedWords append(ByteVector& out);

 protected:
  explicit CudaTiles(cuda::Urgency urgency) : stream_(urgency) {}
  /// Waits for what is under way, whether the device can or not: memory of the host is free again.
  void wait() noexcept {
    cudaStreamSynchronize(stream_);
    cudaStreamSynchronize(beside_);
  }

  static constexpr unsigned kThreads = 256;

  template <class T>
  static TransferVector<T> pinned(size_t count) {
    return TransferVector<T>(count, TransferAllocator<T>(cuda::pinnedMemory()));
  }
  template <class T>
  void download(T* to, const T* from, size_t count) {
    if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to, from, count * sizeof(T), cudaMemcpyDeviceToHost, stream_));
  }
  /// What rays of the frame share, with the device's noise.
  PathGrid pathsOf(const SampleFrame& frame, Placement placement);
  /// Room for as many values, in the order of streams.
  void reserveStreams(size_t values);
  const cuda::Stream stream_, beside_;
  DeviceSheet sheet_{stream_, beside_};
  SheetHead head_;
  cuda::DeviceBuffer<int32_t> origins_;
  cuda::DeviceBuffer<uint32_t> words_[FrontJobs::kMost];
  cuda::DeviceBuffer<float> noise_;
  DeviceSum hash_;
};

}  // namespace warpscope
