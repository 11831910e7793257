// Tests of coroutines: they run on one thread until all of them have ended, in virtual time, and a hang is a failure instead of a wait.
// Boost.Asio's co_spawn, with what is thrown handed to the test.
#pragma once

#include <gmock/gmock.h>

#include <exception>
#include <string>
#include <utility>

#include "net/deadline.h"
#include "net/tcp_stream.h"

namespace warpscope::net {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A deadline for what is not to wait for one.
inline TimePoint never() { return TimePoint::max(); }

class IoTest : public testing::Test {
 protected:
  IoTest() { setClock(io_, clock_); }

  /// Begins when run() is called. `work`: a lambda that returns Awaitable<void>; it is kept until it ends.
  template <class Work>
  void spawn(Work work) {
    ++running_;
    asio::co_spawn(io_, std::move(work), [this](std::exception_ptr failure) {
      --running_;
      if (failure && !failure_) failure_ = failure;
    });
  }

  /// Until everything that was spawned has ended. The clock stands still but for pass(): the sockets below are real.
  void run() {
    const auto limit = std::chrono::steady_clock::now() + seconds(60);  // of hanging
    io_.restart();
    while (running_ > 0 && !failure_ && io_.run_one_until(limit) > 0) {
    }
    expectAllEnded();
  }
  template <class Work>
  void run(Work work) {
    spawn(std::move(work));
    run();
  }

  /// The same for what waits for nothing but the clock: it moves on to the next timer whenever there is nothing else to do.
  void runThrough() {
    io_.restart();
    do {
      io_.poll();
      io_.restart();
    } while (running_ > 0 && !failure_ && clock_.advanceToNextSleeper(kLatest));
    expectAllEnded();
  }
  template <class Work>
  void runThrough(Work work) {
    spawn(std::move(work));
    runThrough();
  }

  TimePoint inTime(Duration duration) const { return clock_.now() + duration; }
  double msSince(TimePoint begin) const { return millisecondsBetween(begin, clock_.now()); }
  Awaitable<void> sleep(Duration duration) {
    Timer timer(io_.get_executor(), inTime(duration));
    co_await timer.wait();
  }
  /// Moves the clock on once everything that was ready has run, and goes on once what that made ready has.
  Awaitable<void> pass(Duration duration) {
    co_await settle();
    clock_.advance(duration);
    co_await settle();
  }

  struct Pair {
    std::unique_ptr<TcpStream> client, server;
  };
  Awaitable<Pair> connectedPair() {
    TcpListener listener(io_.get_executor(), "127.0.0.1", 0);
    Pair pair;
    pair.client = co_await connectTcp(io_.get_executor(), "127.0.0.1", listener.port(), never());
    pair.server = co_await listener.accept(never());
    co_return pair;
  }

  VirtualClock clock_;
  asio::io_context io_{1};

 private:
  static constexpr TimePoint kLatest = TimePoint(std::chrono::hours(1000));  // beyond it nobody waits for a time

  Awaitable<void> settle() {
    for (int i = 0; i < 32; ++i) co_await asio::post(io_, asio::use_awaitable);
  }
  void expectAllEnded() {
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    ASSERT_EQ(running_, 0) << "coroutines that never ended";
  }

  int running_ = 0;
  std::exception_ptr failure_;
};

struct Thrown {
  error_code code;
  std::string text;  ///< empty if there was none
  bool isDeadline = false;
};

/// What `operation` throws.
template <class T>
Awaitable<Thrown> failureOf(Awaitable<T> operation) {
  Thrown failure;
  try {
    co_await std::move(operation);
  } catch (const DeadlineExceeded& error) {
    failure = {error.code(), error.what(), true};
  } catch (const system_error& error) {
    failure = {error.code(), error.what(), false};
  }
  co_return failure;
}

inline Awaitable<void> writeText(Stream& stream, std::string text) { co_await stream.write(asio::buffer(text)); }

inline Awaitable<std::string> readText(Stream& stream, size_t size) {
  std::string text(size, '\0');
  co_await readExactly(stream, asio::buffer(text));
  co_return text;
}

/// All there is until the end.
inline Awaitable<std::string> readToEnd(Stream& stream) {
  std::string text;
  std::array<char, 5000> piece;
  while (true) {
    const size_t count = co_await stream.readSome(asio::buffer(piece));
    if (count == 0) co_return text;
    text.append(piece.data(), count);
  }
}

/// Bytes that differ from place to place.
inline std::string pattern(size_t size) {
  std::string text(size, '\0');
  for (size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * 131 + i / 251);
  return text;
}

}  // namespace warpscope::net
