// Scenes with somebody who serves frames of them: this program, on a loopback socket, or a server somewhere else.
// What comes out holds everything that depends on the scene alone.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/frames/frame_source.h"
#include "app/frames/recorded_frame_source.h"
#include "app/scene/scene.h"
#include "net/client.h"
#include "render/march/marcher.h"

namespace warpscope {

/// Where a scene is from, so that it can be opened again.
struct SceneOrigin {
  std::string spec;          ///< a built-in scene, a file, or a server's URL without its token
  SceneOverrides overrides;
};

/// How a scene is to be shown when it has been opened; what is not said is the scene's own.
struct SceneArrangement {
  std::optional<View> view;
  std::optional<MarchSettings> march;
  std::optional<TransferFunction> transferFunction;
  std::vector<std::optional<View>> ownViews;  ///< of panels that have a camera of their own, by their places
};

struct ConnectedScene {
  Scene scene;            ///< without its volume where that is elsewhere
  FrameSourcePtr source;  ///< of frames
  MarcherPtr display{};   ///< of the reference and of techniques that march; apart from the server's, whose calls it would wait for
  SceneArrangement arrangement{};
  std::shared_ptr<RecordedFrameSource> recorded{};  ///< `source`, where frames are those of a recording; else null
  std::string whyNoTruth{};                         ///< why `display` marches nothing; empty where it does
};

/// Serves `scene` from this process, on a free port of the loopback address, and connects to it. `onNews`, `place`: as connectFrameSource's.
ConnectedScene hostScene(std::shared_ptr<net::IoThread> io, Scene scene, const MarcherPtr& marcher, const TransportSettings& transport,
                      std::function<void()> onNews, const std::stop_token& stop, DecodedPlace place = DecodedPlace::host);

/// The scene of a server elsewhere; `backend` reads tiles that come. Throws as connectFrameSource does.
ConnectedScene connectScene(std::shared_ptr<net::IoThread> io, const net::Address& address, const TransportSettings& transport,
                         std::function<void()> onNews, const std::stop_token& stop, Backend backend = Backend::cpu, DecodedPlace place = DecodedPlace::host);

/// What marches for frames that come as `transport` says, one after the other. See makeRemoteMarcher.
MarcherPtr connectMarcher(std::shared_ptr<net::IoThread> io, const net::Address& address, const TransportSettings& transport,
                          std::function<void(uint16_t)> onBusy, Backend backend = Backend::cpu);

}  // namespace warpscope
