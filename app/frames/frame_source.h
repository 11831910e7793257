// Where frames come from: one interface, whether the server is this program's own, another machine's, or a recording.
// Newest wins: a request replaces one that has not left yet, a frame replaces one that nobody took.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "net/link_settings.h"
#include "net/messages.h"
#include "render/base/clock.h"
#include "render/base/error.h"
#include "render/codec/codec.h"
#include "render/march/sample_frame.h"

namespace warpscope {

struct FrameRequest {
  uint64_t id = 0;  ///< greater than any before
  Camera camera;
  MarchSettings settings;
};

/// Where the time went from the moment that a frame was wanted until it could be built from: milliseconds, one stage after the other.
struct FrameLatency {
  double waitMs = 0.0;    ///< for requests before it that were under way
  double wireMs = 0.0;    ///< there and back, what the network and the simulated link take
  double queueMs = 0.0;   ///< at the server, for other clients' turns
  double marchMs = 0.0;
  double compactMs = 0.0;
  double copyMs = 0.0;    ///< from the device to the host
  double encodeMs = 0.0;
  double decodeMs = 0.0;

  double totalMs() const { return waitMs + wireMs + queueMs + marchMs + compactMs + copyMs + encodeMs + decodeMs; }
};

/// What the server's own stages took; the rest is 0.
inline FrameLatency latencyOf(const ServerTimings& timings) {
  FrameLatency latency;
  latency.marchMs = timings.marchMs;
  latency.compactMs = timings.compactMs;
  latency.copyMs = timings.copyMs;
  return latency;
}

struct ServedFrame {
  uint64_t requestId = 0;
  Clock::TimePoint requestedAt;  ///< when its camera was the current one
  Clock::TimePoint arrivedAt;
  SampleFramePtr frame;  ///< null if there is an error; it may be away (SampleFrame::isAway): onHost() is for those who want it here
  FrameLatency latency;
  FrameBytes bytes;      ///< of its payload on the wire; of the copy of the volume where it came with this frame, the first of a connection that wanted it
  std::string error;
};

inline constexpr int kDefaultDepth = 1;
inline constexpr Range kDepthRange{1, net::kMaxDepth};

/// KiB; an unbounded frame of 16384 x 4096 pixels with 16 segments takes some gigabytes.
inline constexpr Range kFrameKibRange{0, 1 << 22};
inline constexpr Range kServerMsRange{0, 10000};
inline constexpr Range kServerLoadRange{0, 90};

/// What is asked of a server beside what its frames show.
struct ServerWishes {
  int movingMs = 0;     ///< milliseconds that a frame may take it while the camera moves, kServerMsRange; 0: as long as it takes
  int loadPercent = 0;  ///< of its processor that others are to take, simulated, kServerLoadRange

  bool operator==(const ServerWishes&) const = default;
};

/// How frames travel, and how soon they are wanted; may change at any time.
struct TransportSettings {
  net::DuplexLinkSettings link;  ///< simulated on top of what is there
  CodecSettings codec;
  int depth = kDefaultDepth;     ///< requests under way at a time, kDepthRange
  int frameKib = 0;              ///< KiB that a frame may take without the copy of the volume, kFrameKibRange; 0: whatever it takes (frame_budget.h)
  ServerWishes server = {};

  bool operator==(const TransportSettings&) const = default;
};

struct SourceStatus {
  bool isConnected = true;
  bool isRefused = false;                ///< it is not, and never will be
  std::string sentence;                  ///< why not; empty if it is
  std::optional<Clock::TimePoint> next;  ///< when it is tried again
  std::string where;                     ///< "127.0.0.1:4711"; empty without a network
  double roundTripMs = 0.0;              ///< of the last heartbeat; 0 if there was none yet
  std::optional<uint16_t> busyWith{};    ///< others that the server works for, if it said so and has not answered since
  std::vector<net::ProcessFields> processes{};  ///< what processes did that the server's volume is spread over, by rank; empty where it is not

  bool operator==(const SourceStatus&) const = default;
};

/// A wait for a server that somebody ended; what was in the way, as far as it is known.
class WaitCancelled : public OperationCancelled {
 public:
  explicit WaitCancelled(std::string trouble) : trouble_(std::move(trouble)) {}
  /// Why the server could not be reached; empty if it could.
  const std::string& trouble() const { return trouble_; }

 private:
  std::string trouble_;
};

/// What is said of a server that is busy with so many others.
std::string busySentence(uint16_t others);

/// Safe on any thread.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Asks for a frame instead of the one asked for last, if that has not left yet. `now`: when its camera became the current one.
  virtual void post(const FrameRequest& request, Clock::TimePoint now) = 0;
  /// The newest answer that nobody took yet.
  virtual std::optional<ServedFrame> tryTake() = 0;

  virtual void setTransport(const TransportSettings& transport) = 0;
  /// Frames that are asked for from now on are of that function, and say so by `version`, which rises; copies of the volume are classified by it at once.
  /// False where the function is another's to choose: nothing changes then.
  virtual bool setTransferFunction(const TransferFunction& /*function*/, uint64_t /*version*/) { return false; }
  virtual SourceStatus status() const = 0;

  /// Asks its threads to end without waiting for them; the destructor waits.
  virtual void requestStop() = 0;
};

using FrameSourcePtr = std::shared_ptr<FrameSource>;

}  // namespace warpscope
