// One direction of a simulated link: says when bytes that are sent at one time arrive. Pure: no clock, no threads, a seed for its dice.
// Rate: a token bucket (as Linux tc-tbf(8)). Loss as TCP shows it: RFC 8985 (RACK, tail loss probe), RFC 6298 (timeout), simplified.
#pragma once

#include <chrono>
#include <cstdint>
#include <random>
#include <vector>

#include "net/link_settings.h"
#include "render/base/clock.h"

namespace warpscope::net {

/// Rate and loss act on pieces of this size: what fits into an Ethernet frame (RFC 9293, 3.7.1) with time stamps.
inline constexpr size_t kSegmentBytes = 1448;

/// What is sent within this time of a draw has the same jitter: queues in real networks change more slowly than segments follow each
/// other, and with a draw per segment the slowest of them would make every large message equally late.
inline constexpr std::chrono::milliseconds kJitterHold{5};

struct Segment {
  size_t sizeBytes;
  Clock::TimePoint arrivesAt;
};

/// In this order:
/// - a segment waits for the bottleneck, which passes `rate` on average and `burst` at once, and stands still in an outage;
/// - it takes the delay, with the jitter or the trace's next value of its time;
/// - if it is lost, it comes later by 1.25 round trips if others of the same chunk follow it (they tell the sender), else by 2 round
///   trips, but at least 10 ms (a probe); should a retransmission be lost too, the next one comes after a timeout of at least 200 ms,
///   which doubles each time, up to 60 s. The round trip is twice the delay. Retransmissions take their share of the rate;
/// - nothing overtakes: what comes after a late segment waits for it.
/// How a sender's own congestion control would slow down is not part of it.
class LinkModel {
 public:
  using TimePoint = Clock::TimePoint;
  using Duration = Clock::Duration;

  /// `start`: from when outages count. Models with different `stream` have different dice for the same seed. Throws LinkSettingsError.
  explicit LinkModel(LinkSettings settings, TimePoint start = {}, uint32_t stream = 0);

  /// Sends a chunk and appends when its segments arrive, in order. Times must not go back: an earlier one counts as the last one. A chunk
  /// of 0 bytes is one segment that takes no room: an end, or an error. `bytesBehind`: what is about to follow it without a pause.
  void send(size_t sizeBytes, TimePoint sentAt, std::vector<Segment>& segments, size_t bytesBehind = 0);

  /// Sends a chunk; when its last byte arrives.
  TimePoint arrivalOf(size_t sizeBytes, TimePoint sentAt);

  /// From `now` on. What is under way keeps its time, and what follows does not overtake it. Throws LinkSettingsError.
  void setSettings(LinkSettings settings, TimePoint now);
  const LinkSettings& settings() const { return settings_; }

  /// How many bytes may be on their way at a time, beyond which senders have to wait: what fits into the delay, and the router's buffer.
  size_t capacityBytes() const { return capacityBytes_; }

  uint64_t segmentCount() const { return segmentCount_; }
  /// Transmissions that were lost, those of retransmissions included.
  uint64_t lossCount() const { return lossCount_; }

 private:
  void restart(TimePoint now);
  void drawDelay(TimePoint now);
  TimePoint departure(size_t sizeBytes, TimePoint from);
  Duration retransmission(bool isFollowed, Duration occupied);
  TimePoint endOfOutage(TimePoint time);
  void drawOutage(TimePoint after);

  LinkSettings settings_;
  uint32_t stream_;
  std::mt19937_64 jitterDice_, lossDice_, outageDice_;
  size_t capacityBytes_ = 0;
  Duration roundTrip_{0}, timeout_{0};

  TimePoint now_;              // the latest time handed in
  TimePoint bucketFullAt_;     // when the bucket would be full again
  TimePoint lastDeparture_, lastArrival_;
  TimePoint drawnAt_;
  bool isDrawn_ = false;
  Duration delay_{0};          // with the jitter that was drawn
  size_t tracePosition_ = 0;
  TimePoint outageBegin_, outageEnd_;  // the one under way, or the next
  uint64_t segmentCount_ = 0, lossCount_ = 0;
  std::vector<Segment> scratch_;
};

}  // namespace warpscope::net
