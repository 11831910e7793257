// Records: written by a thread, read at once.
// See recording.h.
#include "app/frames/recording.h"

#include <algorithm>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <deque>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include "app/frames/classified_frame.h"
#include "app/frames/wire_fields.h"
#include "app/scene/json_document.h"
#include "app/scene/transfer_file.h"
#include "app/shell/output_files.h"
#include "net/wire.h"
#include "render/base/error.h"
#include "render/base/printable.h"

namespace warpscope {
namespace {

enum class RecordType : uint8_t { scene = 1, text = 2, view = 3, frame = 4, function = 5, link = 6 };

constexpr size_t kRecordHeadBytes = 8 + 1 + 4;
/// Frames that wait to be written: beyond these, new ones are left out.
constexpr size_t kMostWaiting = 64;
constexpr std::chrono::milliseconds kFlushPeriod(500);
constexpr uint64_t kMostBytes = uint64_t{1} << 36;
constexpr char kBetweenSigns = '\n';
constexpr size_t kMostSignBytes = 4096;

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
  Work(const std::filesystem::path& path, const Scene& scene, const std::string& text) : path_(path), file_(opened(path)) {
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
    thread_ = std::thread([this] { run(); });
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
    SampleFrame frame = *one.frame;
    // The copy of the volume is written once, with the first frame that has it.
    if (std::exchange(proxy_, frame.proxy) == frame.proxy) {
      frame.proxy.reset();
      frame.settings.sample.proxy = 0;
    }
    const net::Bytes payload = codec_.encode(frame, recordedCodec());
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

RecordingWriter::RecordingWriter(const std::filesystem::path& path, const Scene& scene, const std::string& text)
    : work_(std::make_unique<Work>(path, scene, text)) {}
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

namespace {

/// Reads bytes of a file; false where there are not as many.
bool readExactly(std::ifstream& file, std::byte* into, size_t count) {
  file.read(reinterpret_cast<char*>(into), static_cast<std::streamsize>(count));
  return static_cast<size_t>(file.gcount()) == count;
}

/// Takes a record over that is no frame; false for one that is not as it should be.
bool take(Recording& recording, double seconds, RecordType type, std::span<const std::byte> body) {
  switch (type) {
    case RecordType::scene: {
      const std::optional<net::SceneFields> scene = net::readScene(body);
      if (!scene || recording.scene.geometry().dims.x > 0) return false;  // it has one
      recording.scene = sceneFrom(*scene);
      return true;
    }
    case RecordType::text: recording.text.assign(reinterpret_cast<const char*>(body.data()), body.size()); return true;
    case RecordType::view: {
      View view;
      net::WireReader reader(body);
      for (double* number : {&view.angleDeg, &view.elevationDeg, &view.distance, &view.pan.x, &view.pan.y}) reader.number(*number);
      const auto isWithin = [](double number, double least, double most) { return number >= least && number <= most; };
      const bool isView = isWithin(view.angleDeg, -1e6, 1e6) && isWithin(view.elevationDeg, -90.0, 90.0) && isWithin(view.distance, kViewDistanceRange.lowest, kViewDistanceRange.highest) &&
                          isWithin(view.pan.x, -kMostViewPan, kMostViewPan) && isWithin(view.pan.y, -kMostViewPan, kMostViewPan);
      if (!reader.isComplete() || !isView) return false;
      recording.path.add(seconds, view);
      return true;
    }
    case RecordType::function: {
      const JsonDocument document(std::string_view(reinterpret_cast<const char*>(body.data()), body.size()), recording.file.string());
      if (!recording.functions.empty() && seconds < recording.functions.back().seconds) return false;
      recording.functions.push_back({seconds, readTransferFunction(document.root())});
      if (recording.functions.size() == 1) recording.scene.transferFunction = recording.functions.front().function;
      return true;
    }
    case RecordType::link: {
      if (body.empty() || std::to_integer<uint8_t>(body[0]) > 1) return false;
      if (!recording.links.empty() && seconds < recording.links.back().seconds) return false;
      const std::string_view text(reinterpret_cast<const char*>(body.data()) + 1, body.size() - 1);
      const size_t between = text.find(kBetweenSigns);
      if (between == std::string_view::npos || text.size() > kMostSignBytes) return false;
      recording.links.push_back({seconds, {printable(text.substr(0, between)), printable(text.substr(between + 1)), std::to_integer<uint8_t>(body[0]) == 1}});
      return true;
    }
    case RecordType::frame: return false;
  }
  return false;
}

/// Takes the head of a frame's record over, which is `bytes` long and begins at `at`, where the file is; false for one that is not as it should be.
bool takeFrame(Recording& recording, double seconds, std::ifstream& file, uint64_t at, size_t bytes) {
  std::vector<std::byte> body(net::kFrameHeadLengthBytes);
  if (bytes < body.size() || !readExactly(file, body.data(), body.size())) return false;
  const std::optional<size_t> length = net::readFrameHeadLength(body);
  if (!length || *length > bytes || *length < body.size()) return false;
  const size_t read = body.size();
  body.resize(*length);
  if (!readExactly(file, body.data() + read, *length - read)) return false;
  const std::optional<net::FrameHead> head = net::readFrameHead(body);
  if (!head || !faultOf(*head, bytes - *length).empty()) return false;
  if (!recording.frames.empty() && seconds < recording.frames.back().seconds) return false;
  recording.frames.push_back({seconds, *head, at + *length, bytes - *length, marchFrom(head->settings).sample.proxy > 0});
  return true;
}

}  // namespace

bool isRecording(const std::filesystem::path& path) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed)) return false;  // a pipe would wait
  std::ifstream file(path, std::ios::binary);
  std::array<std::byte, 8> magic{};
  return readExactly(file, magic.data(), magic.size()) && std::memcmp(magic.data(), kRecordingMagic.data(), 7) == 0;
}

