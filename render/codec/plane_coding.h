// The values of one plane of a frame as bytes, compressed: for the formats `packed` and `tiled`.
// Each value, taken as an integer, is predicted from the one before it in its layer; differences are folded (zigzag), and compressed byte by byte.
//
// Bytes: for each piece of kPlanePiece values its length (4); pieces: a section (zstd_section.h) for each byte of a value, all lowest bytes first.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "render/codec/codec.h"

namespace warpscope {

/// Pieces are independent of one another, for all cores to work at.
inline constexpr size_t kPlanePiece = size_t{1} << 17;

/// Whether it is what pixels' numbers of samples already say.
inline bool isImplied(const SamplePlane& plane) { return plane.name == kLayerPlane && plane.element == PlaneElement::uint8; }

/// Appends the plane; `layers` are those of its frame, empty or one a value.
void appendPlane(ByteVector& out, const SamplePlane& plane, std::span<const uint8_t> layers);

/// Fills the plane's values, `count` of them, of an element whose size is known. An error if `bytes` are not just such a plane; nothing is
/// allocated for one whose pieces are not there.
DecodeError takePlane(std::span<const std::byte> bytes, size_t count, std::span<const uint8_t> layers, SamplePlane& plane);

}  // namespace warpscope
