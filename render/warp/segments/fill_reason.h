// Why a part of a ray is not what a frame says. For host and device.
#pragma once

namespace warpscope {

/// Why a part of a ray is filled with what the copy of the volume has there.
enum class FillReason {
  unknown,  ///< the frame says nothing about it: it is a guess
  doubted,  ///< the frame's pixels say different things of it, and the copy is the volume
};

}  // namespace warpscope
