// Samples as they are: 8 bytes of core/sample.h and 4 of colour each, little-endian, in order; planes value by value.
// The seed format (Zellmann 2020), for comparison and for receivers without a decompressor.
#pragma once

#include "render/codec/codec.h"

namespace warpscope {

std::unique_ptr<Codec> makeRawCodec();

}  // namespace warpscope
