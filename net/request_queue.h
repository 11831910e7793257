// Who is served next: requests of many clients on a few rendering threads, the newest of each, one client after the other.
// Round robin (each client at most once a turn); nothing here grows with how often a client asks, or with how slowly it reads.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <list>
#include <mutex>
#include <optional>
#include <stop_token>
#include <vector>

#include "net/messages.h"
#include "net/times.h"

namespace warpscope::net {

/// Of one connection; never used again for another.
using ClientId = uint64_t;

struct RequestJob {
  ClientId client = 0;
  FrameRequest request;
  TimePoint arrivedAt;
  std::stop_token hasLeft;  ///< set when the client leaves: nobody waits for the answer any more
};

/// Bytes of answers that wait to be written to a client, from which on it gets no further ones.
inline constexpr size_t kMostWaitingBytes = size_t{32} << 20;

/// Safe on any thread.
class RequestQueue {
 public:
  /// `depth`: how many of the client's requests may be in work or on their way back at a time, and how many may wait besides.
  void join(ClientId client, uint16_t depth);
  /// Forgets the client's requests, and says so to who works on them; done() for those does nothing then.
  void leave(ClientId client);

  /// False if the id is not greater than the last one's, or there is no such client. Beyond `depth` waiting ones, the newest waiting one is
  /// replaced: it gets no answer.
  bool put(ClientId client, const FrameRequest& request, TimePoint arrivedAt);

  /// Waits for the next request; nothing if `stop` is set first. Of one client, one is given out at a time: until finished().
  std::optional<RequestJob> take(const std::stop_token& stop);
  /// Nobody works any more on the one that was taken: its answer is on its way, of so many bytes, or there will be none.
  void finished(ClientId client, size_t answerBytes);
  /// The answer to one that was finished has left, or never will.
  void done(ClientId client, size_t answerBytes);

  /// Whether anything that the client asked for is neither answered nor on its way.
  bool isAwaited(ClientId client) const;
  /// How many others wait for something, or have it made.
  size_t othersAwaited(ClientId client) const;
  size_t clientCount() const;
  /// Of the client, waiting.
  size_t waitingCount(ClientId client) const;

 private:
  struct Client {
    ClientId id;
    uint16_t depth;
    uint64_t lastId = 0;
    uint32_t atWork = 0;     // given out, and not done
    bool isWorkedFor = false;  // given out, and not finished
    size_t waitingBytes = 0;   // of answers
    std::deque<RequestJob> waiting;
    std::stop_source left;
  };
  using Clients = std::list<Client>;

  /// A thread that waits in take().
  struct Idle {
    std::condition_variable_any changed;
    bool isCalled = false;
  };

  Clients::iterator find(ClientId client);
  Clients::iterator next();
  /// Wakes one that waits, if there is something for it: all of them would cost as many wakings for each request as there are threads. The one that has waited least, whose caches are
  /// warm: the others may give back what they keep. With the mutex held.
  void callOne();
  static bool isAwaited(const Client& client) { return client.isWorkedFor || !client.waiting.empty(); }

  mutable std::mutex mutex_;
  std::vector<Idle*> idle_;  // not called yet, the last that came last
  Clients clients_;  // whoever was served goes to the end
};

}  // namespace warpscope::net
