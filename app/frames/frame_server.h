// The program's server: one scene, one rendering thread, as many clients as the network lets in.
// Marches what clients ask for, newest first and in turns, and sends it encoded as each of them wants it.
#pragma once

#include <memory>
#include <thread>

#include "app/scene/scene.h"
#include "net/server.h"
#include "render/march/marcher.h"

namespace warpscope {

class FrameServer {
 public:
  /// Serves `scene`, which `marcher` marches. `settings.scene` is filled in here. Throws as net::Server does.
  FrameServer(std::shared_ptr<net::IoThread> io, const Scene& scene, MarcherPtr marcher, net::ServerSettings settings);
  /// Ends all connections and waits for the march at work, which stops early.
  ~FrameServer();

  net::Address address() const { return server_.address(); }
  uint16_t port() const { return server_.port(); }

  /// Asks the rendering thread to end, without waiting for it.
  void requestStop() { thread_.request_stop(); }

 private:
  void run(const std::stop_token& stop);

  const MarcherPtr marcher_;
  Clock& clock_;  // of the I/O thread
  net::Server server_;
  std::jthread thread_;
};

}  // namespace warpscope
