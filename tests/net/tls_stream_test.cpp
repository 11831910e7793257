// TLS: who is let in, who is not and why, and that neither silence nor truncation goes unnoticed.
// Mirrors net/tls_stream.h.
#include "net/tls_stream.h"

#include <unistd.h>

#include <array>

#include "tests/net/io_test.h"

namespace warpscope::net {
namespace {

namespace ssl = asio::ssl;
using testing::HasSubstr;
using testing::StartsWith;

class TlsStreamTest : public IoTest {
 protected:
  struct TlsPair {
    std::unique_ptr<TlsStream> client, server;
  };

  /// Both sides of the handshake at once, with what each of them throws.
  TlsPair shakeHands(const Fingerprint& expected) {
    Pair tcp;
    run([&]() -> Awaitable<> { tcp = co_await connectedPair(); });
    TlsPair made;
    clientFailure_ = serverFailure_ = {};
    spawn([&]() -> Awaitable<> { serverFailure_ = co_await failureOf(accept(std::move(tcp.server), made.server)); });
    spawn([&]() -> Awaitable<> { clientFailure_ = co_await failureOf(open(std::move(tcp.client), expected, made.client)); });
    run();
    return made;
  }
  TlsPair shakeHands() {
    TlsPair pair = shakeHands(identity_.fingerprint);
    EXPECT_EQ(clientFailure_.text, "");
    EXPECT_EQ(serverFailure_.text, "");
    return pair;
  }

  Awaitable<void> accept(std::unique_ptr<TcpStream> tcp, std::unique_ptr<TlsStream>& stream) {
    stream = co_await acceptTls(std::move(tcp), context_, never());
  }
  Awaitable<void> open(std::unique_ptr<TcpStream> tcp, Fingerprint expected, std::unique_ptr<TlsStream>& stream) {
    try {
      stream = co_await openTls(std::move(tcp), expected, never());
    } catch (const FingerprintMismatch&) {
      isMismatch_ = true;
      throw;
    }
  }

