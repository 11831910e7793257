// The link in virtual time: what was asked for is what is measured, seeds reproduce, nothing overtakes, changes act from then on.
// Mirrors net/link_model.h.
#include "net/link_model.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <tuple>

namespace warpscope::net {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Duration = LinkModel::Duration;
using TimePoint = LinkModel::TimePoint;

constexpr double kTolerance = 0.02;
constexpr TimePoint kStart{seconds(1000)};

double msOf(Duration duration) { return std::chrono::duration<double, std::milli>(duration).count(); }

/// Delays of single segments, so far apart that none waits for another one.
std::vector<double> delaysOf(LinkModel& model, int count, Duration apart) {
  std::vector<double> delaysMs;
  for (int i = 0; i < count; ++i) {
    const TimePoint sentAt = kStart + i * apart;
    delaysMs.push_back(msOf(model.arrivalOf(kSegmentBytes, sentAt) - sentAt));
  }
  return delaysMs;
}

double meanOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviationOf(const std::vector<double>& values) {
  const double mean = meanOf(values);
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

LinkModel modelOf(const char* text, uint32_t stream = 0) { return LinkModel(parseLinkSettings(text).up, kStart, stream); }

TEST(LinkModel, WithoutSettingsBytesArriveAtOnce) {
  LinkModel model = modelOf("none");
  EXPECT_EQ(model.arrivalOf(1, kStart), kStart);
  EXPECT_EQ(model.arrivalOf(100'000'000, kStart + seconds(1)), kStart + seconds(1));
  EXPECT_EQ(model.arrivalOf(0, kStart + seconds(2)), kStart + seconds(2));
}

TEST(LinkModel, Delay) {
  LinkModel model = modelOf("delay=12.5");
  for (const double delayMs : delaysOf(model, 1000, milliseconds(1))) ASSERT_DOUBLE_EQ(delayMs, 12.5);
}

TEST(LinkModel, UniformJitter) {
  LinkModel model = modelOf("delay=100,jitter=10");
  const std::vector<double> delaysMs = delaysOf(model, 50'000, milliseconds(30));
  const auto [least, most] = std::minmax_element(delaysMs.begin(), delaysMs.end());
  EXPECT_NEAR(meanOf(delaysMs), 100, 100 * 0.001);
  EXPECT_NEAR(deviationOf(delaysMs), 10 / std::sqrt(3), 10 / std::sqrt(3) * kTolerance);
  EXPECT_GE(*least, 90);
  EXPECT_LE(*most, 110);
  EXPECT_NEAR(*least, 90, 20 * kTolerance);
  EXPECT_NEAR(*most, 110, 20 * kTolerance);
}

TEST(LinkModel, NormalJitter) {
  LinkModel model = modelOf("delay=100,jitter=normal:10");
  const std::vector<double> delaysMs = delaysOf(model, 50'000, milliseconds(200));
  EXPECT_NEAR(meanOf(delaysMs), 100, 100 * 0.002);
  EXPECT_NEAR(deviationOf(delaysMs), 10, 10 * kTolerance);
  const auto within = [&](double ms) {
    return static_cast<double>(std::count_if(delaysMs.begin(), delaysMs.end(), [&](double delayMs) { return std::abs(delayMs - 100) < ms; })) /
           static_cast<double>(delaysMs.size());
  };
  EXPECT_NEAR(within(10), 0.6827, 0.6827 * kTolerance);
  EXPECT_NEAR(within(20), 0.9545, 0.9545 * kTolerance);
  EXPECT_GT(*std::min_element(delaysMs.begin(), delaysMs.end()), 0);
}

TEST(LinkModel, NegativeDelaysAreNone) {
  LinkModel model = modelOf("delay=10,jitter=normal:10");
  const std::vector<double> delaysMs = delaysOf(model, 10'000, milliseconds(200));
  EXPECT_EQ(*std::min_element(delaysMs.begin(), delaysMs.end()), 0);
  EXPECT_NEAR(static_cast<double>(std::count(delaysMs.begin(), delaysMs.end(), 0.0)), 10'000 * 0.1587, 100);
}

TEST(LinkModel, JitterHoldsForAMoment) {
  LinkModel model = modelOf("delay=100,jitter=50");
  const double first = delaysOf(model, 1, {}).front();
  for (int us = 0; us < 5000; us += 500) {
    const TimePoint sentAt = kStart + std::chrono::microseconds(us);
    EXPECT_EQ(msOf(model.arrivalOf(1, sentAt) - sentAt), first);
  }
  const TimePoint later = kStart + seconds(1);
  EXPECT_NE(msOf(model.arrivalOf(1, later) - later), first);
}

TEST(LinkModel, TracesAreReplayedAgainAndAgain) {
  LinkSettings settings;
  settings.delayMs = 5;
  settings.trace = parseTrace("10\n20\n40\n", "t");
  LinkModel model(settings, kStart);
  EXPECT_THAT(delaysOf(model, 7, milliseconds(100)), testing::ElementsAre(15, 25, 45, 15, 25, 45, 15));
}

TEST(LinkModel, Rate) {
  for (const char* const text : {"rate=1k", "rate=64k", "rate=20M", "rate=1G", "rate=10G", "rate=20M,delay=100,jitter=10"}) {
    SCOPED_TRACE(text);
    LinkModel model = modelOf(text);
    const double rate = model.settings().rateBitPerS, delayS = model.settings().delayMs / 1000;
    // A second's worth and more, in chunks that are no multiples of a segment, all at once and one after the other.
    const auto chunk = static_cast<size_t>(rate / 8 / 7.3);
    TimePoint last = kStart;
    size_t sizeBytes = 0;
    for (int i = 0; i < 73; ++i, sizeBytes += chunk) last = model.arrivalOf(chunk, std::max(kStart, last - milliseconds(300)));
    const double measured = static_cast<double>(sizeBytes) * 8 / (msOf(last - kStart) / 1000 - delayS);
    EXPECT_NEAR(measured, rate, rate * kTolerance);
  }
}

TEST(LinkModel, AnIdleLineTakesTheTimeOfTheBits) {
  LinkModel model = modelOf("rate=8M,delay=10");
  EXPECT_DOUBLE_EQ(msOf(model.arrivalOf(1000, kStart) - kStart), 11);
  const TimePoint later = kStart + seconds(5);  // a pause saves up nothing
  EXPECT_DOUBLE_EQ(msOf(model.arrivalOf(10'000, later) - later), 20);
}

TEST(LinkModel, ABucketLetsBurstsPass) {
  LinkModel model = modelOf("rate=8M,burst=100k");
  EXPECT_EQ(model.arrivalOf(100'000, kStart), kStart);
  EXPECT_DOUBLE_EQ(msOf(model.arrivalOf(50'000, kStart) - kStart), 50);
  // 70 ms after it was empty it holds 20 ms more than the 50 it has lent: 20000 bytes.
  const TimePoint later = kStart + milliseconds(70);
  EXPECT_EQ(model.arrivalOf(20'000, later), later);
  EXPECT_DOUBLE_EQ(msOf(model.arrivalOf(1000, later) - later), 1);
  const TimePoint muchLater = kStart + seconds(9);
  EXPECT_EQ(model.arrivalOf(100'000, muchLater), muchLater);
}

TEST(LinkModel, LossRateAndItsDelays) {
  constexpr int kCount = 1'000'000;
  for (const char* const text : {"loss=5%,delay=50", "loss=20%,delay=50"}) {
    SCOPED_TRACE(text);
    LinkModel model = modelOf(text);
    const double loss = model.settings().loss;
    std::vector<Segment> segments;
    std::array<int, 4> counts{};  // in time, by a probe, by one timeout more, by several
    for (int i = 0; i < kCount; ++i) {
      const TimePoint sentAt = kStart + i * seconds(100);
      segments.clear();
      model.send(1, sentAt, segments);
      const double delayMs = msOf(segments[0].arrivesAt - sentAt);
      ++counts[delayMs == 50 ? 0 : delayMs == 250 ? 1 : delayMs == 450 ? 2 : 3];
    }
    EXPECT_EQ(model.segmentCount(), static_cast<uint64_t>(kCount));
    EXPECT_NEAR(kCount - counts[0], kCount * loss, kCount * loss * kTolerance);
    EXPECT_NEAR(counts[1], kCount * loss * (1 - loss), kCount * loss * (1 - loss) * kTolerance);
    const double twice = kCount * loss * loss * (1 - loss);
    EXPECT_NEAR(counts[2], twice, twice * 0.06) << "rare, so less exact";
    const double transmissions = kCount + static_cast<double>(model.lossCount());
    EXPECT_NEAR(static_cast<double>(model.lossCount()) / transmissions, loss, loss * kTolerance);
  }
}

/// Each link's loss, and how long a segment takes in time, by a probe, and by each timeout more.
TEST(LinkModel, ProbesTakeAWhileAndTimeoutsDoubleUpToAMinute) {
  for (const auto& [text, inTimeMs, byProbeMs] : {std::tuple("loss=50%,delay=50", 50.0, 250.0), std::tuple("loss=50%", 0.0, 10.0)}) {
    SCOPED_TRACE(text);
    std::vector<double> expected{inTimeMs, byProbeMs};
    for (double timeoutMs = 200.0; expected.size() < 40; timeoutMs = std::min(2.0 * timeoutMs, 60'000.0)) expected.push_back(expected.back() + timeoutMs);
    LinkModel model = modelOf(text);
    size_t most = 0;
    for (int i = 0; i < 20'000; ++i) {
      const TimePoint sentAt = kStart + i * std::chrono::hours(1);
      const double delayMs = msOf(model.arrivalOf(1, sentAt) - sentAt);
      const auto at = std::ranges::find(expected, delayMs);
      ASSERT_NE(at, expected.end()) << delayMs;
      most = std::max(most, static_cast<size_t>(at - expected.begin()));
    }
    EXPECT_GT(most, 11u) << "more than one timeout of a minute";
  }
}

TEST(LinkModel, WhatFollowsMakesALossKnownSooner) {
  LinkModel model = modelOf("delay=40,loss=50%,seed=3");
  int sooner = 0, later = 0;
  for (int i = 0; i < 1000; ++i) {
    const TimePoint sentAt = kStart + i * seconds(1000);
    std::vector<Segment> segments;
    model.send(2 * kSegmentBytes, sentAt, segments);
    ASSERT_EQ(segments.size(), 2u);
    sooner += msOf(segments[0].arrivesAt - sentAt) == 40 + 100;  // 1.25 round trips
    later += msOf(segments[1].arrivesAt - sentAt) == 40 + 160;   // 2 round trips
    segments.clear();
    model.send(kSegmentBytes, sentAt + seconds(500), segments, 1);
    const double delayMs = msOf(segments[0].arrivesAt - (sentAt + seconds(500)));
    EXPECT_NE(delayMs, 40 + 160) << "something follows";
  }
  EXPECT_GT(sooner, 100);
  EXPECT_GT(later, 50);
}

TEST(LinkModel, RetransmissionsTakeTheirShareOfTheRate) {
  LinkModel model = modelOf("rate=20M,loss=20%");
  TimePoint last = kStart;
  constexpr size_t kSize = 50'000'000;
  last = model.arrivalOf(kSize, kStart);
  const double measured = kSize * 8 / (msOf(last - kStart) / 1000);
  EXPECT_NEAR(measured, 20e6 * (1 - 0.2), 20e6 * (1 - 0.2) * kTolerance);
}

TEST(LinkModel, NothingOvertakes) {
  for (const LinkPreset& preset : linkPresets()) {
    LinkSettings settings = preset.settings.up;
    settings.delayMs += 10;
    settings.jitter = Jitter::uniform;
    settings.jitterMs = settings.delayMs;
    settings.loss = 0.1;
    LinkModel model(settings, kStart);
    std::vector<Segment> segments;
    for (int i = 0; i < 20'000; ++i) model.send(i * 37 % 5000, kStart + i * std::chrono::microseconds(700), segments);
    EXPECT_TRUE(std::is_sorted(segments.begin(), segments.end(),
                               [](const Segment& a, const Segment& b) { return a.arrivesAt < b.arrivesAt; }))
        << preset.name;
  }
}

TEST(LinkModel, SegmentsAddUp) {
  LinkModel model = modelOf("rate=1M");
  for (const size_t size : {size_t{0}, size_t{1}, kSegmentBytes, kSegmentBytes + 1, size_t{100'000}}) {
    std::vector<Segment> segments;
    model.send(size, kStart, segments);
    size_t sum = 0;
    for (const Segment& segment : segments) sum += segment.sizeBytes;
    EXPECT_EQ(sum, size);
    EXPECT_EQ(segments.size(), std::max<size_t>(1, (size + kSegmentBytes - 1) / kSegmentBytes));
  }
}

TEST(LinkModel, SeedsReproduce) {
  const auto arrivals = [](const char* text, uint32_t stream) {
    LinkModel model = modelOf(text, stream);
    std::vector<double> delaysMs = delaysOf(model, 2000, milliseconds(17));
    return delaysMs;
  };
  const char* const text = "conference-wifi,seed=5";
  EXPECT_EQ(arrivals(text, 0), arrivals(text, 0));
  EXPECT_NE(arrivals(text, 0), arrivals("conference-wifi,seed=6", 0));
  EXPECT_NE(arrivals(text, 0), arrivals(text, 1)) << "the two directions have different dice";
}

TEST(LinkModel, PeriodicOutages) {
  LinkModel model = modelOf("delay=10,outage=200/1000");
  int held = 0;
  for (int ms = 0; ms < 10'000; ++ms) {
    const double delayMs = msOf(model.arrivalOf(100, kStart + milliseconds(ms)) - (kStart + milliseconds(ms)));
    const int phase = ms % 1000;
    ASSERT_DOUBLE_EQ(delayMs, phase < 800 ? 10 : 10 + 1000 - phase) << ms;
    held += delayMs > 10;
  }
  EXPECT_EQ(held, 2000);
}

TEST(LinkModel, RandomOutages) {
  LinkModel model = modelOf("outage=200/~800,seed=11");
  int held = 0, begun = 0;
  bool wasHeld = false;
  constexpr int kCount = 20'000'000;
  for (int ms = 0; ms < kCount; ms += 10) {
    const TimePoint sentAt = kStart + milliseconds(ms);
    const bool isHeld = model.arrivalOf(100, sentAt) > sentAt;
    held += isHeld;
    begun += isHeld && !wasHeld;
    wasHeld = isHeld;
  }
  EXPECT_NEAR(held, kCount / 10 * 0.2, kCount / 10 * 0.2 * kTolerance);
  // Pauses shorter than the 10 ms between two looks are not seen: exp(-10/800) of them are.
  EXPECT_NEAR(begun, kCount / 1000 * std::exp(-10.0 / 800), kCount / 1000 * kTolerance);
}

TEST(LinkModel, AnOutageHoldsTheQueueAtTheRate) {
  LinkModel model = modelOf("rate=8M,outage=500/1000");
  // Sent at 400 ms: 100 kB get through, the other 100 kB from 1000 ms on.
  EXPECT_NEAR(msOf(model.arrivalOf(200'000, kStart + milliseconds(400)) - kStart), 1100, 3);
}

TEST(LinkModel, ChangesActOnWhatIsSentAfterwards) {
  LinkModel model = modelOf("delay=500");
  const TimePoint first = model.arrivalOf(1, kStart);
  model.setSettings(parseLinkSettings("delay=10").up, kStart + milliseconds(100));
  EXPECT_EQ(first, kStart + milliseconds(500));
  EXPECT_EQ(model.arrivalOf(1, kStart + milliseconds(100)), first) << "it does not overtake";
  EXPECT_EQ(model.arrivalOf(1, kStart + milliseconds(600)), kStart + milliseconds(610));

  model.setSettings(parseLinkSettings("rate=8M").up, kStart + seconds(2));
  EXPECT_DOUBLE_EQ(msOf(model.arrivalOf(1'000'000, kStart + seconds(2)) - kStart), 3000);
  model.setSettings(parseLinkSettings("rate=80M").up, kStart + milliseconds(2500));
  // What was queued leaves at its old rate until 3000 ms; from then on ten times as fast.
  EXPECT_DOUBLE_EQ(msOf(model.arrivalOf(1'000'000, kStart + milliseconds(2500)) - kStart), 3100);
  model.setSettings({}, kStart + seconds(4));
  EXPECT_EQ(model.arrivalOf(1'000'000, kStart + seconds(4)), kStart + seconds(4));
}

TEST(LinkModel, TimesThatGoBackCountAsTheLast) {
  LinkModel model = modelOf("delay=10");
  EXPECT_EQ(model.arrivalOf(1, kStart + seconds(1)), kStart + milliseconds(1010));
  EXPECT_EQ(model.arrivalOf(1, kStart), kStart + milliseconds(1010));
}

TEST(LinkModel, Capacity) {
  EXPECT_EQ(modelOf("rate=80M,delay=100").capacityBytes(), 2'000'000u);  // as much on the way as in the buffer
  EXPECT_EQ(modelOf("rate=80M,delay=100,buffer=50k").capacityBytes(), 1'050'000u);
  EXPECT_EQ(modelOf("rate=1M").capacityBytes(), 65'536u);
  EXPECT_EQ(modelOf("rate=10G,delay=10000").capacityBytes(), size_t{64} << 20);
}

TEST(LinkModel, RefusesWhatMakesNoSense) {
  LinkSettings settings;
  settings.delayMs = -1;
  EXPECT_THROW(LinkModel{settings}, LinkSettingsError);
  LinkModel model = modelOf("lan");
  EXPECT_THROW(model.setSettings(settings, kStart), LinkSettingsError);
  EXPECT_EQ(model.settings(), parseLinkSettings("lan").up) << "nothing has changed";
}

}  // namespace
}  // namespace warpscope::net
