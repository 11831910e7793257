// TCP streams: what arrives, how connections end, that nothing waits for ever, and that listening survives a lack of descriptors.
// Mirrors net/tcp_stream.h, net/stream.h and net/deadline.h.
#include "net/tcp_stream.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <iostream>
#include <vector>

#include "tests/net/io_test.h"

namespace warpscope::net {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class TcpStreamTest : public IoTest {};

TEST_F(TcpStreamTest, BytesTravelBothWaysAtOnce) {
  const std::string sent = pattern(3'000'000);
  Pair pair;
  run([&]() -> Awaitable<> { pair = co_await connectedPair(); });
  std::array<std::string, 2> got;
  spawn([&]() -> Awaitable<> { co_await writeText(*pair.client, sent); });
  spawn([&]() -> Awaitable<> { co_await writeText(*pair.server, sent); });
  spawn([&]() -> Awaitable<> { got[0] = co_await readText(*pair.client, sent.size()); });
  spawn([&]() -> Awaitable<> { got[1] = co_await readText(*pair.server, sent.size()); });
  run();
  EXPECT_TRUE(got[0] == sent);
  EXPECT_TRUE(got[1] == sent);
}

TEST_F(TcpStreamTest, WritesSeveralBuffersInOrder) {
  run([&]() -> Awaitable<> {
    Pair pair = co_await connectedPair();
    const std::string a = "head", b, c = pattern(100'000);
    const std::array<asio::const_buffer, 3> buffers{asio::buffer(a), asio::buffer(b), asio::buffer(c)};
    co_await pair.client->write(buffers);
    const std::string got = co_await readText(*pair.server, a.size() + c.size());
    EXPECT_EQ(got, a + c);
  });
}

TEST_F(TcpStreamTest, NamesItsPeer) {
  run([&]() -> Awaitable<> {
    TcpListener listener(io_.get_executor(), "127.0.0.1", 0);
    EXPECT_TRUE(listener.isLoopback());
    EXPECT_EQ(listener.address(), "127.0.0.1:" + std::to_string(listener.port()));
    const auto client = co_await connectTcp(io_.get_executor(), "127.0.0.1", listener.port(), never());
    EXPECT_EQ(client->peer(), listener.address());
    const auto server = co_await listener.accept();
    EXPECT_THAT(server->peer(), StartsWith("127.0.0.1:"));
  });
}

TEST_F(TcpStreamTest, IPv6) {
  std::optional<TcpListener> listener;
  try {
    listener.emplace(io_.get_executor(), "::1", 0);
  } catch (const system_error& error) {
    GTEST_SKIP() << error.what();
  }
  run([&]() -> Awaitable<> {
    const auto client = co_await connectTcp(io_.get_executor(), "::1", listener->port(), never());
    EXPECT_EQ(client->peer(), "[::1]:" + std::to_string(listener->port()));
  });
}

/// The name stands for ::1 and 127.0.0.1, or for one of them; wherever the server is, it is found.
TEST_F(TcpStreamTest, TriesEveryAddressOfAName) {
  TcpListener listener(io_.get_executor(), "127.0.0.1", 0);
  run([&]() -> Awaitable<> {
    const auto client = co_await connectTcp(io_.get_executor(), "localhost", listener.port(), never());
    const auto server = co_await listener.accept(never());
    co_await writeText(*client, "here");
    const std::string got = co_await readText(*server, 4);
    EXPECT_EQ(got, "here");
  });
}

TEST_F(TcpStreamTest, SaysWhyItCannotConnectOrListen) {
  run([&]() -> Awaitable<> {
    uint16_t port = 0;
    {
      TcpListener listener(io_.get_executor(), "127.0.0.1", 0);
      port = listener.port();
      try {
        TcpListener second(io_.get_executor(), "127.0.0.1", port);
        ADD_FAILURE() << "two listen on one port";
      } catch (const system_error& error) {
        EXPECT_EQ(std::string(error.what()), "cannot listen on 127.0.0.1:" + std::to_string(port) + ": Address already in use");
      }
    }
    const Thrown refused = co_await failureOf(connectTcp(io_.get_executor(), "127.0.0.1", port, never()));
    EXPECT_EQ(refused.text, "cannot connect to 127.0.0.1:" + std::to_string(port) + ": Connection refused");
    const Thrown unknown = co_await failureOf(connectTcp(io_.get_executor(), "a..b", port, never()));
    EXPECT_THAT(unknown.text, StartsWith("cannot look up 'a..b': "));
  });
}

TEST_F(TcpStreamTest, FinishingLosesNothing) {
  const std::string sent = pattern(1'000'000);
  Pair pair;
  run([&]() -> Awaitable<> { pair = co_await connectedPair(); });
  std::string got;
  spawn([&]() -> Awaitable<> {
    co_await writeText(*pair.client, sent);
    co_await pair.client->finish(never());
  });
  spawn([&]() -> Awaitable<> {
    co_await writeText(*pair.server, "nobody reads this, and it must not reset the connection");
    co_await pass(milliseconds(20));
    got = co_await readToEnd(*pair.server);
    const size_t again = co_await pair.server->readSome(asio::buffer(got));
    EXPECT_EQ(again, 0u);
    co_await pair.server->finish(never());
  });
  run();
  EXPECT_TRUE(got == sent);
}

TEST_F(TcpStreamTest, FinishingDoesNotWaitBeyondItsDeadline) {
  run([&]() -> Awaitable<> {
    Pair pair = co_await connectedPair();
    bool hasFinished = false;
    spawn([&]() -> Awaitable<> {
      co_await pair.client->finish(inTime(milliseconds(20)));
      hasFinished = true;
    });
    co_await pass(milliseconds(19));
    EXPECT_FALSE(hasFinished);
    co_await pass(milliseconds(1));
    EXPECT_TRUE(hasFinished);
    const Thrown failure = co_await failureOf(writeText(*pair.client, "x"));
    EXPECT_EQ(failure.code, asio::error::operation_aborted);
  });
}

TEST_F(TcpStreamTest, AnEndInTheMiddleIsAnError) {
  run([&]() -> Awaitable<> {
    Pair pair = co_await connectedPair();
    co_await writeText(*pair.client, "abc");
    pair.client->close();
    std::array<char, 5> buffer;
    const Thrown failure = co_await failureOf(readExactly(*pair.server, asio::buffer(buffer)));
    EXPECT_EQ(failure.code, asio::error::eof);
    EXPECT_THAT(failure.text, HasSubstr("it ended after 3 of 5 bytes"));
    const bool isThere = co_await readExactlyOrEnd(*pair.server, asio::buffer(buffer));
    EXPECT_FALSE(isThere);
  });
}

TEST_F(TcpStreamTest, AnAbortIsAnErrorAtThePeer) {
  run([&]() -> Awaitable<> {
    Pair pair = co_await connectedPair();
    pair.client->abort();
    std::array<char, 5> buffer;
    const Thrown failure = co_await failureOf(pair.server->readSome(asio::buffer(buffer)));
    EXPECT_EQ(failure.code, asio::error::connection_reset);
    EXPECT_THAT(failure.text, HasSubstr("reading from 127.0.0.1:"));
  });
}

TEST_F(TcpStreamTest, ClosingEndsWhatIsUnderWay) {
  Pair pair;
  run([&]() -> Awaitable<> { pair = co_await connectedPair(); });
  Thrown read, write;
  spawn([&]() -> Awaitable<> {
    std::array<char, 5> buffer;
    read = co_await failureOf(pair.client->readSome(asio::buffer(buffer)));
  });
  spawn([&]() -> Awaitable<> { write = co_await failureOf(writeText(*pair.client, std::string(64 << 20, 'x'))); });
  spawn([&]() -> Awaitable<> {
    co_await pass(milliseconds(10));
    pair.client->close();
    pair.client->close();
    pair.client->abort();
  });
  run();
  EXPECT_EQ(read.code, asio::error::operation_aborted);
  EXPECT_EQ(write.code, asio::error::operation_aborted);
}

TEST_F(TcpStreamTest, DeadlinesOfReadsAndWrites) {
  run([&]() -> Awaitable<> {
    Pair silent = co_await connectedPair();
    std::array<char, 5> buffer;
    Thrown read;
    spawn([&]() -> Awaitable<> {
      read = co_await failureOf(
          withDeadline(*silent.client, inTime(milliseconds(30)), "reading the greeting", silent.client->readSome(asio::buffer(buffer))));
    });
    co_await pass(milliseconds(29));
    EXPECT_TRUE(read.text.empty()) << "not before its time";
    co_await pass(milliseconds(1));
    EXPECT_TRUE(read.isDeadline);
    EXPECT_EQ(read.code, asio::error::timed_out);
    EXPECT_THAT(read.text, StartsWith("reading the greeting (127.0.0.1:"));
    const Thrown after = co_await failureOf(writeText(*silent.client, "x"));
    EXPECT_EQ(after.code, asio::error::operation_aborted) << "it is closed";

    Pair full = co_await connectedPair();
    Thrown write;
    spawn([&]() -> Awaitable<> {
      write = co_await failureOf(
          withDeadline(*full.client, inTime(milliseconds(30)), "sending", writeText(*full.client, std::string(64 << 20, 'x'))));
    });
    co_await pass(milliseconds(30));
    EXPECT_TRUE(write.isDeadline);
  });
}

TEST_F(TcpStreamTest, DeadlinesLeaveAloneWhatComesInTime) {
  run([&]() -> Awaitable<> {
    Pair pair = co_await connectedPair();
    co_await withDeadline(*pair.client, inTime(milliseconds(200)), "sending", writeText(*pair.client, "abc"));
    const std::string got = co_await withDeadline(*pair.server, never(), "reading", readText(*pair.server, 3));
    EXPECT_EQ(got, "abc");
    co_await pass(milliseconds(230));
    co_await writeText(*pair.client, "def");
  });
}

/// A queue of connections that is full: the machine answers nobody else.
TEST_F(TcpStreamTest, DeadlineOfConnecting) {
  const int listening = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(listening, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(listening, 0), 0);
  ASSERT_EQ(getsockname(listening, reinterpret_cast<sockaddr*>(&address), &size), 0);
  std::vector<int> waiting;
  for (int i = 0; i < 4; ++i) {
    waiting.push_back(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    connect(waiting.back(), reinterpret_cast<sockaddr*>(&address), size);
  }
  run([&]() -> Awaitable<> {
    Thrown failure;
    spawn([&]() -> Awaitable<> {
      failure = co_await failureOf(connectTcp(io_.get_executor(), "127.0.0.1", ntohs(address.sin_port), inTime(milliseconds(50))));
    });
    co_await pass(milliseconds(49));
    EXPECT_TRUE(failure.text.empty()) << failure.text;
    co_await pass(milliseconds(1));
    EXPECT_TRUE(failure.isDeadline) << failure.text;
    EXPECT_THAT(failure.text, StartsWith("connecting to 127.0.0.1:"));
  });
  for (const int descriptor : waiting) close(descriptor);
  close(listening);
}

TEST_F(TcpStreamTest, DeadlineOfAcceptingAndGoingOn) {
  TcpListener listener(io_.get_executor(), "127.0.0.1", 0);
  run([&]() -> Awaitable<> {
    Thrown failure;
    spawn([&]() -> Awaitable<> { failure = co_await failureOf(listener.accept(inTime(milliseconds(20)))); });
    co_await pass(milliseconds(20));
    EXPECT_TRUE(failure.isDeadline);
    const auto client = co_await connectTcp(io_.get_executor(), "127.0.0.1", listener.port(), never());
    const auto server = co_await listener.accept(never());
    EXPECT_NE(server, nullptr);
  });
}

TEST_F(TcpStreamTest, ClosingAListenerEndsItsAccept) {
  TcpListener listener(io_.get_executor(), "127.0.0.1", 0);
  Thrown failure;
  spawn([&]() -> Awaitable<> { failure = co_await failureOf(listener.accept()); });
  spawn([&]() -> Awaitable<> {
    co_await pass(milliseconds(5));
    listener.close();
  });
  run();
  EXPECT_EQ(failure.code, asio::error::operation_aborted);
  run([&]() -> Awaitable<> { failure = co_await failureOf(listener.accept()); });
  EXPECT_EQ(failure.code, asio::error::operation_aborted);
}

/// In a process of its own: takes all descriptors but those it needs, and gives one back once the listener has complained twice.
[[noreturn]] void acceptWithoutDescriptors() {
  asio::io_context io(1);
  TcpListener listener(io.get_executor(), "127.0.0.1", 0);
  int shortages = 0;
  std::vector<int> taken;
  listener.onShortage([&](const std::string& sentence) {
    std::cerr << sentence << "\n";
    if (++shortages == 2) {
      close(taken.back());
      taken.pop_back();
    }
  });

  asio::ip::tcp::socket client(io);
  client.connect({asio::ip::address_v4::loopback(), listener.port()});
  const rlimit limit{64, 64};
  if (setrlimit(RLIMIT_NOFILE, &limit) != 0) std::_Exit(2);
  for (int copy = dup(0); copy >= 0; copy = dup(0)) taken.push_back(copy);
  if (errno != EMFILE || taken.empty()) std::_Exit(3);

  bool isAccepted = false;
  asio::co_spawn(
      io,
      [&]() -> Awaitable<> {
        const auto server = co_await listener.accept(steadyClock().now() + seconds(60));
        isAccepted = server != nullptr;
      },
      [](std::exception_ptr failure) {
        if (failure) std::_Exit(4);
      });
  io.run();
  std::cerr << shortages << " waits\n";
  std::_Exit(isAccepted && shortages == 2 ? 0 : 5);
}

TEST(TcpListenerDeathTest, WaitsForDescriptors) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(acceptWithoutDescriptors(), testing::ExitedWithCode(0), "no connection can be accepted .* Too many open files");
}

}  // namespace
}  // namespace warpscope::net
