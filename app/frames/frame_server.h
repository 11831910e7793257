// The program's server: one scene, a thread for each client that waits, as many clients as the network lets in.
// Marches what clients ask for, newest first and in turns, and sends it encoded as each of them wants it. No request takes more of the
// machine than it may: marches take turns of some milliseconds (turns.h), memory is handed out (byte_budget.h). What serves its own process works on
// threads that let that one's go first (crew.h).
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "app/frames/server_pace.h"
#include "app/scene/scene.h"
#include "net/byte_budget.h"
#include "net/server.h"
#include "render/bricks/brick_frame.h"
#include "render/core/crew.h"
#include "render/march/marcher.h"

namespace warpscope {

/// What strangers' requests may take. Without them, a server works for its own process, whose display goes first.
struct ServeLimits {
  std::chrono::nanoseconds work = std::chrono::seconds(60);  ///< of marching, for one request; waiting for turns does not count
  size_t memoryBytes = defaultMemoryBytes();                 ///< of frames from their march until they are sent, in all; see ByteBudget

  /// Half of the machine's, at most 8 GiB.
  static size_t defaultMemoryBytes();
};

/// Memory that a request takes at the most, from its march to its encoded bytes.
size_t memoryFor(const Camera& camera, const MarchSettings& settings, net::Wanted wanted);

class FrameServer {
 public:
  /// What processes did that march together, for the last frame of which that is known.
  using Processes = std::function<std::vector<RankWork>()>;

  /// Serves `scene`, which `marcher` marches. `settings.scene` is filled in here. `processes`: where there are any. Throws as net::Server does.
  FrameServer(std::shared_ptr<net::IoThread> io, const Scene& scene, MarcherPtr marcher, net::ServerSettings settings,
              std::optional<ServeLimits> limits = {}, Processes processes = {});
  /// Ends all connections and waits for the marches at work, which stop early.
  ~FrameServer();

  net::Address address() const { return server_.address(); }
  uint16_t port() const { return server_.port(); }

  /// What is marched from now on is seen by that function; marches at work end by the one before. On any thread. Throws UsageError where the marcher refuses it.
  void setTransferFunction(TransferFunction function);

  /// Asks the rendering threads to end, without waiting for them.
  void requestStop() { stop_.request_stop(); }

 private:
  class Lane;
  struct Answer;

  void end();
  void startLane();
  void run(Lane& lane);
  void keepHouse();
  void answer(const net::RequestJob& job, Lane& lane);
  Answer answerTo(const net::RequestJob& job, Lane& lane, const std::stop_token& stop);
  std::shared_ptr<ServerPace> paceOf(const net::RequestJob& job);
  net::ByteBudget::SharePtr memoryOf(const Camera& camera, size_t bytes, const std::stop_token& stop);

  MarcherPtr marcher() const;

  Clock& clock_;  // of the I/O thread
  const TurnsPtr turns_;  // null without limits
  const std::unique_ptr<net::ByteBudget> budget_;  // likewise
  const std::unique_ptr<Crew> crew_;               // null with limits
  net::Server server_;
  const size_t mostLanes_;
  const Processes processes_;
  std::stop_source stop_;
  mutable std::mutex mutex_;  // of the following
  MarcherPtr marcher_;        // whose twins lanes march with
  std::vector<std::shared_ptr<Lane>> lanes_;  // shared with who keeps house
  std::vector<std::thread> threads_;  // of the lanes, and the one that keeps house
  struct PaceOfClient {
    std::stop_token hasLeft;
    std::shared_ptr<ServerPace> pace;  // of whoever works for that client, one at a time
  };
  std::map<net::ClientId, PaceOfClient> paces_;  // of those that asked for one
  size_t idle_ = 0;
  bool isEnding_ = false;
};

}  // namespace warpscope
