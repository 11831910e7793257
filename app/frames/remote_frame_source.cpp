// From the network's thread to the decoder's to whoever takes the frame.
// See remote_frame_source.h.
#include "app/frames/remote_frame_source.h"

#include <map>
#include <mutex>
#include <stop_token>

#include "app/frames/asked_requests.h"
#include "app/frames/backend.h"
#include "app/frames/wire_fields.h"
#include "net/address.h"
#include "render/base/error.h"
#include "render/base/newest_worker.h"
#include "render/base/stopwatch.h"
#include "render/core/crew_work.h"

namespace warpscope {
namespace {

constexpr size_t kMostWanted = 1024;  // requests that are remembered

/// What came for one request: a frame to decode, or why there is none.
struct Arrived {
  std::shared_ptr<const net::Frame> frame;
  net::FrameArrival arrival;
  net::Failure failure;
};

class RemoteFrameSource final : public FrameSource, private net::ClientEvents {
 public:
  RemoteFrameSource(std::shared_ptr<net::IoThread> io, const net::ClientSettings& settings, FunctionOwner owner,
                    std::function<void()> onNews, Backend backend, DecodedPlace place)
      : owner_(owner),
        place_(place),
        onNews_(std::move(onNews)),
        clock_(io->clock()),
        where_(net::toString(settings.address.where)),
        transport_{.link = settings.link, .codec = {}, .depth = settings.depth},
        status_{.isConnected = false, .isRefused = false, .sentence = {}, .next = {}, .where = where_},
        decoder_(
            // Decoding must not wait for marches.
            workOfCrew(
                [this, backend]() -> NewestWorker<Arrived, ServedFrame>::Work {
                  return [this, codec = std::make_shared<FrameCodec>(makeTiledCoder(backend))](const Arrived& arrived, ServedFrame& served, const std::stop_token&) {
                    decode(arrived, served, *codec);
                  };
                },
                ownCrewBesideThisThreads(Crew::kOfPictures), Crew::kOfPictures),
            onNews_),
        client_(std::move(io), settings, *this) {}  // which may tell of a connection before this ends

  /// Waits until there is a scene or it is known that there will be none.
  net::SceneFields waitForScene(std::chrono::milliseconds patience, const std::stop_token& stop) {
    const std::stop_callback onStop(stop, [this] { decided_.request_stop(); });
    clock_.waitUntil(clock_.now() + patience, decided_.get_token());
    const std::scoped_lock lock(mutex_);
    if (scene_) return *scene_;
    if (stop.stop_requested()) throw WaitCancelled(status_.isConnected ? "" : status_.sentence);
    if (!status_.sentence.empty()) throw InputError(status_.sentence);
    throw InputError(where_ + " does not answer");
  }

  void post(const FrameRequest& request, Clock::TimePoint) override {
    net::FrameRequest asked;
    asked.id = request.id;
    asked.camera = toFields(request.camera);
    {
      const std::scoped_lock lock(mutex_);
      MarchSettings settings = request.settings;
      wanted_[request.id] = {settings.sample.proxy, functionVersion_};
      forgetReplaced(wanted_, kMostWanted);
      if (proxy_ && proxyLongest_ == settings.sample.proxy) settings.sample.proxy = 0;  // it is here already
      asked.settings = toFields(settings, transport_.server);
      asked.codec = toFields(transport_.codec);
    }
    client_.request(asked);
  }
  std::optional<ServedFrame> tryTake() override { return decoder_.tryTake(); }

