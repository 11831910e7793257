// Samples as they are: 8 bytes of core/sample.h and 4 of colour each, little-endian, in order; planes value by value.
// The seed format (Zellmann 2020), for comparison and for receivers without a decompressor.
#pragma once

#include "render/codec/codec.h"

namespace warpscope {

std::unique_ptr<Codec> makeRawCodec(const TiledCoderPtr& coder);
/// All samples take the same.
uint64_t mostRawBytes(const SampleFrame& frame, uint64_t count, const CodecSettings& settings);
uint64_t mostRawPlaneBytes(const SamplePlane& plane, uint64_t count);

}  // namespace warpscope
