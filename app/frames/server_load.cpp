// Waiting in place of the others' work.
// See server_load.h.
#include "app/frames/server_load.h"

#include "render/base/error.h"

namespace warpscope {

void shareProcessor(std::initializer_list<double*> stagesMs, int loadPercent, Clock& clock, const std::stop_token& stop) {
  const double factor = 100.0 / (100.0 - loadPercent);
  double longerMs = 0.0;
  for (double* const ms : stagesMs) {
    longerMs += (factor - 1.0) * *ms;
    *ms *= factor;
  }
  if (!clock.waitUntil(clock.now() + durationOfMs(longerMs), stop)) throw OperationCancelled();
}

}  // namespace warpscope