  void setTransport(const TransportSettings& transport) override {
    TransportSettings before;
    {
      const std::scoped_lock lock(mutex_);
      before = std::exchange(transport_, transport);
    }
    if (before.link != transport.link) client_.setLink(transport.link);
    if (before.depth != transport.depth) client_.setDepth(static_cast<uint16_t>(transport.depth));
  }
  bool setTransferFunction(const TransferFunction& function, uint64_t version) override {
    if (owner_ == FunctionOwner::server) return false;
    const std::scoped_lock lock(mutex_);
    function_ = function;
    functionVersion_ = version;
    if (proxy_) proxy_ = classified(*proxy_);
    return true;
  }
  SourceStatus status() const override {
    const std::scoped_lock lock(mutex_);
    return status_;
  }
  void requestStop() override { decoder_.requestStop(); }

 private:
  void onState(const net::ConnectionState& state) override {
    {
      const std::scoped_lock lock(mutex_);
      status_.isConnected = state.phase == net::ConnectionPhase::connected;
      status_.isRefused = state.phase == net::ConnectionPhase::refused;
      if (status_.isConnected) status_.sentence.clear();
      if (!state.sentence.empty()) status_.sentence = state.sentence;  // stays on show while it is tried again
      status_.next = state.next;
      if (!status_.isConnected) status_.busyWith.reset(), status_.processes.clear();
    }
    if (state.phase == net::ConnectionPhase::refused) decided_.request_stop();
    onNews_();
  }
  void onScene(const net::SceneFields& scene) override {
    {
      const std::scoped_lock lock(mutex_);
      // Frames of another scene would be shown with this one's cameras: who wants that one connects anew.
      isOtherScene_ = scene_ && *scene_ != scene;
      if (!scene_) scene_ = scene;
    }
    decided_.request_stop();
  }
  std::string faultOf(const net::FrameHead& head, uint64_t payloadBytes) override {
    return warpscope::faultOf(head, payloadBytes);
  }
  bool admits(const net::SettingFields& asked, const net::SettingFields& answered) override { return warpscope::admits(asked, answered); }
  void onFrame(net::Frame frame, const net::FrameArrival& arrival) override {
    noteAnswer();
    if (isOtherScene()) {
      onFailure({frame.head.id, where_ + " shows another scene now: connect anew to see it"});
      return;
    }
    decoder_.post({std::make_shared<const net::Frame>(std::move(frame)), arrival, {}});
  }
  void onFailure(const net::Failure& failure) override {
    noteAnswer();
    decoder_.post({nullptr, {}, failure});
  }
  void onBusy(uint16_t others) override {
    {
      const std::scoped_lock lock(mutex_);
      if (std::exchange(status_.busyWith, others) == others) return;
    }
    onNews_();
  }
  void onProcesses(const std::vector<net::ProcessFields>& processes) override {
    const std::scoped_lock lock(mutex_);
    status_.processes = processes;
  }
  void onRoundTrip(net::Duration roundTrip) override {
    const std::scoped_lock lock(mutex_);
    status_.roundTripMs = std::chrono::duration<double, std::milli>(roundTrip).count();
  }

  /// The same copy by the function that was chosen here.
  ProxyPtr classified(const Proxy& proxy) const {
    auto changed = std::make_shared<Proxy>(proxy);
    changed->function = *function_;
    return changed;
  }

  /// The copy of the volume comes once, and goes with every frame that was to have it from then on: the same object, also where more than one came because
  /// several were asked for before the first was here.
  void completeFrame(uint64_t requestId, SampleFrame& frame) {
    const std::scoped_lock lock(mutex_);
    const auto asked = wanted_.find(requestId);
    if (asked != wanted_.end()) frame.functionVersion = asked->second.functionVersion;
    const int longest = frame.proxy ? frame.settings.sample.proxy : asked != wanted_.end() ? asked->second.longest : 0;
    if (frame.proxy && proxyLongest_ != longest) {
      proxy_ = function_ ? classified(*frame.proxy) : frame.proxy;
      proxyLongest_ = longest;
    }
    if (!proxy_ || proxyLongest_ != longest) return;
    frame.proxy = proxy_;
    frame.settings.sample.proxy = longest;
  }
  /// No answer to this request or to one before is awaited any more.
  void forgetRequestsUpTo(uint64_t id) {
    const std::scoped_lock lock(mutex_);
    wanted_.erase(wanted_.begin(), wanted_.upper_bound(id));
  }

