// Records, written by a thread.
// See recording_writer.h.
#include "app/frames/recording_writer.h"

#include <nlohmann/json.hpp>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <mutex>
#include <span>
#include <thread>
#include <utility>
#include <variant>

#include "app/frames/recording_format.h"
#include "app/frames/wire_fields.h"
#include "app/scene/transfer_file.h"
#include "app/shell/output_files.h"
#include "net/messages.h"
#include "net/wire.h"
#include "render/base/error.h"
#include "render/codec/codec.h"
#include "render/core/crew_work.h"

namespace warpscope {
namespace {

/// Frames that wait to be written: beyond these, new ones are left out.
constexpr size_t kMostWaiting = 64;
constexpr std::chrono::milliseconds kFlushPeriod(500);

/// Of frames in recordings: nothing is lost.
CodecSettings recordedCodec() {
  CodecSettings codec;
  codec.color = ColorCoding::lossless;
  return codec;
}

struct RecordedView {
  double seconds;
  View view;
};
struct RecordedFrame {
  double seconds;
  SampleFramePtr frame;
};
struct RecordedFunction {
  double seconds;
  TransferFunction function;
};
struct RecordedLink {
  double seconds;
  LinkSign sign;
};

std::string reasonOf(int error) { return std::strerror(error); }

}  // namespace

class RecordingWriter::Work {
 public:
  Work(const std::filesystem::path& path, const Scene& scene, const std::string& text, std::shared_ptr<Crew> crew) : path_(path), file_(opened(path)) {
    write(std::as_bytes(std::span(kRecordingMagic)));
    const net::Bytes message = net::sceneMessage(toFields(scene));
    record(0.0, RecordType::scene, std::span(message).subspan(8));  // without the message's head
    record(0.0, RecordType::text, std::as_bytes(std::span(text)));
    if (!scene.transferFunction.points.empty()) keep(RecordedFunction{0.0, scene.transferFunction});
    flush();
    if (!error_.empty()) {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);  // there is nothing in it that could be shown
      throw InputError(error_);
    }
    thread_ = std::thread([this, crew = std::move(crew)] {
      const WorkOnCrew working(crew.get(), Crew::kOfMarches);
      run();
    });
  }
  ~Work() { finish(); }

