// A batch of rays on a device: what tiles' rays have met goes there, what they have met then comes back. For .cu files.
#pragma once

#include <functional>
#include <memory>
#include <memory_resource>
#include <vector>

#include "render/cuda/memory.h"
#include "render/cuda/pinned_memory.h"
#include "render/march/depth_of_samples.h"
#include "render/march/march_setup.h"
#include "render/march/piece_launch.h"

namespace warpscope {

/// What a picture's rays have in common.
struct PieceFrame {
  const Camera& camera;
  const RenderSettings& settings;
  const SampleSettings* sample;
  RayRelay& relay;
  EffectPlan plan;
  SampleRule rule;
  PixelGrid pixels;
  VolumeView<uint8_t> view;  ///< where voxels lie, whatever their type; none are there
  RayLimits limits;
  DepthOfSamples depthOfSamples;
  ShadingSetup shading;
  LightVolume lightVolume;  ///< its values on the device
  bool hasNormals = false;
  bool listsSamples = false;  ///< that count; else they are folded
  int mostSegments = 0;
  int mostParts = 1;  ///< that a ray is cut into
};

/// Starts the kernels of a picture's mode and volume.
struct PieceLaunches {
  std::function<void(const PieceRays& rays, cudaStream_t stream)> first;  ///< on the first way
  std::function<void(const PartedRays& rays, cudaStream_t stream)> again;  ///< on the second
  std::function<void(const LitPlace* places, uint32_t count, NormalCode* normals, cudaStream_t stream)> normals;
};

using Tiles = std::vector<std::unique_ptr<RelayedTile>>;

/// A thread's memory, here and on the device.
class PieceWorker {
 public:
  /// Marches the tiles' rays, all on their first way or all on their second; they are as they were if it throws DeviceError, or if it is false: then more samples count than there is
  /// room for.
  bool march(const PieceFrame& frame, Tiles& tiles, const PieceLaunches& launches) {
    return tiles.front()->isAgain ? marchAgain(frame, tiles, launches) : marchFirst(frame, tiles, launches);
  }

 private:
  struct Place {
    RelayedTile* tile;
    uint32_t ray;
  };

  bool marchFirst(const PieceFrame& frame, Tiles& tiles, const PieceLaunches& launches);
  void pack(const PieceFrame& frame, Tiles& tiles);
  void packRay(RelayedTile& tile, uint32_t place, PieceRay ray);
  void unpack(const PieceFrame& frame);

  bool marchAgain(const PieceFrame& frame, Tiles& tiles, const PieceLaunches& launches);
  void packAgain(const PieceFrame& frame, Tiles& tiles);
  void unpackAgain(const PieceFrame& frame, Tiles& tiles, size_t listed, size_t closed);

  /// Of a ray that nothing is left of to march.
  void finish(const PieceFrame& frame, RelayedTile& tile, uint32_t place);

  /// The first `count` of them, once the stream has got there. `none`: what takes the place of others.
  template <class T>
  void fetch(const cuda::DeviceBuffer<T>& from, std::pmr::vector<T>& to, size_t count, const T& none) {
    if (to.size() < count) to.resize(count, none);
    if (count > 0) WARPSCOPE_CUDA_CHECK(cudaMemcpyAsync(to.data(), from.data(), count * sizeof(T), cudaMemcpyDeviceToHost, stream_));
  }
  /// Counters on the device start from 0.
  void clearCounts();
  void fetchCounts();

  /// Of what a launch has left, in device memory and here.
  struct Counts {
    uint32_t left = 0, listed = 0, closed = 0;
  };

  cuda::Stream stream_;
  cuda::DeviceBuffer<Counts> deviceCounts_{1};
  cuda::PinnedValue<Counts> counts_;
  std::pmr::vector<ListedSample> listed_{cuda::pinnedMemory()};
  cuda::DeviceBuffer<ListedSample> deviceListed_;
  std::vector<Place> places_;  // of each ray
  RaySamples found_;
  FinishedSegments segments_;
  // On the first way.
  std::pmr::vector<PieceRay> rays_{cuda::pinnedMemory()};
  std::pmr::vector<RelayedState> met_{cuda::pinnedMemory()};
  std::pmr::vector<SegmentMerger> metSegments_{cuda::pinnedMemory()};
  std::pmr::vector<PieceResult> results_{cuda::pinnedMemory()};
  std::pmr::vector<RelayedState> left_{cuda::pinnedMemory()};
  std::pmr::vector<SegmentMerger> leftSegments_{cuda::pinnedMemory()};
  cuda::DeviceBuffer<PieceRay> deviceRays_;
  cuda::DeviceBuffer<RelayedState> deviceMet_, deviceLeft_;
  cuda::DeviceBuffer<SegmentMerger> deviceMetSegments_, deviceLeftSegments_;
  cuda::DeviceBuffer<PieceResult> deviceResults_;
  // On the second.
  struct NormalPlace {
    Place ray;
    int segment;
  };
  std::pmr::vector<PartedRay> parted_{cuda::pinnedMemory()};
  std::pmr::vector<ClosedPart> closed_{cuda::pinnedMemory()};
  std::pmr::vector<LitPlace> lit_{cuda::pinnedMemory()};
  std::pmr::vector<NormalCode> normals_{cuda::pinnedMemory()};
  std::vector<NormalPlace> normalPlaces_;  // of each lit place
  cuda::DeviceBuffer<PartedRay> deviceParted_;
  cuda::DeviceBuffer<ClosedPart> deviceClosed_;
  cuda::DeviceBuffer<LitPlace> deviceLit_;
  cuda::DeviceBuffer<NormalCode> deviceNormals_;
};

}  // namespace warpscope
