// A lane for each client that waits: a thread with a marcher and a codec, which are given back when they are not needed.
// See frame_server.h.
#include "app/frames/frame_server.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <new>

#include "app/frames/backend.h"
#include "app/frames/color_bytes.h"
#include "app/frames/server_load.h"
#include "app/frames/wire_fields.h"
#include "render/base/error.h"
#include "render/base/stopwatch.h"
#include "render/codec/codec.h"
#include "render/core/crew_work.h"
#include "render/core/freed_memory.h"

namespace warpscope {
namespace {

// What a lane keeps from one request to the next is given back after a pause, or when it was far too much for so many in a row.
constexpr std::chrono::milliseconds kKeptFor{2000};
constexpr int kMostSmallerJobs = 16;
constexpr size_t kFarTooMuch = 4;
constexpr size_t kSpareShare = 4;  // of a payload, that may be room behind it

// Bytes of a sample or a pixel that marcher, frame and codec hold at the same time, at the most; seen where `block` fills most of a picture: 25 and 24.
constexpr size_t kBytesOfSample = 40;
constexpr size_t kBytesOfSpread = 16;  // likewise, where samples come with one: dense, kept, in planes of bytes, and coded
constexpr size_t kBytesOfPicturePixel = 64;
constexpr size_t kLeastBytes = size_t{1} << 20;

constexpr std::chrono::milliseconds kHousekeeping{500};  // between looks at what is kept and what is short

net::ServerSettings withScene(net::ServerSettings settings, const Scene& scene) {
  settings.scene = toFields(scene);
  return settings;
}

std::string sizeText(double width, double height) {
  char text[64];
  std::snprintf(text, sizeof text, "%.0fx%.0f", std::max(1.0, std::floor(width)), std::max(1.0, std::floor(height)));
  return text;
}

std::string mebibytes(size_t bytes) { return std::to_string((bytes + (size_t{1} << 20) - 1) >> 20) + " MiB"; }

/// Waiting for turns is waiting, wherever in the march it was.
void takeTurnsFrom(net::StageTimes& stages, double waitedMs) {
  stages.marchMs = std::max(0.0, stages.marchMs - waitedMs);
  stages.queueMs += waitedMs;
}

/// What the client is told of a march that takes too long, with what would fit.
std::string sentenceFor(const WorkLimitExceeded& error, const Camera& camera, const MarchSettings& settings) {
  const double share = std::max(error.share(), 1e-9), side = std::sqrt(share);
  char text[256];
  std::snprintf(text, sizeof text, "%s at a step of %.3g takes longer than the %.3g s of marching that the server gives a request: a step of %.2g would fit, or %s",
                sizeText(camera.width, camera.height).c_str(), static_cast<double>(settings.render.step),
                std::chrono::duration<double>(error.limit()).count(), static_cast<double>(settings.render.step) / share,
                sizeText(camera.width * side, camera.height * side).c_str());
  return text;
}

}  // namespace

size_t ServeLimits::defaultMemoryBytes() {
  const long pages = sysconf(_SC_PHYS_PAGES), pageBytes = sysconf(_SC_PAGESIZE);
  const size_t machine = pages > 0 && pageBytes > 0 ? static_cast<size_t>(pages) * static_cast<size_t>(pageBytes) : size_t{4} << 30;
  return std::min(machine / 2, size_t{8} << 30);
}

size_t memoryFor(const Camera& camera, const MarchSettings& settings, net::Wanted wanted) {
  const size_t pixels = size_t{camera.width} * camera.height;
  if (wanted == net::Wanted::picture) return kLeastBytes + pixels * kBytesOfPicturePixel;
  const size_t bytesOfSample = kBytesOfSample + (settings.sample.sendsSpread ? kBytesOfSpread : 0);
  // Segments as they are marched, as they are sent, and packed.
  const size_t bytesOfSegment = 3 * (sizeof(SegmentDepths) + sizeof(Rgba8) + sizeof(NormalCode));
  const size_t segments = pixels * static_cast<size_t>(settings.sample.segments) * bytesOfSegment;
  const auto edge = static_cast<size_t>(settings.sample.proxy);
  return kLeastBytes + pixels * static_cast<size_t>(settings.sample.samplesPerRay) * bytesOfSample + segments + 4 * edge * edge * edge;
}

/// How many requests may be marched at the same time. On the CPU each has all cores by itself; small pictures leave much of a device idle, and so does the
/// end of each march: two give a third more frames than one, four no more than two.
int marchesAtOnce(Backend backend) { return backend == Backend::cuda ? 2 : 1; }

/// What one thread works with. Others may look at it while it rests.
class FrameServer::Lane {
 public:
  explicit Lane(const TurnsPtr& turns) : turns_(turns ? turns->sibling() : nullptr) {}