  void noteAnswer() {
    const std::scoped_lock lock(mutex_);
    status_.busyWith.reset();
  }
  /// Of the scene that frames are of.
  VolumeGeometry geometry() const {
    const std::scoped_lock lock(mutex_);
    return scene_ ? geometryFrom(*scene_) : VolumeGeometry{};
  }
  bool isOtherScene() const {
    const std::scoped_lock lock(mutex_);
    return isOtherScene_;
  }

  void decode(const Arrived& arrived, ServedFrame& served, FrameCodec& codec) {
    if (!arrived.frame) {
      served.requestId = arrived.failure.id;
      served.arrivedAt = clock_.now();
      served.error = arrived.failure.sentence;
      forgetRequestsUpTo(served.requestId);
      return;
    }
    const net::FrameHead& head = arrived.frame->head;
    served.requestId = head.id;
    served.requestedAt = arrived.arrival.requestedAt;
    auto frame = std::make_shared<SampleFrame>();
    const double decodeMs = milliseconds([&] { *frame = decodedFrom(head, arrived.frame->payload, codec, place_); });
    served.bytes = codec.bytes();
    completeFrame(head.id, *frame);
    forgetRequestsUpTo(head.id);
    frame->geometry = geometry();
    FrameLatency& latency = served.latency;
    latency = latencyOf(frame->timings);
    latency.decodeMs = decodeMs;
    const net::StageTimes& stages = head.stages;
    latency.waitMs = millisecondsBetween(arrived.arrival.requestedAt, arrived.arrival.sentAt);
    latency.queueMs = stages.queueMs;
    latency.encodeMs = stages.encodeMs;
    const double atServerMs = stages.queueMs + stages.marchMs + stages.compactMs + stages.copyMs + stages.encodeMs;
    latency.wireMs = std::max(0.0, millisecondsBetween(arrived.arrival.sentAt, arrived.arrival.arrivedAt) - atServerMs);
    served.frame = std::move(frame);
    served.arrivedAt = clock_.now();
  }

  const FunctionOwner owner_;
  const DecodedPlace place_;
  const std::function<void()> onNews_;
  Clock& clock_;  // of the I/O thread
  const std::string where_;
  mutable std::mutex mutex_;  // of all before the decoder
  TransportSettings transport_;
  SourceStatus status_;
  std::optional<net::SceneFields> scene_;
  bool isOtherScene_ = false;
  ProxyPtr proxy_;  // that came last; null: none
  int proxyLongest_ = 0;  // of that; 0: none
  struct Wanted {
    int longest = 0;  // of the copy
    uint64_t functionVersion = 0;
  };
  std::map<uint64_t, Wanted> wanted_;  // by request
  std::optional<TransferFunction> function_;  // that was chosen here
  uint64_t functionVersion_ = 0;
  std::stop_source decided_;  // asked to stop once there is a scene, or will be none, or nobody waits for it
  NewestWorker<Arrived, ServedFrame> decoder_;
  net::Client client_;  // last: it tells all of the above
};

}  // namespace

std::string busySentence(uint16_t others) {
  return "the server is busy with " + std::to_string(others) + (others == 1 ? " other" : " others");
}

Connected connectFrameSource(std::shared_ptr<net::IoThread> io, net::ClientSettings settings, std::function<void()> onNews,
                             const std::stop_token& stop, FunctionOwner owner, Backend backend, DecodedPlace place) {
  const auto patience = settings.connectPatience;
  auto source = std::make_unique<RemoteFrameSource>(std::move(io), settings, owner, std::move(onNews), backend, place);
  net::SceneFields scene = source->waitForScene(patience, stop);
  return {std::move(source), std::move(scene)};
}

}  // namespace warpscope
