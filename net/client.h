// The client's end of the network: connects, asks for the newest frame that is wanted, takes what comes, connects again when it breaks.
// Newest wins: while as many requests as agreed are under way, a newer request replaces the one that waits, so that no queue can build up.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "net/address.h"
#include "net/io_thread.h"
#include "net/link_settings.h"
#include "net/messages.h"
#include "net/times.h"

namespace boost::asio::ip {
class address;
}

namespace warpscope::net {

class Stream;

struct ClientSettings {
  Address address{};
  DuplexLinkSettings link{};  ///< simulated on top of the real one
  uint16_t depth = 1;       ///< requests under way at a time, brought into 1..kMaxDepth
  uint64_t maxFrameBytes = kMaxFrameBytes;           ///< brought into kLeastFrameHeadBytes..kMaxFrameBytes
  std::chrono::milliseconds connectPatience{10000};  ///< for connecting, TLS and the greetings; the simulated link's delay comes on top
  std::chrono::milliseconds firstPause{250};  ///< before connecting again; doubled until a connection is of use, by chance up to a half less
  std::chrono::milliseconds longestPause{8000};
  bool connectsAgain = true;
  /// Finds the addresses of the server's name, in a thread of its own (see lookup.h); the system's if there is none.
  std::function<std::vector<boost::asio::ip::address>(const std::string& host)> resolver{};
  /// If any, what is spoken over in place of TCP and TLS: a server in memory.
  std::function<std::unique_ptr<Stream>(boost::asio::io_context& context)> opener{};
};

enum class ConnectionPhase {
  connecting,
  connected,
  waiting,   ///< to connect again
  refused,   ///< for good: the server is another one, speaks otherwise, does not take the token or answers what it was not asked
};

struct ConnectionState {
  ConnectionPhase phase = ConnectionPhase::connecting;
  std::string sentence;           ///< what went wrong last; empty when connected
  TimePoint since;                ///< of the phase
  std::optional<TimePoint> next;  ///< when it is tried again
  int attempts = 0;               ///< since it was connected last
};

/// When a frame came.
struct FrameArrival {
  TimePoint requestedAt;  ///< when request() was called for it
  TimePoint sentAt;       ///< when its request was sent
  TimePoint beganAt;      ///< its head was there
  TimePoint arrivedAt;    ///< all of it was there
};

/// Whom a client tells. Called on the I/O thread, which waits meanwhile: take what comes and return, without throwing.
class ClientEvents {
 public:
  virtual ~ClientEvents() = default;
  virtual void onState(const ConnectionState& state) = 0;
  /// After each connecting.
  virtual void onScene(const SceneFields& scene) = 0;
  /// What is wrong with a frame of that head as an answer, with a payload of so many bytes; empty if nothing is. Asked when the head is there
  /// and nothing of the payload; camera, settings (but for those that admits() lets
  /// pass) and codec are known to be those of the request. What is wrong ends the connection for good.
  virtual std::string faultOf(const FrameHead& head, uint64_t payloadBytes) = 0;
  /// Whether a frame of settings that differ from those asked for is an answer nevertheless.
  virtual bool admits(const SettingFields& asked, const SettingFields& answered);
  virtual void onFrame(Frame frame, const FrameArrival& arrival) = 0;
  virtual void onFailure(const Failure& failure) = 0;
  /// A round trip of a heartbeat: one when connected, and one each of the server's intervals.
  virtual void onRoundTrip(Duration) {}
  /// The server works for so many other clients, while this one waits for an answer.
  virtual void onBusy(uint16_t) {}
  /// What the processes did that the server's volume is spread over, each for the last frame that it has said it of; before each frame.
  virtual void onProcesses(const std::vector<ProcessFields>&) {}
};

class Client {
 public:
  /// Begins to connect. `events` must outlive the client. Throws LinkSettingsError.
  Client(std::shared_ptr<IoThread> io, ClientSettings settings, ClientEvents& events);
  /// As close().
  ~Client();

  // Safe on any thread but the I/O thread's.

  /// Asks for a frame. Ids grow from 1 on; one that is not greater than those before is passed over. `sentAtNs` is filled in here. When
  /// the connection breaks, the newest that was not answered is asked again.
  void request(const FrameRequest& request);
  /// For what is sent from now on. Throws LinkSettingsError.
  void setLink(const DuplexLinkSettings& link);
  /// Brought into 1..kMaxDepth. For more than the connection began with, another one is made.
  void setDepth(uint16_t depth);
  /// Connects at once instead of waiting; nothing in any other phase.
  void connectNow();
  /// Ends the connection; nothing is told any more once it returns. Where there is one, the server learns that it ends on purpose: that
  /// takes a round trip, and up to a second with a server that does not answer. Calling it again does nothing.
  void close();

 private:
  struct State;
  const std::shared_ptr<IoThread> io_;
  std::shared_ptr<State> state_;
};

}  // namespace warpscope::net
