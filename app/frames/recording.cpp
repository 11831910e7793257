// A file is read once, but for its frames, which are left where they are.
// See recording.h.
#include "app/frames/recording.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <limits>
#include <span>

#include "app/frames/recording_format.h"
#include "app/frames/wire_fields.h"
#include "app/scene/json_document.h"
#include "app/scene/transfer_file.h"
#include "app/shell/output_files.h"
#include "net/wire.h"
#include "render/base/error.h"
#include "render/base/printable.h"

namespace warpscope {
namespace {

constexpr uint64_t kMostBytes = uint64_t{1} << 36;
constexpr size_t kMostSignBytes = 4096;

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

const TransferFunction* functionAt(const Recording& recording, double seconds) {
  const auto next = std::ranges::upper_bound(recording.functions, seconds, {}, &Recording::Function::seconds);
  return next == recording.functions.begin() ? nullptr : &std::prev(next)->function;
}

}  // namespace warpscope