Recording readRecording(const std::filesystem::path& path, const std::stop_token& stop) {
  std::error_code failed;
  if (!std::filesystem::exists(path, failed)) throw InputError(path.string() + ": there is no such file");
  if (isSpecial(path)) throw InputError(path.string() + ": is no regular file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string() + ": is no file that can be read");
  if (std::filesystem::file_size(path, failed) > kMostBytes) throw InputError(path.string() + ": is too large for a recording");
  std::array<std::byte, 8> magic{};
  const bool hasMagic = readExactly(file, magic.data(), magic.size());
  if (!hasMagic || std::memcmp(magic.data(), kRecordingMagic.data(), 7) != 0) throw InputError(path.string() + ": is no recording of warpscope");
  if (std::to_integer<char>(magic[7]) != kRecordingMagic[7]) throw InputError(path.string() + ": was recorded by a program of another version");
  Recording recording;
  recording.file = path;
  const uint64_t size = std::filesystem::file_size(path, failed);
  uint64_t at = magic.size();
  bool hasScene = false;
  for (size_t number = 1;; ++number) {
    if (stop.stop_requested()) throw OperationCancelled();
    std::array<std::byte, kRecordHeadBytes> head{};
    if (!readExactly(file, head.data(), head.size())) break;
    double seconds;
    uint8_t type;
    uint32_t length;
    net::WireReader reader(head);
    reader.number(seconds);
    reader.number(type);
    reader.number(length);
    at += head.size();
    if (length > size - at) break;  // cut off
    bool isFine = seconds >= 0.0 && seconds < 1e7;
    try {
      if (type == static_cast<uint8_t>(RecordType::frame)) {
        isFine = isFine && takeFrame(recording, seconds, file, at, length);
        file.seekg(static_cast<std::streamoff>(at + length));
      } else if (type > static_cast<uint8_t>(RecordType::link)) {
        file.seekg(static_cast<std::streamoff>(at + length));  // of a later program, that this one need not know
      } else {
        std::vector<std::byte> body(length);
        if (!readExactly(file, body.data(), length)) break;
        isFine = isFine && take(recording, seconds, static_cast<RecordType>(type), body);
      }
    } catch (const InputError&) {
      isFine = false;  // a scene, a function or a frame that cannot be
    }
    at += length;
    if (!isFine) throw InputError(path.string() + ": its record " + std::to_string(number) + " is damaged");
    hasScene |= type == static_cast<uint8_t>(RecordType::scene);
    recording.seconds = std::max(recording.seconds, seconds);
  }
  if (!hasScene || recording.path.empty()) throw InputError(path.string() + ": ends before anything was shown");
  try {
    static_cast<void>(makeCamera(recording.scene, recording.path.at(0.0), 64, 64));
  } catch (const UsageError&) {
    throw InputError(path.string() + ": its scene is damaged");
  }
  return recording;
}

std::optional<size_t> frameAt(const Recording& recording, double seconds) {
  const auto next = std::ranges::upper_bound(recording.frames, seconds, {}, &Recording::Frame::seconds);
  if (next == recording.frames.begin()) return std::nullopt;
  return static_cast<size_t>(next - recording.frames.begin()) - 1;
}

namespace {

/// How unlike two cameras are: their directions, and their places by how far the second is from the volume's middle, which is 0. Pictures of other shapes have
/// other distances (makeCamera), so that a few thousandths say nothing.
double unlikeness(const Camera& a, const Camera& b) {
  const glm::dvec3 eye(b.eye);
  return glm::distance(glm::dvec3(a.forward), glm::dvec3(b.forward)) + glm::distance(glm::dvec3(a.up), glm::dvec3(b.up)) +
         glm::distance(glm::dvec3(a.eye), eye) / std::max(glm::length(eye), 1e-300);
}

}  // namespace

size_t viewAskedWith(const Recording& recording, const Recording::Frame& arrived, const Camera& camera) {
  constexpr size_t kMostBefore = 1200;  // 20 seconds of them
  const std::vector<TimedView>& views = recording.path.views();
  const auto after = static_cast<size_t>(std::ranges::upper_bound(views, arrived.seconds, {}, &TimedView::seconds) - views.begin());
  size_t best = after > 0 ? after - 1 : 0;
  double least = std::numeric_limits<double>::max();
  for (size_t i = after; i > 0 && after - i < kMostBefore; --i) {
    const double unlike = unlikeness(makeCamera(recording.scene, views[i - 1].view, camera.width, camera.height), camera);
    if (unlike >= least) continue;
    least = unlike;
    best = i - 1;
  }
  return best;
}

double leftAt(const Recording& recording, size_t view) {
  const std::vector<TimedView>& views = recording.path.views();
  size_t left = view;
  while (left < views.size() && views[left].view == views[view].view) ++left;
  return left < views.size() ? views[left].seconds : std::max(recording.seconds, recording.frames.empty() ? 0.0 : recording.frames.front().seconds);
}

LinkSign linkAt(const Recording& recording, double seconds) {
  const auto next = std::ranges::upper_bound(recording.links, seconds, {}, &Recording::Link::seconds);
  return next == recording.links.begin() ? LinkSign{} : std::prev(next)->sign;
}

LinkSign signOf(const net::DuplexLinkSettings& link, bool hasOutage) {
  constexpr const char* kOutage = "Simulated outage: nothing passes";
  if (hasOutage) return {kOutage, kOutage, true};
  if (link.isTransparent()) return {};
  const net::LinkWords words = net::wordsOf(link);
  return {"Simulated link: " + words.full, "Simulated link: " + words.brief};
}

const TransferFunction* functionAt(const Recording& recording, double seconds) {
  const auto next = std::ranges::upper_bound(recording.functions, seconds, {}, &Recording::Function::seconds);
  return next == recording.functions.begin() ? nullptr : &std::prev(next)->function;
}

SampleFrame RecordedFrames::decoded(size_t index) {
  const Recording::Frame& recorded = recording_.frames[index];
  const auto fail = [&](const std::string& why) { return InputError("the recording's frame " + std::to_string(index + 1) + why); };
  std::vector<std::byte> payload(recorded.payloadBytes);
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(recorded.payloadAt));
  if (!readExactly(file_, payload.data(), payload.size())) throw fail(" cannot be read any more: " + recording_.file.string() + " has changed");
  try {
    return decodedFrom(recorded.head, payload, codec_);
  } catch (const InputError& error) {
    throw fail(std::string(" is damaged: ") + error.what());
  }
}

