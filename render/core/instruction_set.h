// Which instructions this library was compiled for: of several in a portable build, the loader chose this one (levels.cmake).
// x86-64 psABI, section 3.1.1, "Processor Architecture": the micro-architecture levels.
#pragma once

#include <string_view>

namespace warpscope {

/// x86-64, x86-64-v2 (SSE4.2), x86-64-v3 (AVX2, FMA), x86-64-v4 (AVX-512), aarch64; "other" for what has no name here.
std::string_view instructionSet();

/// Floats that a vector register holds.
int floatsInVector();

}  // namespace warpscope
