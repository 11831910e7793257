// What more than one request under way brings: frames a second and their age, for each link and depth, while the camera turns. Run by hand.
// A client asks at 60 Hz and looks at the newest frame as often; in real time, over a loopback socket and a simulated link.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <thread>
#include <vector>

#include "app/frames/scene_connection.h"
#include "net/io_thread.h"
#include "render/march/marcher_cpu.h"
#include "tests/bench/bench_main.h"

namespace warpscope {
namespace {

using namespace std::chrono_literals;

constexpr uint32_t kSidePx = 256;
constexpr auto kPeriod = 16667us;
constexpr auto kSettling = 2500ms;  // until the first frames are through the slowest link, and TCP's window is open
constexpr auto kMeasured = 6s;
constexpr double kDegreesPerS = 30.0;

struct Result {
  double framesPerS = 0.0;
  double medianAgeMs = 0.0;  // of the frame on show, at every 60th of a second
  double serverMs = 0.0;     // march, compaction and encoding of the last frame
  size_t bytes = 0;          // of that
};

Result measure(const Scene& scene, const TransportSettings& transport) {
  const ConnectedScene loaded = hostScene(std::make_shared<net::IoThread>(), scene, makeCpuMarcher(scene.volume, scene.transferFunction), transport, [] {}, {});
  const auto begin = std::chrono::steady_clock::now();
  std::optional<ServedFrame> shown;
  std::vector<double> ages;
  size_t frames = 0;
  for (uint64_t tick = 1;; ++tick) {
    std::this_thread::sleep_until(begin + tick * kPeriod);
    const auto now = std::chrono::steady_clock::now();
    if (now > begin + kSettling + kMeasured) break;
    const bool counts = now > begin + kSettling;
    View view = scene.views.front();
    view.angleDeg += static_cast<float>(kDegreesPerS * std::chrono::duration<double>(now - begin).count());
    loaded.source->post({tick, makeCamera(scene, view, kSidePx, kSidePx), {}}, now);
    if (auto frame = loaded.source->tryTake(); frame && frame->frame) {
      shown = std::move(frame);
      if (counts) ++frames;
    }
    if (counts && shown) ages.push_back(millisecondsBetween(shown->requestedAt, now));
  }
  loaded.source->requestStop();
  Result result;
  if (ages.empty()) return result;
  std::nth_element(ages.begin(), ages.begin() + static_cast<ptrdiff_t>(ages.size() / 2), ages.end());
  result.framesPerS = static_cast<double>(frames) / std::chrono::duration<double>(kMeasured).count();
  result.medianAgeMs = ages[ages.size() / 2];
  result.serverMs = shown->latency.marchMs + shown->latency.compactMs + shown->latency.encodeMs;
  result.bytes = shown->bytes.ofFrame();
  return result;
}

void run() {
  const Scene scene = openScene("block");
  for (const char* link : {"none", "home-fibre", "4g", "transatlantic", "satellite"})
    for (const int depth : {1, 2, 4, 8, 16}) {
      const Result result = measure(scene, {net::parseLinkSettings(link), {}, depth});
      std::printf("%-14s depth %2d: %5.1f frames/s, age %4.0f ms, server %4.1f ms, %zu bytes\n", link, depth, result.framesPerS, result.medianAgeMs,
                  result.serverMs, result.bytes);
      std::fflush(stdout);
    }
}

}  // namespace
}  // namespace warpscope

int main() { return warpscope::benchMain("pipelining_bench", warpscope::run); }
