// Frames from a server at the other end of a network: asks, takes what comes, decodes it in a thread of its own.
// The server may be this program's own: local and remote are one code path.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include "app/frames/frame_source.h"
#include "net/client.h"
#include "net/messages.h"
#include "render/core/backend.h"

namespace warpscope {

/// A source, and what the server shows.
struct Connected {
  std::unique_ptr<FrameSource> source;
  net::SceneFields scene;
};

/// Who chooses the transfer function of a scene.
enum class FunctionOwner { server, client };

/// Connects and waits for the server's scene. `onNews` is called on other threads after each answer and each change of the status. Throws
/// InputError with the reason if the server refuses or cannot be reached within settings.connectPatience, OperationCancelled if `stop` is
/// set. Afterwards the source connects again by itself. `backend`: what reads tiles that come; `place`: where they stay.
Connected connectFrameSource(std::shared_ptr<net::IoThread> io, net::ClientSettings settings, std::function<void()> onNews,
                             const std::stop_token& stop, FunctionOwner owner = FunctionOwner::server, Backend backend = Backend::cpu, DecodedPlace place = DecodedPlace::host);

}  // namespace warpscope
