// What a build without CUDA says when it is asked for CUDA.
#include "render/base/error.h"
#include "render/codec/tiled/tiled_coder_cuda.h"
#include "render/cuda/devices.h"
#include "render/cuda/gl_interop.h"
#include "render/cuda/pinned_memory.h"
#include "render/march/marcher_cuda.h"
#include "render/march/piece_marcher_cuda.h"
#include "render/metrics/picture_judge_cuda.h"
#include "render/warp/multihit_warp_cuda.h"
#include "render/warp/proxy_warp_cuda.h"
#include "render/warp/spheres_warp_cuda.h"
#include "render/warp/segments_warp_cuda.h"
#include "render/warp/splats_warp_cuda.h"

namespace warpscope {
namespace {

[[noreturn]] void refuse() { throw DeviceError(cuda::whyUnavailable()); }

}  // namespace

namespace cuda {

std::string whyNoInterop() { return whyUnavailable(); }
struct InteropTexture::Registration {};
InteropTexture::InteropTexture(unsigned, uint32_t, uint32_t) { refuse(); }
InteropTexture::~InteropTexture() = default;
void InteropTexture::show(const DevicePicture&) { refuse(); }
std::pmr::memory_resource* pinnedMemory() { refuse(); }
std::pmr::memory_resource* pinnedOrPlainMemory() { refuse(); }

}  // namespace cuda

TiledCoderPtr makeCudaTiledCoder() { refuse(); }
MarcherPtr makeCudaMarcher(VolumePtr, TransferFunction) { refuse(); }
MarcherPtr makeFittingCudaMarcher(VolumePtr, TransferFunction) { refuse(); }
PieceMaker makeCudaPieces(bool, std::function<void(const std::string&)>) { refuse(); }
std::unique_ptr<DevicePictureJudge> makeCudaPictureJudge(const glm::vec3&, float) { refuse(); }
std::unique_ptr<Warp> makeCudaMultihitWarp(SphereTracing) { refuse(); }
std::unique_ptr<Warp> makeCudaProxyWarp() { refuse(); }
std::unique_ptr<Warp> makeCudaSpheresWarp() { refuse(); }
std::unique_ptr<Warp> makeCudaSegmentsWarp() { refuse(); }
std::unique_ptr<Warp> makeCudaSplatsWarp() { refuse(); }

}  // namespace warpscope