  /// Held while it works.
  std::mutex& mutex() { return mutex_; }

  /// For a request of so many bytes, to be marched by a twin of `origin`.
  void prepare(size_t bytes, const MarcherPtr& origin) {
    if (std::exchange(origin_, origin) != origin) marcher_.reset();
    smaller_ = bytes * kFarTooMuch < bytes_ ? smaller_ + 1 : 0;
    if (smaller_ >= kMostSmallerJobs) giveBack();
    bytes_ = std::max(bytes_, bytes);
    if (turns_) turns_->setAtOnce(marchesAtOnce(origin_->backend()));  // a device may have been left since
    if (!marcher_) marcher_ = origin_->twin(turns_);
    if (!codec_) codec_ = std::make_unique<FrameCodec>(makeTiledCoder(origin_->backend()));
  }
  void rest(Clock::TimePoint now) { restsSince_ = now; }
  void giveBackIfRested(Clock::TimePoint now) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (lock && bytes_ > 0 && now - restsSince_ >= kKeptFor) giveBack();
  }

  Marcher& marcher() { return *marcher_; }
  FrameCodec& codec() { return *codec_; }
  /// For turns, since the last call.
  double exchangeWaitedMs() { return turns_ ? std::chrono::duration<double, std::milli>(turns_->exchangeWaited()).count() : 0.0; }

 private:
  void giveBack() {
    marcher_.reset();
    codec_.reset();
    bytes_ = 0;
    smaller_ = 0;
    giveBackFreedMemory();
  }

  const TurnsPtr turns_;
  std::mutex mutex_;  // of the following
  MarcherPtr origin_, marcher_;
  std::unique_ptr<FrameCodec> codec_;
  size_t bytes_ = 0;
  int smaller_ = 0;  // requests in a row that needed far less
  Clock::TimePoint restsSince_{};
};

/// A frame that answers a request, but for who asked and when.
struct FrameServer::Answer {
  net::FrameHead head;
  net::HeldBytes payload;
  net::ByteBudget::SharePtr share;
};

FrameServer::FrameServer(std::shared_ptr<net::IoThread> io, const Scene& scene, MarcherPtr marcher, net::ServerSettings settings,
                         std::optional<ServeLimits> limits, Processes processes)
    : clock_(io->clock()),
      turns_(limits ? std::make_shared<Turns>(TurnSettings{.limit = limits->work}) : nullptr),
      budget_(limits ? std::make_unique<net::ByteBudget>(limits->memoryBytes) : nullptr),
      crew_(limits ? nullptr : std::make_unique<Crew>()),
      server_(std::move(io), withScene(settings, scene)),
      mostLanes_(limits ? settings.clients.most : 1),
      processes_(std::move(processes)),
      marcher_(std::move(marcher)) {
  try {
    startLane();
    const std::scoped_lock lock(mutex_);
    threads_.emplace_back([this] { keepHouse(); });
  } catch (...) {  // the system gives no more threads
    end();
    throw;
  }
}

FrameServer::~FrameServer() { end(); }

