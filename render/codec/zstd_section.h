// A run of bytes whose length both sides know, compressed where that pays.
// Zstandard (RFC 8878), one frame a section. Before it a word: how it is kept (upper 2 bits) and how many bytes follow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "render/codec/bytes.h"

namespace warpscope {

/// What a section has beside the bytes, if these cannot be compressed.
inline constexpr size_t kSectionHeadBytes = 4;

/// Appends `bytes`, fewer than 2^29 of them, as at most kSectionHeadBytes more.
template <class Allocator>
void appendSection(std::vector<std::byte, Allocator>& out, std::span<const uint8_t> bytes);
extern template void appendSection(ByteVector& out, std::span<const uint8_t> bytes);
extern template void appendSection(std::vector<std::byte>& out, std::span<const uint8_t> bytes);

/// Fills `bytes`. False, with any content, if what is there is not a section of just that length; never writes past the end.
bool takeSection(ByteReader& reader, std::span<uint8_t> bytes);

/// Whether all bytes are 0.
bool isZero(std::span<const uint8_t> bytes);

}  // namespace warpscope
