// A worker that waits for the link, marches, and waits again.
// See direct_frame_source.h.
#include "app/frames/direct_frame_source.h"

#include <mutex>
#include <optional>

#include "app/frames/server_load.h"
#include "app/frames/server_pace.h"
#include "app/frames/wire_fields.h"
#include "net/link_model.h"
#include "render/base/newest_worker.h"
#include "render/codec/proxy_coding.h"

namespace warpscope {
namespace {

struct Job {
  FrameRequest request;
  Clock::TimePoint sentAt;
};

/// What the request would take on the wire.
size_t messageBytes(const FrameRequest& request) {
  net::FrameRequest asked;
  asked.camera = toFields(request.camera);
  asked.settings = toFields(request.settings);
  return net::requestMessage(asked).size();
}

/// What goes down, in the format `raw`.
struct Answer {
  const SampleFrame& frame;
  FrameBytes bytes;
};
size_t messageBytes(const Answer& answer) { return net::frameMessage(headOf(answer.frame, {}), 0).size() + answer.bytes.all(); }

class DirectFrameSource final : public FrameSource {
 public:
  DirectFrameSource(MarcherPtr marcher, Clock& clock, std::function<void()> onNews)
      : marcher_(std::move(marcher)),
        clock_(clock),
        up_(net::LinkSettings{}, clock.now(), 0),
        down_(net::LinkSettings{}, clock.now(), 1),
        worker_([this] { return [this](const Job& job, ServedFrame& served, const std::stop_token& stop) { serve(job, served, stop); }; },
                std::move(onNews)) {}

  void post(const FrameRequest& request, Clock::TimePoint now) override { worker_.post({request, now}); }
  std::optional<ServedFrame> tryTake() override { return worker_.tryTake(); }

  void setTransport(const TransportSettings& transport) override {
    const std::scoped_lock lock(mutex_);
    if (transport.link.up != up_.settings()) up_.setSettings(transport.link.up, clock_.now());
    if (transport.link.down != down_.settings()) down_.setSettings(transport.link.down, clock_.now());
    wishes_ = transport.server;
  }
  SourceStatus status() const override { return {}; }
  void requestStop() override { worker_.requestStop(); }
  bool waitForEnd(Clock::TimePoint time) override { return worker_.waitForEnd(time); }

 private:
  void serve(const Job& job, ServedFrame& served, const std::stop_token& stop) {
    served.requestId = job.request.id;
    served.requestedAt = job.sentAt;
    // What waited for its turn meanwhile does not wait again.
    cross(up_, job.request, job.sentAt, stop);
    const Clock::TimePoint beganAt = clock_.now();
    const ServerWishes wishes = [this] {
      const std::scoped_lock lock(mutex_);
      return wishes_;
    }();
    const bool isPaced = wishes.movingMs > 0;
    const MarchSettings settings = isPaced ? pace_.settingsFor(job.request.camera, job.request.settings, wishes.movingMs, beganAt) : job.request.settings;
    SampleFrame frame = marcher_->march(job.request.camera, settings, stop);
    frame.requestId = job.request.id;
    ServerTimings& took = frame.timings;
    if (wishes.loadPercent > 0) shareProcessor({&took.marchMs, &took.compactMs, &took.copyMs}, wishes.loadPercent, clock_, stop);
    const Clock::TimePoint marchedAt = clock_.now();
    if (isPaced) pace_.note(job.request.camera, job.request.settings, settings, millisecondsBetween(beganAt, marchedAt), marchedAt);
    served.bytes = bytesOf(frame);
    cross(down_, Answer{frame, served.bytes}, marchedAt, stop);
    served.arrivedAt = clock_.now();
    served.latency = latencyOf(frame.timings);
    served.latency.wireMs = millisecondsBetween(job.sentAt, beganAt) + millisecondsBetween(marchedAt, served.arrivedAt);
    served.frame = std::make_shared<const SampleFrame>(std::move(frame));
  }

  /// As it would be sent: the copy of the volume once.
  FrameBytes bytesOf(const SampleFrame& frame) {
    FrameBytes bytes{.samples = frame.sizeBytes() - frame.segments.sizeBytes(), .segments = frame.segments.sizeBytes()};
    if (frame.proxy && frame.proxy != sentProxy_) bytes.proxy = proxyBytesOf(*frame.proxy);
    if (frame.proxy) sentProxy_ = frame.proxy;
    return bytes;
  }

  /// Waits until what was sent has crossed the link. One that simulates nothing is not asked: no message is made up to
  /// be measured, and nobody waits.
  template <class Message>
  void cross(net::LinkModel& link, const Message& message, Clock::TimePoint sentAt, const std::stop_token& stop) {
    const auto arrivesAt = [&]() -> std::optional<Clock::TimePoint> {
      const std::scoped_lock lock(mutex_);
      if (link.settings().isTransparent()) return std::nullopt;
      return link.arrivalOf(messageBytes(message), sentAt);
    }();
    if (arrivesAt && !clock_.waitUntil(*arrivesAt, stop)) throw OperationCancelled();
  }

  const MarcherPtr marcher_;
  Clock& clock_;
  std::mutex mutex_;  // of the links and the wishes
  net::LinkModel up_, down_;
  ServerWishes wishes_;
  ServerPace pace_;     // of the worker's thread
  ProxyPtr sentProxy_;  // likewise: the last that went down
  NewestWorker<Job, ServedFrame> worker_;
};

}  // namespace

std::unique_ptr<FrameSource> makeDirectFrameSource(MarcherPtr marcher, Clock& clock, std::function<void()> onNews) {
  return std::make_unique<DirectFrameSource>(std::move(marcher), clock, std::move(onNews));
}

}  // namespace warpscope
