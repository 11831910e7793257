// Serving one request.
// See server_loop.h.
#include "app/server_loop.h"

namespace warpscope {
namespace {

void serve(Clock& clock, const FrameRequest& request, ServedFrame& served, const std::stop_token& stop) {
  served.requestId = request.id;
  served.requestedAt = request.sentAt;
  const Clock::Duration oneWay = request.roundTrip / 2;
  if (!clock.waitUntil(request.sentAt + oneWay, stop)) throw OperationCancelled();
  SampleFrame frame = request.marcher->march(request.camera, request.settings, stop);
  frame.requestId = request.id;
  if (!clock.waitUntil(clock.now() + oneWay, stop)) throw OperationCancelled();
  served.frame = std::make_shared<const SampleFrame>(std::move(frame));
  served.arrivedAt = clock.now();
}

}  // namespace

std::unique_ptr<ServerLoop> makeServerLoop(Clock& clock, std::function<void()> onFrame) {
  return std::make_unique<ServerLoop>(
      [&clock] {
        return [&clock](const FrameRequest& request, ServedFrame& served, const std::stop_token& stop) {
          serve(clock, request, served, stop);
        };
      },
      std::move(onFrame));
}

}  // namespace warpscope
