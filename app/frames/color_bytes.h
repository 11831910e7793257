// A picture's colours at full precision as bytes and back, without loss: floats byte by byte of their planes, compressed. What a server answers who asks for
// the ground truth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>

#include "render/codec/bytes.h"
#include "render/core/image.h"

namespace warpscope {

ByteVector encodeColors(const Image<glm::vec4>& image);
/// What that makes of such an image at most.
uint64_t mostColorBytes(uint32_t width, uint32_t height);
/// Back, for an image of that size. Throws InputError for anything else.
Image<glm::vec4> decodeColors(std::span<const std::byte> bytes, uint32_t width, uint32_t height);

}  // namespace warpscope
