// A marcher whose volume is at the other end of a network: what `reference` and headless commands use where the scene is a server's.
// Calls wait for the answer. One connection each; a call that the network interrupts is asked again by it.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "net/client.h"
#include "render/codec/codec.h"
#include "render/march/marcher.h"

namespace warpscope {

/// Connects when it is first called. march() and render() throw as Marcher's do, InputError also for what the server or
/// the network says, or if no connection stands for `patience`. Its volume is elsewhere, and its transfer function the server's. `onBusy`, if any, is called on the
/// network's thread with the number of others that the server works for while a call waits. `backend`: what reads tiles that come. `scene`: of which pictures are to be; else
/// it is the first that the server shows. Of a server that shows another one then nothing is taken any more.
MarcherPtr makeRemoteMarcher(std::shared_ptr<net::IoThread> io, net::ClientSettings settings, CodecSettings codec,
                             Clock::Duration patience, std::function<void(uint16_t)> onBusy = {}, Backend backend = Backend::cpu,
                             std::optional<net::SceneFields> scene = {});

}  // namespace warpscope
