// What a recording says of its scene, and what of that is here.
// See recorded_scene.h.
#include "app/session/recorded_scene.h"

#include <utility>

#include "app/frames/backend.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

/// In place of a volume that is not here.
class AbsentVolume final : public Marcher {
 public:
  explicit AbsentVolume(std::string why) : why_(std::move(why)) {}

  SampleFrame march(const Camera&, const MarchSettings&, const std::stop_token&) override { throw InputError(why_); }
  void render(const Camera&, const RenderSettings&, Image<glm::vec4>&, const std::stop_token&) override { throw InputError(why_); }
  const VolumePtr& volume() const override { return none_; }
  Backend backend() const override { return Backend::cpu; }
  MarcherCapabilities capabilities() const override { return {.volume = VolumePlace::elsewhere, .functionChange = FunctionChange::refused}; }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr) const override { return std::make_shared<AbsentVolume>(why_); }
  MarcherPtr withTransferFunction(TransferFunction) const override { throw UsageError(why_); }

 private:
  const std::string why_;
  const VolumePtr none_;
};

}  // namespace

MarcherPtr marcherOf(const Recording& recording, Backend backend, const std::stop_token& stop) {
  const std::string file = recording.file.string();
  if (recording.text.empty()) throw InputError(file + ": does not say of which scene it is");
  const SessionFile session = readSessionText(recording.text, file);
  if (session.origin.spec.find("://") != std::string::npos) throw InputError(file + ": its volume is a server's");
  Scene scene = openScene(session.origin.spec, session.origin.overrides, stop);
  if (scene.geometry().dims != recording.scene.geometry().dims) throw InputError(file + ": the volume of " + session.origin.spec + " is another one now");
  if (!recording.functions.empty())
    scene.transferFunction = recording.functions.front().function;
  else if (session.arrangement.transferFunction)
    scene.transferFunction = *session.arrangement.transferFunction;
  return makeMarcher(backend, scene.volume, scene.transferFunction);
}

std::string textForRecording(const Session& session) {
  try {
    SessionFile file = sessionFileOf(session);
    if (!session.playback().isOpen()) return textOf(file);
    const Recording& recording = session.playback().recording();
    if (recording.text.empty()) return "";
    file.origin = readSessionText(recording.text, recording.file.string()).origin;
    return textOf(file);
  } catch (const InputError&) {
    return "";
  }
}

ConnectedScene openRecording(const std::filesystem::path& path, Backend backend, std::function<void()> onNews, const std::stop_token& stop) {
  auto recording = std::make_shared<Recording>(readRecording(path, stop));
  ConnectedScene opened;
  const auto goWithout = [&](const std::exception& error) {
    opened.whyNoTruth = std::string("no ground truth: ") + error.what();
    opened.display = std::make_shared<AbsentVolume>(opened.whyNoTruth);
  };
  try {
    opened.display = marcherOf(*recording, backend, stop);
    recording->scene.volume = opened.display->volume();
  } catch (const InputError& error) {
    goWithout(error);
  } catch (const UsageError& error) {  // of scenes that there are none of here
    goWithout(error);
  }
  opened.scene = recording->scene;
  opened.recorded = std::make_shared<RecordedFrameSource>(std::move(recording), std::move(onNews));
  opened.source = opened.recorded;
  return opened;
}

std::optional<SessionFile> sessionFileOfRecording(const std::filesystem::path& path, const std::stop_token& stop) {
  const Recording recording = readRecording(path, stop);
  if (recording.text.empty()) return std::nullopt;
  SessionFile file = readSessionText(recording.text, path.string());
  file.origin = {path.string(), {}};
  file.arrangement.transferFunction.reset();
  return file;
}

}  // namespace warpscope
