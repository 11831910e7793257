// The C library's own way.
// See freed_memory.h.
#include "render/core/freed_memory.h"

#include "render/core/expected_break.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace warpscope {

void giveBackFreedMemory() {
#ifdef __GLIBC__
  leaveBreakAlone(kMostTimeBeforeBreak);
  malloc_trim(0);
#endif
}

}  // namespace warpscope