  void finish() {
    {
      const std::scoped_lock lock(mutex_);
      isEnding_ = true;
    }
    news_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  template <class Small>
  void post(Small one) {
    const std::scoped_lock lock(mutex_);
    waiting_.push_back(std::move(one));
    news_.notify_all();
  }
  void post(RecordedFrame frame) {
    const std::scoped_lock lock(mutex_);
    if (framesWaiting_ >= kMostWaiting) {
      ++leftOut_;
      return;
    }
    ++framesWaiting_;
    waiting_.push_back(std::move(frame));
    news_.notify_all();
  }
  std::string error() const {
    const std::scoped_lock lock(mutex_);
    return error_;
  }
  size_t leftOut() const {
    const std::scoped_lock lock(mutex_);
    return leftOut_;
  }

 private:
  using Item = std::variant<RecordedView, RecordedFrame, RecordedFunction, RecordedLink>;

  void run() {
    auto flushedAt = std::chrono::steady_clock::now();
    std::unique_lock lock(mutex_);
    while (!isEnding_ || !waiting_.empty()) {
      news_.wait_for(lock, kFlushPeriod, [&] { return isEnding_ || !waiting_.empty(); });
      while (!waiting_.empty()) {
        Item item = std::move(waiting_.front());
        waiting_.pop_front();
        if (std::holds_alternative<RecordedFrame>(item)) --framesWaiting_;
        lock.unlock();
        try {
          std::visit([&](const auto& one) { keep(one); }, item);
        } catch (const std::exception& error) {
          fail(error.what());
        }
        lock.lock();
      }
      if (std::chrono::steady_clock::now() - flushedAt < kFlushPeriod) continue;
      lock.unlock();
      flush();
      flushedAt = std::chrono::steady_clock::now();
      lock.lock();
    }
    lock.unlock();
    flush();
  }

  void keep(const RecordedView& one) {
    net::Bytes body;
    net::WireWriter writer(body);
    for (const double number : {one.view.angleDeg, one.view.elevationDeg, one.view.distance, one.view.pan.x, one.view.pan.y}) writer.number(number);
    record(one.seconds, RecordType::view, body);
  }

  void keep(const RecordedFunction& one) {
    const std::string text = toJson(one.function).dump();
    record(one.seconds, RecordType::function, std::as_bytes(std::span(text)));
  }

  void keep(const RecordedLink& one) {
    net::Bytes body;
    net::WireWriter writer(body);
    writer.number(static_cast<uint8_t>(one.sign.isOutage ? 1 : 0));
    const std::string text = one.sign.full + kBetweenSigns + one.sign.brief;
    const auto bytes = std::as_bytes(std::span(text));
    body.insert(body.end(), bytes.begin(), bytes.end());
    record(one.seconds, RecordType::link, body);
  }

  void keep(const RecordedFrame& one) {
    SampleFramePtr here;
    try {
      here = onHost(one.frame);
    } catch (const DeviceError&) {  // it went with its device: others come
      const std::scoped_lock lock(mutex_);
      ++leftOut_;
      return;
    }
    SampleFrame frame = *here;
    // The copy of the volume is written once, with the first frame that has it.
    if (std::exchange(proxy_, frame.proxy) == frame.proxy) {
      frame.proxy.reset();
      frame.settings.sample.proxy = 0;
    }
    const ByteVector payload = codec_.encode(frame, recordedCodec());
    net::FrameHead head = headOf(frame, recordedCodec());
    head.id = frame.requestId;
    net::Bytes body = net::frameMessage(head, payload.size());
    body.erase(body.begin(), body.begin() + 8);  // the message's head
    body.insert(body.end(), payload.begin(), payload.end());
    record(one.seconds, RecordType::frame, body);
  }

  void record(double seconds, RecordType type, std::span<const std::byte> body) {
    net::Bytes head;
    net::WireWriter writer(head);
    writer.number(seconds);
    writer.number(static_cast<uint8_t>(type));
    writer.number(static_cast<uint32_t>(body.size()));
    write(head);
    write(body);
  }

  void write(std::span<const std::byte> bytes) {
    if (hasFailed_ || bytes.empty()) return;
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail(reasonOf(errno));
  }
  void flush() {
    if (!hasFailed_ && std::fflush(file_.get()) != 0) fail(reasonOf(errno));
  }
  void fail(const std::string& reason) {
    hasFailed_ = true;
    const std::scoped_lock lock(mutex_);
    error_ = path_.string() + ": " + reason;
  }

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  static std::FILE* opened(const std::filesystem::path& path) {
    if (isSpecial(path)) throw InputError(path.string() + ": is no regular file: nothing can be recorded into it");
    std::FILE* const file = std::fopen(path.c_str(), "wb");
    if (file == nullptr) throw InputError(path.string() + ": " + reasonOf(errno));
    return file;
  }
  const std::filesystem::path path_;
  const std::unique_ptr<std::FILE, Close> file_;
  FrameCodec codec_;
  ProxyPtr proxy_;          // that was written last
  bool hasFailed_ = false;  // these are the thread's
  mutable std::mutex mutex_;  // of the following
  std::condition_variable news_;
  std::deque<Item> waiting_;
  size_t framesWaiting_ = 0, leftOut_ = 0;
  std::string error_;
  bool isEnding_ = false;
  std::thread thread_;
};

RecordingWriter::RecordingWriter(const std::filesystem::path& path, const Scene& scene, const std::string& text, std::shared_ptr<Crew> crew)
    : work_(std::make_unique<Work>(path, scene, text, std::move(crew))) {}
RecordingWriter::~RecordingWriter() = default;
void RecordingWriter::addView(double seconds, const View& view) { work_->post(RecordedView{seconds, view}); }
void RecordingWriter::addFrame(double seconds, SampleFramePtr frame) { work_->post(RecordedFrame{seconds, std::move(frame)}); }
void RecordingWriter::addFunction(double seconds, const TransferFunction& function) { work_->post(RecordedFunction{seconds, function}); }
void RecordingWriter::addLink(double seconds, const LinkSign& sign) { work_->post(RecordedLink{seconds, sign}); }
std::string RecordingWriter::error() const { return work_->error(); }
size_t RecordingWriter::framesLeftOut() const { return work_->leftOut(); }
std::string RecordingWriter::finish() {
  work_->finish();
  return work_->error();
}

}  // namespace warpscope
