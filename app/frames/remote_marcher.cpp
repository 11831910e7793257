// One question, one answer.
// See remote_marcher.h.
#include "app/frames/remote_marcher.h"

#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "app/frames/backend.h"
#include "app/frames/color_bytes.h"
#include "app/frames/wire_fields.h"
#include "net/address.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

class RemoteMarcher final : public Marcher, private net::ClientEvents {
 public:
  RemoteMarcher(std::shared_ptr<net::IoThread> io, net::ClientSettings settings, CodecSettings codec,
                Clock::Duration patience, std::function<void(uint16_t)> onBusy, Backend backend, std::optional<net::SceneFields> scene)
      : io_(std::move(io)),
        clock_(io_->clock()),
        settings_(std::move(settings)),
        coding_(codec),
        patience_(patience),
        onBusy_(std::move(onBusy)),
        decodesOn_(backend),
        codec_(makeTiledCoder(backend)),
        scene_(std::move(scene)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    const std::scoped_lock lock(callMutex_);
    const net::Frame answer = ask(net::Wanted::samples, camera, settings, stop);
    SampleFrame frame = decodedFrom(answer.head, answer.payload, codec_);
    const std::scoped_lock sceneLock(mutex_);
    if (scene_) frame.geometry = geometryFrom(*scene_);
    return frame;
  }

  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override {
    if (settings.arithmetic != Arithmetic::stable)
      throw UsageError("a server's volume is marched in stable arithmetic alone: textbook forms need it here");
    const std::scoped_lock lock(callMutex_);
    const net::Frame answer = ask(net::Wanted::picture, camera, {settings, {}}, stop);
    image = decodeColors(answer.payload, camera.width, camera.height);
  }

  const VolumePtr& volume() const override { return none_; }
  Backend backend() const override { return Backend::cpu; }
  MarcherCapabilities capabilities() const override {
    return {.pace = MarchPace::afterRest,
            .volume = VolumePlace::elsewhere,
            .judging = JudgePlace::host,
            .functionChange = FunctionChange::refused};
  }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr) const override {
    const std::scoped_lock lock(mutex_);
    return makeRemoteMarcher(io_, settings_, coding_, patience_, onBusy_, decodesOn_, scene_);
  }
  MarcherPtr withTransferFunction(TransferFunction) const override {
    throw UsageError("a server chooses the transfer function of its volume: its clients cannot have another");
  }

 private:
  net::Frame ask(net::Wanted wanted, const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) {
    requireUsable(camera);
    validate(settings);
    net::FrameRequest request;
    request.id = ++lastId_;
    request.wanted = wanted;
    request.camera = toFields(camera);
    request.settings = toFields(settings);
    request.codec = toFields(coding_);
    if (!client_) client_ = std::make_unique<net::Client>(io_, settings_, static_cast<net::ClientEvents&>(*this));
    {
      const std::scoped_lock lock(mutex_);
      answer_.reset();
      failure_.reset();
      awaited_ = request.id;
      if (!isConnected_) lostAt_ = clock_.now();
    }
    client_->request(request);
    std::unique_lock lock(mutex_);
    while (!answer_ && !failure_ && refusal_.empty()) {
      // As long as there is a connection, the march may take its time. Without one, trying again is not the same as having one.
      const Clock::TimePoint end = (isConnected_ ? clock_.now() : lostAt_) + patience_;
      changed_ = {};
      const std::stop_token change = changed_.get_token();
      lock.unlock();
      {
        const std::stop_callback onStop(stop, [this] { note([] {}); });
        clock_.waitUntil(end, change);
      }
      lock.lock();
      if (stop.stop_requested()) throw OperationCancelled();
      if (!isConnected_ && clock_.now() >= lostAt_ + patience_)
        throw InputError(trouble_.empty() ? net::toString(settings_.address.where) + " does not answer" : trouble_);
    }
    if (failure_) throw InputError("the server: " + failure_->sentence);
    if (!answer_) throw InputError(refusal_);
    return std::move(*answer_);
  }

  template <class F>
  void note(F&& f) {
    const std::scoped_lock lock(mutex_);
    f();
    changed_.request_stop();
  }
  void onState(const net::ConnectionState& state) override {
    note([&] {
      const bool wasConnected = std::exchange(isConnected_, state.phase == net::ConnectionPhase::connected);
      if (wasConnected && !isConnected_) lostAt_ = clock_.now();
      if (!state.sentence.empty()) trouble_ = state.sentence;
      if (state.phase == net::ConnectionPhase::refused) refusal_ = state.sentence;
    });
  }
  void onScene(const net::SceneFields& scene) override {
    note([&] {
      if (scene_ && *scene_ != scene) refusal_ = net::toString(settings_.address.where) + " shows another scene now: connect anew to see it";
      if (!scene_) scene_ = scene;
    });
  }
  std::string faultOf(const net::FrameHead& head, uint64_t payloadBytes) override {
    return warpscope::faultOf(head, payloadBytes);
  }
  void onFrame(net::Frame frame, const net::FrameArrival&) override {
    note([&] {
      if (frame.head.id == awaited_) answer_ = std::move(frame);
    });
  }
  void onFailure(const net::Failure& failure) override {
    note([&] {
      if (failure.id == awaited_) failure_ = failure;
    });
  }

  void onBusy(uint16_t others) override {
    if (onBusy_) onBusy_(others);
  }

  const std::shared_ptr<net::IoThread> io_;
  Clock& clock_;
  const net::ClientSettings settings_;
  const CodecSettings coding_;
  const Clock::Duration patience_;
  const std::function<void(uint16_t)> onBusy_;
  const VolumePtr none_;
  std::mutex callMutex_;  // of a whole call, and of the two below
  const Backend decodesOn_;
  FrameCodec codec_;
  uint64_t lastId_ = 0;
  mutable std::mutex mutex_;  // of what the network's thread says
  std::stop_source changed_;  // asked to stop when any of the below has changed
  uint64_t awaited_ = 0;      // the request whose answer is waited for: those of requests that were given up come first
  std::optional<net::Frame> answer_;
  std::optional<net::Failure> failure_;
  std::optional<net::SceneFields> scene_;
  std::string refusal_, trouble_;
  bool isConnected_ = false;
  Clock::TimePoint lostAt_{};  // or the call's begin, where there was no connection
  std::unique_ptr<net::Client> client_;  // last: it tells all of the above
};

}  // namespace

MarcherPtr makeRemoteMarcher(std::shared_ptr<net::IoThread> io, net::ClientSettings settings, CodecSettings codec,
                             Clock::Duration patience, std::function<void(uint16_t)> onBusy, Backend backend, std::optional<net::SceneFields> scene) {
  return std::make_shared<RemoteMarcher>(std::move(io), std::move(settings), codec, patience, std::move(onBusy), backend, std::move(scene));
}

}  // namespace warpscope
