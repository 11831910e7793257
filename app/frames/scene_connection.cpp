// A server and its client in one process, or a client alone.
// See scene_connection.h.
#include "app/frames/scene_connection.h"

#include "app/frames/frame_server.h"
#include "app/frames/remote_frame_source.h"
#include "app/frames/remote_marcher.h"
#include "app/frames/wire_fields.h"
#include "app/shell/log.h"

namespace warpscope {
namespace {

net::ClientSettings clientSettings(const net::Address& address, const TransportSettings& transport) {
  net::ClientSettings settings;
  settings.address = address;
  settings.link = transport.link;
  settings.depth = static_cast<uint16_t>(transport.depth);
  // What the link simulates comes on top of what connecting takes.
  settings.connectPatience += std::chrono::milliseconds(static_cast<int64_t>(8.0 * (transport.link.up.delayMs + transport.link.down.delayMs)));
  return settings;
}

/// A source with the server that it is connected to.
class HostedSource final : public FrameSource {
 public:
  HostedSource(std::unique_ptr<FrameServer> server, std::unique_ptr<FrameSource> source)
      : server_(std::move(server)), source_(std::move(source)) {}

  void post(const FrameRequest& request, Clock::TimePoint now) override { source_->post(request, now); }
  std::optional<ServedFrame> tryTake() override { return source_->tryTake(); }
  void setTransport(const TransportSettings& transport) override { source_->setTransport(transport); }
  bool setTransferFunction(const TransferFunction& function, uint64_t version) override {
    server_->setTransferFunction(function);
    return source_->setTransferFunction(function, version);
  }
  SourceStatus status() const override { return source_->status(); }
  void requestStop() override {
    server_->requestStop();
    source_->requestStop();
  }

 private:
  const std::unique_ptr<FrameServer> server_;
  const std::unique_ptr<FrameSource> source_;  // goes first
};

}  // namespace

ConnectedScene hostScene(std::shared_ptr<net::IoThread> io, Scene scene, const MarcherPtr& marcher, const TransportSettings& transport,
                      std::function<void()> onNews, const std::stop_token& stop, DecodedPlace place) {
  net::ServerSettings settings;
  settings.clients = {.most = 1, .mostOfAnAddress = 1, .leastIdleness = net::Duration::max()};  // strangers do not take its place
  settings.onNote = [](const std::string& text) { logDetail("the program's own server: " + text); };
  auto server = std::make_unique<FrameServer>(io, scene, marcher, settings);
  Connected connected = connectFrameSource(io, clientSettings(server->address(), transport), std::move(onNews), stop, FunctionOwner::client, marcher->backend(), place);
  connected.source->setTransport(transport);
  return {std::move(scene), std::make_shared<HostedSource>(std::move(server), std::move(connected.source)), marcher->twin(), {}};
}

ConnectedScene connectScene(std::shared_ptr<net::IoThread> io, const net::Address& address, const TransportSettings& transport,
                         std::function<void()> onNews, const std::stop_token& stop, Backend backend, DecodedPlace place) {
  Connected connected = connectFrameSource(io, clientSettings(address, transport), std::move(onNews), stop, FunctionOwner::server, backend, place);
  connected.source->setTransport(transport);
  Scene scene = sceneFrom(connected.scene);
  // Ground truth comes as it is, without what is simulated for frames, over a connection of its own. However long that is broken, it is
  // waited for: the source says what is going on, and what is no longer wanted is cancelled.
  constexpr std::chrono::hours kLongerThanAnybodyWaits(24 * 365);
  return {std::move(scene), std::move(connected.source),
          makeRemoteMarcher(io, clientSettings(address, {}), transport.codec, kLongerThanAnybodyWaits, {}, backend, connected.scene),
          {}};
}

MarcherPtr connectMarcher(std::shared_ptr<net::IoThread> io, const net::Address& address,
                          const TransportSettings& transport, std::function<void(uint16_t)> onBusy, Backend backend) {
  const net::ClientSettings settings = clientSettings(address, transport);
  return makeRemoteMarcher(std::move(io), settings, transport.codec, settings.connectPatience, std::move(onBusy), backend);
}

}  // namespace warpscope
