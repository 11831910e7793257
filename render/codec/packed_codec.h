// Frames as bands that are packed independently: on all cores, and with bytes that do not depend on how many there are.
// After an idea of Zellmann 2020, whose samples are quantised to 64 bits; that their pixels' rays say most of these is ours.
//
// Bytes: placement (1), colour coding (1), for each band its length (4) and number of samples (4), bands (packed_band.h).
// Of planes: plane_coding.h. kLayerPlane has none: the numbers of samples a pixel say it.
#pragma once

#include "render/codec/codec.h"

namespace warpscope {

std::unique_ptr<Codec> makePackedCodec(const TiledCoderPtr& coder);
/// If nothing can be predicted and nothing be compressed: what sections (zstd_section.h) take as they are, and what libjpeg-turbo promises
/// not to exceed, for each layer the whole picture.
uint64_t mostPackedBytes(const SampleFrame& frame, uint64_t count, const CodecSettings& settings);
uint64_t mostPackedPlaneBytes(const SamplePlane& plane, uint64_t count);

}  // namespace warpscope
