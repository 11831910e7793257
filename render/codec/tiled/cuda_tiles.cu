// See cuda_tiles.h.
#include "render/codec/tiled/cuda_tiles.h"

#include "render/codec/bytes.h"

namespace warpscope {

PathGrid CudaTiles::pathsOf(const SampleFrame& frame, Placement placement) {
  PathGrid paths = pathGridOf(frame, placement);
  if (paths.jitter.noise == nullptr) return paths;
  if (noise_.capacity() == 0) noise_.upload(blueNoise(), stream_);
  paths.jitter.noise = noise_.data();
  return paths;
}

void CudaTiles::reserveStreams(size_t values) {
  origins_.reserve(values);
  for (cuda::DeviceBuffer<uint32_t>& words : words_) words.reserve(values);
}

SummedWords CudaTiles::append(ByteVector& out) {
  const size_t hashAt = out.size();
  appendLittle(out, uint64_t{0});
  const SummedWords summed = sheet_.append(out);  // waits for all, beside as well
  storeLittle(out.data() + hashAt, hash_.onHost());
  return summed;
}

}  // namespace warpscope