SampleFramePtr RecordedFrames::at(double seconds) {
  const SampleFramePtr frame = read(seconds);
  const TransferFunction* const function = functionAt(recording_, seconds);
  if (frame && function != nullptr) frame_ = classifiedBy(*function, frame);
  return frame ? frame_ : nullptr;
}

SampleFramePtr RecordedFrames::read(double seconds) {
  const std::optional<size_t> wanted = frameAt(recording_, seconds);
  if (!wanted) return nullptr;
  if (decoded_ == wanted) return frame_;
  const auto hasProxy = [&](size_t index) { return recording_.frames[index].hasProxy; };
  size_t source = *wanted;  // of the copy of the volume
  while (source > 0 && !hasProxy(source)) --source;
  if (source != *wanted && hasProxy(source) && proxyFrame_ != source) {
    proxy_ = decoded(source).proxy;
    proxyBytes_ = codec_.bytes().proxy;
    proxyFrame_ = source;
  }
  SampleFrame frame = decoded(*wanted);
  bytes_ = codec_.bytes();
  if (frame.proxy) {
    proxy_ = frame.proxy;
    proxyBytes_ = bytes_.proxy;
    proxyFrame_ = wanted;
  } else if (hasProxy(source) && proxy_) {
    frame.proxy = proxy_;
    bytes_.proxy = proxyBytes_;
    frame.settings.sample.proxy = static_cast<int>(std::max({proxy_->volume->dims().x, proxy_->volume->dims().y, proxy_->volume->dims().z}));
  }
  frame.geometry = recording_.scene.geometry();
  frame_ = std::make_shared<const SampleFrame>(std::move(frame));
  decoded_ = wanted;
  return frame_;
}

}  // namespace warpscope
