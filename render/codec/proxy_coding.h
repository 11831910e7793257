// The coarse copy of a frame's volume, and how its values look, as bytes: the same in both formats.
// Dimensions (4 bytes each), geometry (doubles), what codes stand for, the transfer function's points, then the voxels: differences from the one in front
// along x, as a section (zstd_section.h).
#pragma once

#include <span>
#include <vector>

#include "render/codec/codec.h"

namespace warpscope {

/// The most points that a transfer function may have on the wire.
inline constexpr uint32_t kMostFunctionPoints = 1 << 16;

/// The most bytes of a copy with so many voxels along its longest edge; 0 for none.
uint64_t mostProxyBytes(int longest);

/// Throws InputError for a transfer function with more than kMostFunctionPoints points.
void appendProxy(ByteVector& out, const Proxy& proxy);

/// Fills `proxy`, which has no more than `longest` voxels along an edge.
DecodeError takeProxy(std::span<const std::byte> bytes, int longest, ProxyPtr& proxy);

/// What a copy takes in a payload. Encodes it: for those who make none; others know from FrameCodec::bytes.
size_t proxyBytesOf(const Proxy& proxy);

}  // namespace warpscope
