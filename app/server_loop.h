// The server of a session: marches in its own thread at its own rate, behind a simple artificial round trip.
// Half of the delay passes before the march, half after it; one request is in flight, one pending, and the newest wins.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "app/clock.h"
#include "app/newest_worker.h"
#include "render/march/marcher.h"

namespace warpscope {

struct FrameRequest {
  uint64_t id = 0;
  MarcherPtr marcher;  ///< of the scene that is asked for
  Camera camera;
  MarchSettings settings;
  Clock::TimePoint sentAt;
  Clock::Duration roundTrip{0};
};

struct ServedFrame {
  uint64_t requestId = 0;
  Clock::TimePoint requestedAt;  ///< when its camera was the current one
  Clock::TimePoint arrivedAt;
  SampleFramePtr frame;  ///< null if there is an error
  std::string error;
};

using ServerLoop = NewestWorker<FrameRequest, ServedFrame>;

/// `clock` must outlive the loop. A request reaches the server half a round trip after it was sent, and the frame arrives half a round
/// trip after it was made; a request that waited for its turn meanwhile does not wait again.
std::unique_ptr<ServerLoop> makeServerLoop(Clock& clock, std::function<void()> onFrame);

}  // namespace warpscope
