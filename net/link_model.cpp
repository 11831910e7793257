// The arithmetic of the bottleneck, the dice, and the order of arrivals.
// See link_model.h.
#include "net/link_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace warpscope::net {
namespace {

using std::chrono::milliseconds;
using Duration = LinkModel::Duration;
using TimePoint = LinkModel::TimePoint;

constexpr double kLargestCapacityBytes = 64 << 20, kSmallestBufferBytes = 64 << 10, kBufferS = 0.1;
constexpr Duration kLeastProbe = milliseconds(10), kLeastTimeout = milliseconds(200), kLongestTimeout = std::chrono::seconds(60);
constexpr int kMostRetransmissions = 15;  // as often as Linux tries (tcp_retries2)

Duration durationOfS(double s) {
  return Duration(static_cast<Duration::rep>(std::llround(s * static_cast<double>(Duration::period::den) / Duration::period::num)));
}

// The distributions of the standard library differ from one library to the next; these do not.

/// In [0, 1).
double uniform(std::mt19937_64& dice) { return static_cast<double>(dice() >> 11) * 0x1p-53; }

/// Deviation 1 (Box, Muller 1958).
double normal(std::mt19937_64& dice) {
  const double radius = std::sqrt(-2 * std::log(1 - uniform(dice)));
  return radius * std::cos(2 * std::numbers::pi * uniform(dice));
}

/// Mean 1.
double exponential(std::mt19937_64& dice) { return -std::log(1 - uniform(dice)); }

enum class Dice : uint32_t { jitter, loss, outage };

std::mt19937_64 diceFor(Dice purpose, uint64_t seed, uint32_t stream) {
  std::seed_seq sequence{static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32), stream, static_cast<uint32_t>(purpose)};
  return std::mt19937_64(sequence);
}

double meanDelayMs(const LinkSettings& settings) { return settings.delayMs + (settings.trace ? settings.trace->meanMs() : 0); }

size_t capacityOf(const LinkSettings& settings) {
  if (settings.rateBitPerS == 0) return static_cast<size_t>(std::max(kLargestCapacityBytes, settings.bufferBytes));
  const double bytesPerS = settings.rateBitPerS / 8;
  const double buffer = settings.bufferBytes > 0 ? settings.bufferBytes : std::max(kSmallestBufferBytes, bytesPerS * kBufferS);
  const double underWay = bytesPerS * (meanDelayMs(settings) + settings.jitterMs) / 1000 + settings.burstBytes;
  return static_cast<size_t>(std::min(kLargestCapacityBytes, underWay + buffer));
}

/// SRTT + 4 RTTVAR (RFC 6298, 2.3), RTTVAR being a mean deviation: half of a uniform jitter's width, sqrt(2/pi) of a normal one's.
Duration timeoutOf(const LinkSettings& settings) {
  const double deviationMs = settings.jitter == Jitter::uniform  ? settings.jitterMs / 2
                             : settings.jitter == Jitter::normal ? settings.jitterMs * std::sqrt(2 / std::numbers::pi)
                                                                 : 0;
  return std::clamp(durationOfMs(2 * meanDelayMs(settings) + 4 * deviationMs), kLeastTimeout, kLongestTimeout);
}

}  // namespace

LinkModel::LinkModel(LinkSettings settings, TimePoint start, uint32_t stream)
    : settings_(std::move(settings)), stream_(stream), now_(start), bucketFullAt_(start), lastDeparture_(start), lastArrival_(start) {
  requireValid(settings_);
  restart(start);
}

void LinkModel::setSettings(LinkSettings settings, TimePoint now) {
  requireValid(settings);
  settings_ = std::move(settings);
  now_ = std::max(now_, now);
  restart(now_);
}

void LinkModel::restart(TimePoint now) {
  jitterDice_ = diceFor(Dice::jitter, settings_.seed, stream_);
  lossDice_ = diceFor(Dice::loss, settings_.seed, stream_);
  outageDice_ = diceFor(Dice::outage, settings_.seed, stream_);
  capacityBytes_ = capacityOf(settings_);
  roundTrip_ = durationOfMs(2 * meanDelayMs(settings_));
  timeout_ = timeoutOf(settings_);
  bucketFullAt_ = std::max(now, lastDeparture_);
  isDrawn_ = false;
  tracePosition_ = 0;
  drawOutage(now);
}