void FrameServer::end() {
  requestStop();
  server_.stop();
  std::vector<std::thread> threads;
  {
    const std::scoped_lock lock(mutex_);
    isEnding_ = true;
    threads.swap(threads_);
  }
  for (std::thread& thread : threads) thread.join();
}

void FrameServer::startLane() {
  const std::scoped_lock lock(mutex_);
  if (isEnding_ || idle_ > 0 || lanes_.size() >= mostLanes_) return;
  const size_t before = lanes_.size();
  try {
    Lane& lane = *lanes_.emplace_back(std::make_shared<Lane>(turns_));
    threads_.emplace_back([this, &lane] { run(lane); });
  } catch (const std::exception&) {
    lanes_.resize(before);
    if (before == 0) throw;
    return;  // the system gives no more threads: those that there are go on, and more is tried with the next request
  }
  ++idle_;
}

MarcherPtr FrameServer::marcher() const {
  const std::scoped_lock lock(mutex_);
  return marcher_;
}

void FrameServer::setTransferFunction(TransferFunction function) {
  MarcherPtr changed = marcher()->withTransferFunction(std::move(function));
  const std::scoped_lock lock(mutex_);
  marcher_ = std::move(changed);
}

void FrameServer::run(Lane& lane) {
  const WorkOnCrew working(crew_.get(), Crew::kOfMarches);
  while (const std::optional<net::RequestJob> job = server_.requests().take(stop_.get_token())) {
    {
      const std::scoped_lock lock(mutex_);
      --idle_;
    }
    startLane();  // for whoever asks meanwhile
    {
      const std::scoped_lock atWork(lane.mutex());
      answer(*job, lane);
      lane.rest(clock_.now());
    }
    const std::scoped_lock lock(mutex_);
    ++idle_;
  }
}

void FrameServer::keepHouse() {
  while (clock_.waitUntil(clock_.now() + kHousekeeping, stop_.get_token())) {
    if (budget_ && budget_->isShort()) server_.makeRoom();
    std::vector<std::shared_ptr<Lane>> lanes;
    {
      const std::scoped_lock lock(mutex_);
      lanes = lanes_;
      std::erase_if(paces_, [](const auto& of) { return of.second.hasLeft.stop_requested(); });
    }
    for (const std::shared_ptr<Lane>& lane : lanes) lane->giveBackIfRested(clock_.now());  // takes its time: setTransferFunction() does not wait for it
  }
}

void FrameServer::answer(const net::RequestJob& job, Lane& lane) {
  const double queueMs = millisecondsBetween(job.arrivedAt, clock_.now());
  // The others do not wait for a march whose client is gone.
  std::stop_source end;
  const std::stop_callback byServer(stop_.get_token(), [&end] { end.request_stop(); });
  const std::stop_callback byClient(job.hasLeft, [&end] { end.request_stop(); });
  try {
    Answer answer = answerTo(job, lane, end.get_token());
    answer.head.id = job.request.id;
    answer.head.wanted = job.request.wanted;
    answer.head.requestSentAtNs = job.request.sentAtNs;
    answer.head.stages.queueMs += queueMs;
    server_.answer(job.client, answer.head, std::move(answer.payload), std::move(answer.share), toFields(processes_ ? processes_() : std::vector<RankWork>{}));
  } catch (const OperationCancelled&) {
    // The client or the server is gone: nobody waits.
  } catch (const std::bad_alloc&) {
    server_.answer(job.client, net::Failure{job.request.id, "the server has not enough memory for this"});
  } catch (const std::exception& error) {
    server_.answer(job.client, net::Failure{job.request.id, error.what()});
  }
}

