// Scenes with somebody who serves frames of them: this program, on a loopback socket, or a server somewhere else.
// What comes out holds everything that depends on the scene alone.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include "app/frames/frame_source.h"
#include "app/scene/scene.h"
#include "net/client.h"
#include "render/march/marcher.h"

namespace warpscope {

struct ConnectedScene {
  Scene scene;            ///< without its volume where that is elsewhere
  FrameSourcePtr source;  ///< of frames
  MarcherPtr display;     ///< of the reference and of techniques that march; apart from the server's, whose calls it would wait for
};

/// Serves `scene` from this process, on a free port of the loopback address, and connects to it. `onNews`: as connectFrameSource's.
ConnectedScene hostScene(std::shared_ptr<net::IoThread> io, Scene scene, const MarcherPtr& marcher, const TransportSettings& transport,
                      std::function<void()> onNews, const std::stop_token& stop);

/// The scene of a server elsewhere. Throws as connectFrameSource does.
ConnectedScene connectScene(std::shared_ptr<net::IoThread> io, const net::Address& address, const TransportSettings& transport,
                         std::function<void()> onNews, const std::stop_token& stop);

/// What marches for frames that come as `transport` says, one after the other. See makeRemoteMarcher.
MarcherPtr connectMarcher(std::shared_ptr<net::IoThread> io, const net::Address& address, const TransportSettings& transport,
                          std::function<void(uint16_t)> onBusy);

}  // namespace warpscope
