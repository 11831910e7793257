// The link in virtual time, over a pipe: round trips, rates, memory, changes while it runs, and how errors and ends come through.
// Mirrors net/linked_stream.h. Nothing but the clock is waited for: times are exact.
#include "net/linked_stream.h"

#include <algorithm>
#include <array>

#include "net/link_model.h"
#include "tests/net/io_test.h"
#include "tests/net/pipe.h"

namespace warpscope::net {
namespace {

using testing::HasSubstr;

class LinkedStreamTest : public IoTest {
 protected:
  /// The client's end is behind the link.
  void connect(std::string_view settings) {
    auto [near, far] = PipeEnd::makePair(io_.get_executor());
    server_ = std::move(far);
    auto inner = std::make_unique<Counting>(std::move(near));
    counting_ = inner.get();
    client_ = std::make_unique<LinkedStream>(std::move(inner), parseLinkSettings(settings));
  }

  Awaitable<void> echo() {
    std::array<char, 4096> buffer;
    while (const size_t count = co_await server_->readSome(asio::buffer(buffer)))
      co_await server_->write(asio::buffer(buffer, count));
    server_->close();
  }

  Awaitable<double> roundTripMs() {
    const TimePoint begin = clock_.now();
    co_await writeText(*client_, "ping");
    co_await readText(*client_, 4);
    co_return msSince(begin);
  }

  /// Passes everything on, and remembers where reads went to.
  class Counting final : public Stream {
   public:
    explicit Counting(std::unique_ptr<Stream> inner) : inner_(std::move(inner)) {}
    using Stream::write;
    Awaitable<size_t> readSome(asio::mutable_buffer buffer) override {
      lastRead = buffer.data();
      ++reads;
      return inner_->readSome(buffer);
    }
    Awaitable<void> write(std::span<const asio::const_buffer> buffers) override {
      if (!buffers.empty()) lastWritten = buffers[0].data();
      return inner_->write(buffers);
    }
    Awaitable<void> finish(TimePoint deadline) override { return inner_->finish(deadline); }
    void close() noexcept override { inner_->close(); }
    void abort() noexcept override { inner_->abort(); }
    asio::any_io_executor executor() override { return inner_->executor(); }
    const std::string& peer() const override { return inner_->peer(); }

    const void* lastRead = nullptr;
    const void* lastWritten = nullptr;
    int reads = 0;

   private:
    const std::unique_ptr<Stream> inner_;
  };

