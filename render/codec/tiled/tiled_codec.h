// Frames as tiles whose streams are read side by side, by as many threads as a processor has, a GPU's among them. Lossless, and about as short as
// `packed` without loss; each tile predicts from its own pixels alone.
//
// Bytes: placement (1); the samples (tiled_samples.h).
// Of the frame's planes: plane_coding.h. kLayerPlane has no bytes of its own.
#pragma once

#include "render/codec/codec.h"
#include "render/codec/tiled/tiled_coder.h"

namespace warpscope {

std::unique_ptr<Codec> makeTiledCodec(const TiledCoderPtr& coder);
uint64_t mostTiledBytes(const SampleFrame& frame, uint64_t count, const CodecSettings& settings);
uint64_t mostTiledPlaneBytes(const SamplePlane& plane, uint64_t count);

}  // namespace warpscope