  const Identity identity_ = makeIdentity();
  const TlsStream::Context context_ = makeServerContext(identity_);
  Thrown clientFailure_, serverFailure_;
  bool isMismatch_ = false;
};

TEST_F(TlsStreamTest, BytesTravelBothWaysAtOnce) {
  const std::string sent = pattern(2'000'000);
  TlsPair pair = shakeHands();
  EXPECT_EQ(pair.client->version(), "TLSv1.3");
  EXPECT_EQ(pair.server->version(), "TLSv1.3");
  std::array<std::string, 2> got;
  spawn([&]() -> Awaitable<> { co_await writeText(*pair.client, sent); });
  spawn([&]() -> Awaitable<> { co_await writeText(*pair.server, sent); });
  spawn([&]() -> Awaitable<> { got[0] = co_await readText(*pair.client, sent.size()); });
  spawn([&]() -> Awaitable<> { got[1] = co_await readText(*pair.server, sent.size()); });
  run();
  EXPECT_TRUE(got[0] == sent);
  EXPECT_TRUE(got[1] == sent);
}

TEST_F(TlsStreamTest, AnotherFingerprintIsRefused) {
  for (const size_t byte : {size_t{0}, size_t{31}}) {
    Fingerprint wrong = identity_.fingerprint;
    wrong[byte] ^= 1;
    const TlsPair pair = shakeHands(wrong);
    EXPECT_TRUE(std::exchange(isMismatch_, false));
    EXPECT_EQ(pair.client, nullptr);
    EXPECT_EQ(pair.server, nullptr) << "the server is told";
    EXPECT_THAT(clientFailure_.text, HasSubstr("is not the one that the address is for"));
    EXPECT_THAT(clientFailure_.text, HasSubstr(fingerprintText(identity_.fingerprint) + ", not " + fingerprintText(wrong)));
    EXPECT_THAT(serverFailure_.text, StartsWith("TLS handshake with 127.0.0.1:"));
  }
}

TEST_F(TlsStreamTest, OldVersionsAreRefused) {
  Pair tcp;
  run([&]() -> Awaitable<> { tcp = co_await connectedPair(); });
  auto context = std::make_shared<ssl::context>(ssl::context::tls_client);
  SSL_CTX_set_security_level(context->native_handle(), 0);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_VERSION);
  SSL_CTX_set_max_proto_version(context->native_handle(), TLS1_1_VERSION);
  ssl::stream<asio::ip::tcp::socket&> client(tcp.client->socket(), *context);
  std::unique_ptr<TlsStream> server;
  error_code error;
  spawn([&]() -> Awaitable<> { serverFailure_ = co_await failureOf(accept(std::move(tcp.server), server)); });
  spawn([&]() -> Awaitable<> { co_await client.async_handshake(ssl::stream_base::client, into(error)); });
  run();
  EXPECT_TRUE(error);
  EXPECT_THAT(serverFailure_.text, HasSubstr("unsupported protocol"));
}

TEST_F(TlsStreamTest, PeersThatDoNotSpeakTlsAreToldApart) {
  for (const std::string& said : {std::string("GET / HTTP/1.1\r\nHost: h\r\n\r\n"), std::string("WARP hello, this is no TLS at all"),
                                  std::string(100, '\0'), std::string(20000, '\xff')}) {
    run([&]() -> Awaitable<> {
      Pair tcp = co_await connectedPair();
      co_await writeText(*tcp.client, said);
      std::unique_ptr<TlsStream> stream;
      const Thrown server = co_await failureOf(accept(std::move(tcp.server), stream));
      EXPECT_THAT(server.text, HasSubstr(": the peer does not speak TLS: "));

      tcp = co_await connectedPair();
      co_await writeText(*tcp.server, said);
      const Thrown client = co_await failureOf(open(std::move(tcp.client), identity_.fingerprint, stream));
      EXPECT_THAT(client.text, HasSubstr(": the peer does not speak TLS: "));
      EXPECT_FALSE(isMismatch_);
    });
  }
}

TEST_F(TlsStreamTest, GarbageInsideTheHandshakeIsAnError) {
  // A record of the right form with a handshake message that is none.
  const std::string said("\x16\x03\x01\x00\x08\x01\x00\x00\x04\xff\xff\xff\xff", 13);
  run([&]() -> Awaitable<> {
    Pair tcp = co_await connectedPair();
    co_await writeText(*tcp.client, said);
    std::unique_ptr<TlsStream> stream;
    const Thrown failure = co_await failureOf(accept(std::move(tcp.server), stream));
    EXPECT_THAT(failure.text, StartsWith("TLS handshake with 127.0.0.1:"));
  });
}

TEST_F(TlsStreamTest, APeerThatLeavesInTheHandshakeIsAnError) {
  run([&]() -> Awaitable<> {
    Pair tcp = co_await connectedPair();
    tcp.client->close();
    std::unique_ptr<TlsStream> stream;
    const Thrown failure = co_await failureOf(accept(std::move(tcp.server), stream));
    EXPECT_THAT(failure.text, StartsWith("TLS handshake with 127.0.0.1:"));
    EXPECT_FALSE(failure.isDeadline);
  });
}

TEST_F(TlsStreamTest, GarbageAfterTheHandshakeIsAnError) {
  Pair tcp;
  run([&]() -> Awaitable<> { tcp = co_await connectedPair(); });
  asio::ip::tcp::socket below(io_, asio::ip::tcp::v4(), dup(tcp.client->socket().native_handle()));
  TlsPair pair;
  spawn([&]() -> Awaitable<> { co_await accept(std::move(tcp.server), pair.server); });
  spawn([&]() -> Awaitable<> { co_await open(std::move(tcp.client), identity_.fingerprint, pair.client); });
  run();
  run([&]() -> Awaitable<> {
    const std::string record("\x17\x03\x03\x00\x20", 5);
    co_await asio::async_write(below, asio::buffer(record + std::string(32, 'x')), asio::use_awaitable);
    const Thrown failure = co_await failureOf(readText(*pair.server, 1));
    EXPECT_THAT(failure.text, HasSubstr("reading from 127.0.0.1:"));
    EXPECT_NE(failure.code, asio::error::eof);
  });
}

TEST_F(TlsStreamTest, SilenceInTheHandshakeEndsAtTheDeadline) {
  run([&]() -> Awaitable<> {
    Pair tcp = co_await connectedPair();
    Pair other = co_await connectedPair();
    Thrown server, client;
    spawn([&]() -> Awaitable<> { server = co_await failureOf(acceptTls(std::move(tcp.server), context_, inTime(milliseconds(30)))); });
    spawn([&]() -> Awaitable<> {
      client = co_await failureOf(openTls(std::move(other.client), identity_.fingerprint, inTime(milliseconds(30))));
    });
    co_await pass(milliseconds(29));
    EXPECT_EQ(server.text + client.text, "") << "not before their time";
    co_await pass(milliseconds(1));
    EXPECT_TRUE(server.isDeadline);
    EXPECT_THAT(server.text, StartsWith("TLS handshake with 127.0.0.1:"));
    EXPECT_TRUE(client.isDeadline);
  });
}

TEST_F(TlsStreamTest, APeerThatNeverReadsEndsAtTheDeadline) {
  TlsPair pair = shakeHands();
  run([&]() -> Awaitable<> {
    Thrown failure;
    spawn([&]() -> Awaitable<> {
      failure = co_await failureOf(
          withDeadline(*pair.client, inTime(milliseconds(50)), "sending", writeText(*pair.client, std::string(64 << 20, 'x'))));
    });
    co_await pass(milliseconds(50));
    EXPECT_TRUE(failure.isDeadline);
  });
}

TEST_F(TlsStreamTest, FinishingIsACleanEndAndLosesNothing) {
  const std::string sent = pattern(500'000);
  TlsPair pair = shakeHands();
  std::string got;
  spawn([&]() -> Awaitable<> {
    co_await writeText(*pair.client, sent);
    co_await pair.client->finish(never());
  });
  spawn([&]() -> Awaitable<> {
    co_await pass(milliseconds(10));
    got = co_await readToEnd(*pair.server);
    co_await pair.server->finish(never());
  });
  run();
  EXPECT_TRUE(got == sent);
}

TEST_F(TlsStreamTest, FinishingWhileAReaderWaits) {
  TlsPair pair = shakeHands();
  size_t atClient = 1, atServer = 1;
  Thrown failure;
  spawn([&]() -> Awaitable<> {
    std::array<char, 5> buffer;
    try {
      atClient = co_await pair.client->readSome(asio::buffer(buffer));
    } catch (const system_error& error) {
      EXPECT_EQ(error.code(), asio::error::operation_aborted);
      atClient = 0;
    }
  });
  spawn([&]() -> Awaitable<> {
    co_await pass(milliseconds(5));
    co_await pair.client->finish(never());
  });
  spawn([&]() -> Awaitable<> {
    std::array<char, 5> buffer;
    atServer = co_await pair.server->readSome(asio::buffer(buffer));
    co_await pair.server->finish(never());
  });
  run();
  EXPECT_EQ(atClient, 0u);
  EXPECT_EQ(atServer, 0u);
}

TEST_F(TlsStreamTest, FinishingDoesNotWaitBeyondItsDeadline) {
  TlsPair pair = shakeHands();
  bool hasFinished = false;
  spawn([&]() -> Awaitable<> {
    co_await pair.client->finish(inTime(milliseconds(30)));
    hasFinished = true;
  });
  run([&]() -> Awaitable<> {
    co_await pass(milliseconds(29));
    EXPECT_FALSE(hasFinished);
    co_await pass(milliseconds(1));
    EXPECT_TRUE(hasFinished);
  });
}

TEST_F(TlsStreamTest, ATruncatedMessageIsAnError) {
  TlsPair pair = shakeHands();
  run([&]() -> Awaitable<> {
    co_await writeText(*pair.client, "abc");
    pair.client->close();  // the connection ends, without TLS's farewell
    std::array<char, 5> buffer;
    const Thrown failure = co_await failureOf(readExactly(*pair.server, asio::buffer(buffer)));
    EXPECT_EQ(failure.code, ssl::error::stream_truncated);
    EXPECT_THAT(failure.text, HasSubstr("stream truncated"));
  });
}

TEST_F(TlsStreamTest, ATruncationBetweenMessagesIsAnErrorToo) {
  TlsPair pair = shakeHands();
  run([&]() -> Awaitable<> {
    pair.client->close();
    std::array<char, 5> buffer;
    const Thrown failure = co_await failureOf(readExactlyOrEnd(*pair.server, asio::buffer(buffer)));
    EXPECT_EQ(failure.code, ssl::error::stream_truncated);
  });
}

TEST_F(TlsStreamTest, AnAbortIsAnErrorAtThePeer) {
  TlsPair pair = shakeHands();
  run([&]() -> Awaitable<> {
    pair.client->abort();
    std::array<char, 5> buffer;
    const Thrown failure = co_await failureOf(pair.server->readSome(asio::buffer(buffer)));
    EXPECT_EQ(failure.code, asio::error::connection_reset);
  });
}

TEST_F(TlsStreamTest, ClosingEndsWhatIsUnderWay) {
  TlsPair pair = shakeHands();
  Thrown read, write;
  spawn([&]() -> Awaitable<> { read = co_await failureOf(readText(*pair.client, 1)); });
  spawn([&]() -> Awaitable<> { write = co_await failureOf(writeText(*pair.client, std::string(64 << 20, 'x'))); });
  spawn([&]() -> Awaitable<> {
    co_await pass(milliseconds(20));
    pair.client->close();
    pair.client->close();
  });
  run();
  EXPECT_EQ(read.code, asio::error::operation_aborted);
  EXPECT_EQ(write.code, asio::error::operation_aborted);
}

}  // namespace
}  // namespace warpscope::net