  std::unique_ptr<PipeEnd> server_;
  std::unique_ptr<LinkedStream> client_;
  Counting* counting_ = nullptr;
};

TEST_F(LinkedStreamTest, WithoutSettingsItIsNotThere) {
  connect("none");
  runThrough([&]() -> Awaitable<> {
    const std::string sent = "straight through";
    co_await client_->write(asio::buffer(sent));
    EXPECT_EQ(counting_->lastWritten, sent.data()) << "no copy";
    const std::string arrived = co_await readText(*server_, sent.size());
    EXPECT_EQ(arrived, sent);
    co_await server_->write(asio::buffer(sent));
    std::string got(sent.size(), ' ');
    co_await readExactly(*client_, asio::buffer(got));
    EXPECT_EQ(got, sent);
    EXPECT_EQ(counting_->lastRead, got.data()) << "no copy";
    EXPECT_EQ(counting_->reads, 1);
  });
}

TEST_F(LinkedStreamTest, RoundTrip) {
  connect("up.delay=10,down.delay=20");
  spawn([&]() -> Awaitable<> { co_await echo(); });
  spawn([&]() -> Awaitable<> {
    for (int i = 0; i < 3; ++i) {
      const double tripMs = co_await roundTripMs();
      EXPECT_EQ(tripMs, 30.0);
    }
    co_await client_->finish(never());
  });
  runThrough();
}

/// 1 MB at 40 Mbit/s, 5 ms away: 205 ms.
class LinkedStreamRateTest : public LinkedStreamTest {
 protected:
  double transferMs(bool isUp) {
    connect("rate=40M,delay=5");
    Stream& from = isUp ? static_cast<Stream&>(*client_) : *server_;
    Stream& to = isUp ? static_cast<Stream&>(*server_) : *client_;
    const std::string sent = pattern(1'000'000);
    std::string got;
    double tookMs = 0;
    const TimePoint begin = clock_.now();
    spawn([&]() -> Awaitable<> { co_await writeText(from, sent); });
    spawn([&]() -> Awaitable<> {
      got = co_await readText(to, sent.size());
      tookMs = msSince(begin);
    });
    runThrough();
    EXPECT_TRUE(got == sent);
    return tookMs;
  }
};

TEST_F(LinkedStreamRateTest, Up) { EXPECT_NEAR(transferMs(true), 205.0, 0.01); }
TEST_F(LinkedStreamRateTest, Down) { EXPECT_NEAR(transferMs(false), 205.0, 0.01); }

TEST_F(LinkedStreamTest, EverythingAtOnceKeepsOrderAndBytes) {
  connect("delay=3,jitter=3,rate=200M,loss=1%,outage=5/30");
  const std::string sent = pattern(1'000'000);
  std::array<std::string, 2> got;
  spawn([&]() -> Awaitable<> { co_await writeText(*client_, sent); });
  spawn([&]() -> Awaitable<> { co_await writeText(*server_, sent); });
  spawn([&]() -> Awaitable<> { got[0] = co_await readText(*client_, sent.size()); });
  spawn([&]() -> Awaitable<> { got[1] = co_await readText(*server_, sent.size()); });
  runThrough();
  EXPECT_TRUE(got[0] == sent);
  EXPECT_TRUE(got[1] == sent);
}

/// Nobody reads; what is held stays within the link's capacity, and the writers wait.
TEST_F(LinkedStreamTest, MemoryIsBounded) {
  connect("rate=1M,delay=200");
  const size_t capacity = LinkModel(parseLinkSettings("rate=1M,delay=200").up).capacityBytes();
  size_t mostUp = 0, mostDown = 0;
  bool isWritten = false;
  spawn([&]() -> Awaitable<> {
    const Thrown failure = co_await failureOf(writeText(*client_, std::string(32 << 20, 'x')));
    isWritten = failure.text.empty();
  });
  spawn([&]() -> Awaitable<> { co_await failureOf(writeText(*server_, std::string(32 << 20, 'x'))); });
  spawn([&]() -> Awaitable<> {
    for (int i = 0; i < 20; ++i) {
      co_await sleep(milliseconds(5));
      mostUp = std::max(mostUp, client_->bytesUp());
      mostDown = std::max(mostDown, client_->bytesDown());
    }
    client_->close();
    server_->close();
  });
  runThrough();
  EXPECT_FALSE(isWritten);
  EXPECT_LE(mostUp, capacity);
  EXPECT_LE(mostDown, capacity);
  EXPECT_GE(mostUp, capacity * 9 / 10);
  EXPECT_GE(mostDown, capacity / 2);
}

TEST_F(LinkedStreamTest, ChangesWhileItRuns) {
  connect("none");
  spawn([&]() -> Awaitable<> { co_await echo(); });
  spawn([&]() -> Awaitable<> {
    co_await roundTripMs();
    client_->setSettings(parseLinkSettings("delay=20"));
    for (int i = 0; i < 2; ++i) {
      const double trip = co_await roundTripMs();
      EXPECT_EQ(trip, 40.0);
    }
    client_->setSettings(parseLinkSettings("delay=5"));
    const double trip = co_await roundTripMs();
    EXPECT_EQ(trip, 10.0);
    client_->setSettings({});
    co_await roundTripMs();  // the last one that is read ahead
    const int readsBefore = counting_->reads;
    co_await roundTripMs();
    EXPECT_EQ(counting_->reads, readsBefore + 1) << "straight through again";
    co_await client_->finish(never());
  });
  runThrough();
}

/// A reader that waits in the inner stream when the link gets its delay: what comes then takes the delay.
TEST_F(LinkedStreamTest, AReaderThatWaitsGetsTheNewDelay) {
  connect("none");
  TimePoint sentAt;
  spawn([&]() -> Awaitable<> {
    co_await sleep(milliseconds(5));
    client_->setSettings(parseLinkSettings("delay=30"));
    sentAt = clock_.now();
    co_await writeText(*server_, "late");
  });
  spawn([&]() -> Awaitable<> {
    const std::string got = co_await readText(*client_, 4);
    EXPECT_EQ(got, "late");
    EXPECT_EQ(msSince(sentAt), 30.0);
  });
  runThrough();
}

TEST_F(LinkedStreamTest, WhatIsUnderWayKeepsItsTime) {
  connect("delay=40");
  const TimePoint begin = clock_.now();
  spawn([&]() -> Awaitable<> {
    co_await writeText(*client_, "first ");
    client_->setSettings({});
    co_await writeText(*client_, "second");
  });
  spawn([&]() -> Awaitable<> {
    const std::string got = co_await readText(*server_, 12);
    EXPECT_EQ(got, "first second");
    EXPECT_EQ(msSince(begin), 40.0);
  });
  runThrough();
}

TEST_F(LinkedStreamTest, EndsArriveLate) {
  connect("delay=30");
  runThrough([&]() -> Awaitable<> {
    co_await writeText(*server_, "bye");
    const TimePoint begin = clock_.now();
    server_->close();
    const std::string got = co_await readToEnd(*client_);
    EXPECT_EQ(got, "bye");
    EXPECT_EQ(msSince(begin), 30.0);
    std::array<char, 5> buffer;
    const size_t again = co_await client_->readSome(asio::buffer(buffer));
    EXPECT_EQ(again, 0u);
  });
}

TEST_F(LinkedStreamTest, ErrorsArriveLateAndAgain) {
  connect("delay=30");
  runThrough([&]() -> Awaitable<> {
    const TimePoint begin = clock_.now();
    server_->abort();
    std::array<char, 5> buffer;
    for (int i = 0; i < 2; ++i) {
      const Thrown failure = co_await failureOf(client_->readSome(asio::buffer(buffer)));
      EXPECT_EQ(failure.code, asio::error::connection_reset);
      EXPECT_EQ(msSince(begin), 30.0);
    }
  });
}

TEST_F(LinkedStreamTest, WritersLearnOfErrorsARoundTripLater) {
  connect("delay=20");
  runThrough([&]() -> Awaitable<> {
    server_->abort();
    const TimePoint begin = clock_.now();
    Thrown failure;
    while (msSince(begin) < 5000) {
      failure = co_await failureOf(writeText(*client_, "x"));
      if (!failure.text.empty()) break;
      co_await sleep(milliseconds(1));
    }
    EXPECT_THAT(failure.text, HasSubstr("writing to the other end of a pipe"));
    EXPECT_EQ(msSince(begin), 40.0);
  });
}

TEST_F(LinkedStreamTest, FinishingLetsTheLinkRunEmpty) {
  connect("delay=20,rate=10M");
  const std::string sent = pattern(100'000);
  std::string got;
  spawn([&]() -> Awaitable<> {
    co_await writeText(*client_, sent);
    co_await client_->finish(never());
  });
  spawn([&]() -> Awaitable<> {
    got = co_await readToEnd(*server_);
    server_->close();
  });
  runThrough();
  EXPECT_TRUE(got == sent);
}

TEST_F(LinkedStreamTest, FinishingDoesNotWaitBeyondItsDeadline) {
  connect("delay=5000");
  runThrough([&]() -> Awaitable<> {
    co_await writeText(*client_, "never to arrive");
    const TimePoint begin = clock_.now();
    co_await client_->finish(inTime(milliseconds(20)));
    EXPECT_EQ(msSince(begin), 20.0);
  });
}

TEST_F(LinkedStreamTest, ClosingEndsWhatIsUnderWay) {
  for (const char* const settings : {"none", "delay=5000,rate=1M"}) {
    SCOPED_TRACE(settings);
    connect(settings);
    Thrown read, write;
    spawn([&]() -> Awaitable<> { read = co_await failureOf(readText(*client_, 1)); });
    spawn([&]() -> Awaitable<> { write = co_await failureOf(writeText(*client_, std::string(64 << 20, 'x'))); });
    spawn([&]() -> Awaitable<> {
      co_await sleep(milliseconds(10));
      client_->close();
      client_->close();
    });
    runThrough();
    EXPECT_EQ(read.code, asio::error::operation_aborted);
    EXPECT_EQ(write.code, asio::error::operation_aborted);
    EXPECT_EQ(client_->bytesUp(), 0u);
  }
}

TEST_F(LinkedStreamTest, DeadlinesActThroughTheLink) {
  connect("delay=5000");
  runThrough([&]() -> Awaitable<> {
    const Thrown failure =
        co_await failureOf(withDeadline(*client_, inTime(milliseconds(20)), "waiting", readText(*client_, 1)));
    EXPECT_TRUE(failure.isDeadline);
  });
}

TEST_F(LinkedStreamTest, MayGoWhileBytesAreOnTheLink) {
  connect("delay=50");
  runThrough([&]() -> Awaitable<> {
    co_await writeText(*client_, "never to arrive");
    co_await writeText(*server_, "never to arrive either");
    co_await sleep(milliseconds(5));
    client_.reset();
    std::array<char, 5> buffer;
    const Thrown failure = co_await failureOf(server_->readSome(asio::buffer(buffer)));
    EXPECT_TRUE(failure.text.empty() || failure.code == asio::error::connection_reset) << failure.text;
  });
}

TEST_F(LinkedStreamTest, RefusesWhatMakesNoSense) {
  connect("delay=5");
  DuplexLinkSettings wrong;
  wrong.down.loss = 2;
  EXPECT_THROW(client_->setSettings(wrong), LinkSettingsError);
  EXPECT_EQ(client_->settings(), parseLinkSettings("delay=5"));
}

}  // namespace
}  // namespace warpscope::net
