// Frames as tiles whose streams are read side by side, by as many threads as a processor has, a GPU's among them. Lossless, and about as short as
// `packed` without loss; each tile predicts from its own pixels alone.
//
// Bytes: placement (1); hash of the samples (8); tiles (tiled_sheet.h). Shapes: which pixels have samples, a bit each, each row of bytes changed by the one above; where the
// frame has kLayerPlane, how many further samples each of these has, changed by the one before. Planes of a layer: differences of places along rays (pixel_path.h) from
// their prediction, of depth codes from those of their places, of radius codes; opacity, green, red, blue (color_differences.h).
// Of the frame's planes: plane_coding.h. kLayerPlane has no bytes of its own.
#pragma once

#include "render/codec/codec.h"

namespace warpscope {

std::unique_ptr<Codec> makeTiledCodec();
uint64_t mostTiledBytes(const SampleFrame& frame, uint64_t count, const CodecSettings& settings);
uint64_t mostTiledPlaneBytes(const SamplePlane& plane, uint64_t count);

}  // namespace warpscope