void LinkModel::send(size_t sizeBytes, TimePoint sentAt, std::vector<Segment>& segments, size_t bytesBehind) {
  now_ = std::max(now_, sentAt);
  drawDelay(now_);
  size_t left = sizeBytes;
  do {
    const size_t size = std::min(left, kSegmentBytes);
    left -= size;
    lastDeparture_ = std::max(lastDeparture_, departure(size, now_));
    TimePoint arrival = lastDeparture_ + delay_;
    if (size > 0) {
      ++segmentCount_;
      if (settings_.loss > 0 && uniform(lossDice_) < settings_.loss) {
        const Duration occupied = settings_.rateBitPerS > 0 ? durationOfS(static_cast<double>(size) * 8 / settings_.rateBitPerS) : Duration(0);
        arrival += retransmission(left + bytesBehind > 0, occupied);
      }
    }
    lastArrival_ = std::max(lastArrival_, arrival);
    segments.push_back({size, lastArrival_});
  } while (left > 0);
}

TimePoint LinkModel::arrivalOf(size_t sizeBytes, TimePoint sentAt) {
  scratch_.clear();
  send(sizeBytes, sentAt, scratch_);
  return scratch_.back().arrivesAt;
}

void LinkModel::drawDelay(TimePoint now) {
  if (isDrawn_ && now < drawnAt_ + kJitterHold) return;
  isDrawn_ = true;
  drawnAt_ = now;
  double delayMs = settings_.delayMs;
  if (settings_.trace) {
    const std::vector<double>& delaysMs = settings_.trace->delaysMs;
    delayMs += delaysMs[tracePosition_];
    tracePosition_ = (tracePosition_ + 1) % delaysMs.size();
  }
  if (settings_.jitter == Jitter::uniform) delayMs += settings_.jitterMs * (2 * uniform(jitterDice_) - 1);
  if (settings_.jitter == Jitter::normal) delayMs += settings_.jitterMs * normal(jitterDice_);
  delay_ = durationOfMs(std::max(0.0, delayMs));
}

/// When the last bit of it has left the bottleneck. Without a bucket it takes the time of its bits; a bucket lends it tokens.
TimePoint LinkModel::departure(size_t sizeBytes, TimePoint from) {
  const double bytesPerS = settings_.rateBitPerS / 8;
  while (true) {
    TimePoint leaves = from, fullAt = bucketFullAt_;
    if (settings_.rateBitPerS > 0) {
      fullAt = std::max(fullAt, from) + durationOfS(static_cast<double>(sizeBytes) / bytesPerS);
      leaves = std::max(from, fullAt - durationOfS(settings_.burstBytes / bytesPerS));
    }
    const TimePoint end = endOfOutage(leaves);
    if (end <= leaves) {
      bucketFullAt_ = fullAt;
      return leaves;
    }
    from = end;  // as if it had been sent only now
  }
}

/// By how much later a segment arrives whose first transmission was lost.
Duration LinkModel::retransmission(bool isFollowed, Duration occupied) {
  Duration later = isFollowed ? roundTrip_ * 5 / 4 : std::max(2 * roundTrip_, kLeastProbe);
  Duration timeout = timeout_;
  ++lossCount_;
  bucketFullAt_ += occupied;
  for (int i = 1; i < kMostRetransmissions && uniform(lossDice_) < settings_.loss; ++i) {
    ++lossCount_;
    bucketFullAt_ += occupied;
    later += timeout;
    timeout = std::min(2 * timeout, kLongestTimeout);
  }
  return later;
}

/// When the outage that `time` lies in ends; `time` itself if it lies in none.
TimePoint LinkModel::endOfOutage(TimePoint time) {
  if (settings_.outageIntervalMs == 0) return time;
  while (outageEnd_ <= time) drawOutage(outageEnd_);
  return time < outageBegin_ ? time : outageEnd_;
}

/// The next one after `after`: the end of the last one, or the start.
void LinkModel::drawOutage(TimePoint after) {
  if (settings_.outageIntervalMs == 0) return;
  const Duration length = durationOfMs(settings_.outageMs), interval = durationOfMs(settings_.outageIntervalMs);
  outageBegin_ = after + (settings_.outagesAreRandom ? durationOfMs(settings_.outageIntervalMs * exponential(outageDice_)) : interval - length);
  outageEnd_ = outageBegin_ + length;
}

}  // namespace warpscope::net
