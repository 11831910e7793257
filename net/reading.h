// What each side reads of the other, on any stream: the greeting, then the messages. Server and Client act on it.
// See messages.h. Nothing here waits longer than the stream's and the channel's deadlines, or allocates more than has arrived.
#pragma once

#include "net/channel.h"

namespace warpscope::net {

/// The other side's first bytes are not this protocol's.
class ForeignPeer : public ProtocolError {
 public:
  ForeignPeer(const std::string& peer, bool speaksTls)
      : ProtocolError(peer + (speaksTls ? " speaks TLS, which was not expected" : " does not speak warpscope's protocol")),
        speaksTls_(speaksTls) {}

  bool speaksTls() const { return speaksTls_; }

 private:
  bool speaksTls_;
};

/// An answer to something else than was asked: from a server that is not to be believed, nor asked again.
class WrongAnswer : public ProtocolError {
 public:
  explicit WrongAnswer(const std::string& fault) : ProtocolError("the server answered something else than it was asked: " + fault) {}
};

/// The other side's greeting. One of another version is read no further than its version, and nothing else in it counts. Throws
/// DeadlineExceeded, system_error, ForeignPeer, or ProtocolError for a damaged one.
Awaitable<ClientHello> receiveClientHello(Stream& stream, TimePoint deadline);
Awaitable<ServerHello> receiveServerHello(Stream& stream, TimePoint deadline);

/// What a server does with a client's messages.
class FromClient {
 public:
  virtual ~FromClient() = default;
  /// False if the id is not greater than the last one's, which ends the connection.
  virtual bool onRequest(const FrameRequest& request) = 0;
  virtual void onPing(uint64_t number) = 0;
};

/// Until the client ends the connection. Throws ProtocolError and whatever the channel throws.
Awaitable<void> readClient(Channel& channel, FromClient& to);

/// What a client does with a server's messages.
class FromServer {
 public:
  virtual ~FromServer() = default;
  /// What is wrong with a frame of that head, and a payload of so many bytes, as the next answer; if anything is, the connection ends before
  /// any of the payload is read. Empty if nothing is: then it comes next.
  virtual std::string faultOf(const FrameHead& head, uint64_t payloadBytes) = 0;
  /// The same for a failure.
  virtual std::string faultOf(const Failure& failure) = 0;
  virtual void onFrame(Frame frame, TimePoint beganAt) = 0;
  virtual void onFailure(const Failure& failure) = 0;
  virtual void onPing(uint64_t number) = 0;
  virtual void onPong(uint64_t number) = 0;
  virtual void onBusy(uint16_t others) = 0;
  virtual void onProcesses(std::vector<ProcessFields> processes) = 0;
};

/// The first message. Throws ProtocolError and whatever the channel throws.
Awaitable<SceneFields> readFirstScene(Channel& channel);
/// All the others, until the server ends the connection. Throws WrongAnswer, ProtocolError and whatever the channel throws.
Awaitable<void> readServer(Channel& channel, uint64_t maxFrameBytes, FromServer& to);

}  // namespace warpscope::net
