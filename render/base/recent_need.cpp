// The C library's own way.
// See recent_need.h.
#include "render/base/recent_need.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace warpscope {

void giveBackFreedMemory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace warpscope
