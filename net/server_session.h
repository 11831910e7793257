// One client that a server has let in: reads its requests into the queue, writes the answers, and says that others are served first.
// One reader and one writer coroutine, on the I/O thread as everything here. Part of the server: see server.h.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>

#include "net/byte_budget.h"
#include "net/channel.h"
#include "net/held_bytes.h"
#include "net/reading.h"
#include "net/request_queue.h"

namespace warpscope::net {

/// What is on its way to a client.
struct Outgoing {
  std::optional<FrameHead> frame;  ///< if it is one, whose head is written when its turn comes
  HeldBytes bytes;                 ///< the payload, or the whole message
  Bytes processes{};               ///< of a frame: a message that goes first, for clients that can hear it; may be empty
  TimePoint readyAt;
  ByteBudget::SharePtr share{};    ///< of the memory for it; may be null
  size_t queuedBytes = 0;          ///< what the queue counts for it
};

struct SessionSettings {
  ClientId id = 0;
  uint16_t depth = 1;
  uint64_t maxFrameBytes = 0;
  uint32_t capabilities = 0;  ///< that both sides have
  Duration heartbeat{0}, patience{0};
  Duration firstMessagePatience{0};  ///< its first message comes a round trip after the welcome, of which nothing is known yet
};

class ServerSession : private FromClient {
 public:
  /// `queue` and `scene` (the message) outlive it.
  ServerSession(std::unique_ptr<Stream> stream, std::string network, const SessionSettings& settings, RequestQueue& queue, const Bytes& scene);

  /// Reads until the client leaves; throws what made it end otherwise.
  Awaitable<void> read() { return readClient(channel_, *this); }
  /// Writes until the session is closed; throws what made it end otherwise.
  Awaitable<void> write();
  void put(Outgoing outgoing);

  /// Ends both coroutines; null if that was the client's wish.
  void close(const std::exception_ptr& why);
  void writerBegins() { isWriting_ = true; }
  void writerEnds(const std::exception_ptr& why);
  Awaitable<void> untilWriterEnds();
  /// Known when both have ended.
  const Reason& reason() const { return reason_; }
  bool isClosed() const { return isClosed_; }

  /// TcpStream::network().
  const std::string& network() const { return network_; }
  /// When it last asked for something or was sent something.
  TimePoint lastOfUse() const { return lastOfUse_; }
  /// It waits for an answer, though not for all too long, or takes one at an honest pace.
  bool isInUse() const;
  /// Of answers that have not been written whole: their bytes, and how long the oldest of them waits.
  size_t waitingBytes() const { return waitingBytes_; }
  Duration longestWait() const;

 private:
  bool onRequest(const FrameRequest& request) override;
  void onPing(uint64_t number) override;

  Awaitable<void> send(const Outgoing& next);
  /// As small a message as says that it is too large for this client, or what it is.
  Outgoing fitting(Outgoing outgoing) const;
  TimePoint now() const { return channel_.clock().now(); }

  const std::string network_;
  const SessionSettings settings_;
  RequestQueue& queue_;
  const Bytes& scene_;
  Channel channel_;
  Signal wake_;  // the writer
  Signal writerEnd_;
  std::deque<Outgoing> outgoing_;  // the first is being written
  size_t waitingBytes_ = 0;
  TimePoint lastBusy_;  // when it was told of others, or when there was no need
  std::optional<uint64_t> pong_;
  uint64_t pings_ = 0;
  TimePoint lastOfUse_;
  TimePoint awaitedSince_;  // where it waits: since it asked, or was given the answer before
  bool isClosed_ = false;
  bool isWriting_ = false;
  Reason reason_;
};

}  // namespace warpscope::net