/// Waits for it; null without limits.
net::ByteBudget::SharePtr FrameServer::memoryOf(const Camera& camera, size_t bytes, const std::stop_token& stop) {
  if (!budget_) return nullptr;
  if (bytes > budget_->largest()) {
    const double side = std::sqrt(static_cast<double>(budget_->largest()) / static_cast<double>(bytes));
    throw InputError(sizeText(camera.width, camera.height) + " takes about " + mebibytes(bytes) + " of the server's memory, and it gives a request at most " +
                     mebibytes(budget_->largest()) + ": " + sizeText(camera.width * side, camera.height * side) + " would fit");
  }
  if (net::ByteBudget::SharePtr share = budget_->take(bytes, stop)) return share;
  throw OperationCancelled();
}

std::shared_ptr<ServerPace> FrameServer::paceOf(const net::RequestJob& job) {
  const std::scoped_lock lock(mutex_);
  PaceOfClient& of = paces_[job.client];
  if (!of.pace) of = {job.hasLeft, std::make_shared<ServerPace>()};
  return of.pace;
}

FrameServer::Answer FrameServer::answerTo(const net::RequestJob& job, Lane& lane, const std::stop_token& stop) {
  const net::FrameRequest& request = job.request;
  const Camera camera = cameraFrom(request.camera);
  const MarchSettings march = marchFrom(request.settings);
  const CodecSettings coding = codecFrom(request.codec);
  const size_t bytes = memoryFor(camera, march, request.wanted);
  Answer answer;
  ByteVector payload;
  answer.share = memoryOf(camera, bytes, stop);
  lane.prepare(bytes, marcher());
  lane.exchangeWaitedMs();
  try {
    if (request.wanted == net::Wanted::samples) {
      const ServerWishes wishes = wishesFrom(request.settings);
      const std::shared_ptr<ServerPace> pace = wishes.movingMs > 0 ? paceOf(job) : nullptr;
      const MarchSettings paced = pace ? pace->settingsFor(camera, march, wishes.movingMs, job.arrivedAt) : march;
      const auto marchTo = [&](bool toCode) {
        SampleFrame frame = toCode ? lane.marcher().marchToCode(camera, paced, stop) : lane.marcher().march(camera, paced, stop);
        answer.head = headOf(frame, coding, wishes);
        takeTurnsFrom(answer.head.stages, lane.exchangeWaitedMs());
        return frame;
      };
      const auto encode = [&](const SampleFrame& frame) {
        answer.head.stages.encodeMs = milliseconds([&] { payload = lane.codec().encode(frame, coding); });
      };
      SampleFrame frame = marchTo(FrameCodec::codesOnDevices(coding));
      try {
        encode(frame);
      } catch (const DeviceError&) {
        if (!frame.isAway) throw;
        frame = {};              // what was left on the device is lost with it, and its memory may be what there was too little of
        frame = marchTo(false);  // elsewhere from the start
        encode(frame);
      }
      net::StageTimes& took = answer.head.stages;
      if (wishes.loadPercent > 0) shareProcessor({&took.marchMs, &took.compactMs, &took.copyMs, &took.encodeMs}, wishes.loadPercent, clock_, stop);
      if (pace) pace->note(camera, march, frame.settings, took.marchMs + took.compactMs + took.copyMs + took.encodeMs, clock_.now());
    } else {
      Image<glm::vec4> image;
      answer.head.camera = request.camera;
      answer.head.settings = request.settings;
      answer.head.codec = request.codec;
      answer.head.stages.marchMs = milliseconds([&] { lane.marcher().render(camera, march.render, image, stop); });
      takeTurnsFrom(answer.head.stages, lane.exchangeWaitedMs());
      answer.head.stages.encodeMs = milliseconds([&] { payload = encodeColors(image); });
    }
  } catch (const WorkLimitExceeded& error) {
    throw InputError(sentenceFor(error, camera, march));
  }
  // What is little more than there are bytes is not worth their copying.
  if (payload.capacity() - payload.size() > payload.size() / kSpareShare) payload.shrink_to_fit();
  if (answer.share) answer.share->shrinkTo(payload.capacity());
  answer.payload = std::move(payload);
  return answer;
}

}  // namespace warpscope
