// How far this process has come with volumes that it has to look through before it can march them: for whoever shows that to a person who waits.
#pragma once

#include <cstdint>

namespace warpscope {

/// Bytes of voxels, since the program began. They are counted each time that they are looked at.
struct LookedThrough {
  uint64_t wanted = 0;  ///< that somebody has begun with
  uint64_t done = 0;
};
/// Safe on any thread, as the next two are.
LookedThrough lookedThrough();

/// So many are to be looked at: of several passes all at once, so that what is left never grows.
void beginLooking(uint64_t bytes);
/// So many of them have been.
void noteLooked(uint64_t bytes);

}  // namespace warpscope
