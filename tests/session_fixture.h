// A session over tiny volumes, without a window, and the means to let it run.
// Threads are real.
#pragma once

#include <gmock/gmock.h>

#include <atomic>
#include <thread>

#include "app/frames/backend.h"
#include "app/session/session.h"
#include "render/base/error.h"

namespace warpscope {

using std::chrono::milliseconds;
using std::chrono::seconds;

inline constexpr glm::uvec2 kPanelPx(40, 56);
inline constexpr seconds kPatience(60);  // far more than anything here takes, even under sanitizers

/// What a marcher with faults refuses at the moment, and what it passes for.
struct Faults {
  std::atomic<bool> march = false, render = false, plansElsewhere = false;
  std::atomic<bool> isCuda = false;
};

/// A marcher that fails when it is told to, and says that it is on a device when it is told to.
class FaultyMarcher final : public Marcher {
 public:
  FaultyMarcher(MarcherPtr sound, std::shared_ptr<const Faults> faults) : sound_(std::move(sound)), faults_(std::move(faults)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    if (faults_->march) throw InputError("the server is on fire");
    return sound_->march(camera, settings, stop);
  }
  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override {
    if (faults_->render) throw InputError("no ground truth today");
    sound_->render(camera, settings, image, stop);
  }
  const VolumePtr& volume() const override { return sound_->volume(); }
  Backend backend() const override { return faults_->isCuda ? Backend::cuda : sound_->backend(); }
  MarcherCapabilities capabilities() const override {
    if (faults_->isCuda)
      return {.pace = MarchPace::followsCamera, .volume = VolumePlace::here, .judging = JudgePlace::cudaDevice};
    return sound_->capabilities();
  }
  std::optional<EffectPlan> plan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const override {
    return faults_->plansElsewhere ? std::nullopt : sound_->plan(settings, sample);
  }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr turns) const override { return std::make_shared<FaultyMarcher>(sound_->twin(std::move(turns)), faults_); }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    return std::make_shared<FaultyMarcher>(sound_->withTransferFunction(std::move(function)), faults_);
  }

 private:
  MarcherPtr sound_;
  std::shared_ptr<const Faults> faults_;
};

inline void turn(Session& session, double degrees) {
  View view = session.view();
  view.angleDeg += degrees;
  session.setView(view);
}

class SessionTest : public ::testing::Test {
 protected:
  SessionSettings settings() const {
    SessionSettings settings;
    settings.panels = {{.technique = &findWarp("hold")}, {.technique = &findWarp("spheres")}};
    settings.knobs.serverSidePx = 48;
    return settings;
  }

  SessionTest() { session_.setPanelSize(kPanelPx); }

  /// A job whose scene this process serves to itself.
  LoadJob job(const std::string& name, std::function<Scene(const std::stop_token&)> openIt) {
    return {name, [io = io_, faults = faults_, openIt](const std::function<void()>& onNews, const std::stop_token& stop) {
              Scene scene = openIt(stop);
              const MarcherPtr sound = makeMarcher(Backend::cpu, scene.volume, scene.transferFunction);
              return hostScene(io, std::move(scene), std::make_shared<FaultyMarcher>(sound, faults), {}, onNews, stop);
            }};
  }
  LoadJob builtin(const std::string& name) {
    return job(name, [name](const std::stop_token& stop) {
      SceneOverrides overrides;
      overrides.proceduralDims = {16, 16, 16};
      return openScene(name, overrides, stop);
    });
  }

  template <class Predicate>
  bool pumpUntil(const Predicate& predicate) {
    return pumpUntil(session_, predicate);
  }
  template <class Predicate>
  bool pumpUntil(Session& session, const Predicate& predicate) {
    const auto deadline = clock_.now() + kPatience;
    while (clock_.now() < deadline) {
      session.update(clock_.now());
      if (predicate()) return true;
      std::this_thread::sleep_for(milliseconds(1));
    }
    return false;
  }

  /// Until everything that is shown belongs to the current camera, errors also where the ground truth follows the camera.
  bool settle() { return settle(session_); }
  bool settle(Session& session) {
    return pumpUntil(session, [&] { return isJudged(session) && isOfNewFrame(session); });
  }
  /// Every panel's picture is of the current camera, by whatever frame there is, and judged.
  static bool isJudged(const Session& session) {
    if (session.scene() == nullptr) return false;
    for (size_t i = 0; i < session.panelCount(); ++i) {
      const Panel& panel = session.panel(i);
      if (panel.isHidden) continue;
      if (!panel.picture || panel.drawn != panel.technique || !panel.isContentFound()) return false;
      const PanelPixels* const judged = panel.currentPixels();
      if (!panel.errorsAreCurrent || judged == nullptr) return false;
      const Camera& camera = judged->reference->job().camera;
      if (camera != makeCamera(*session.scene(), session.view(i), camera.width, camera.height)) return false;
    }
    return true;
  }
  bool isOfNewFrame(const Session& session) const {
    for (size_t i = 0; i < session.panelCount(); ++i)
      if (!session.panel(i).isHidden && session.ageMs(i, clock_.now()).value_or(0.0) != 0.0) return false;
    return true;
  }

  bool load(Session& session, LoadJob job) {
    session.setPanelSize(kPanelPx);
    session.load(std::move(job));
    return pumpUntil(session, [&] { return session.loading().empty() && session.scene() != nullptr; }) && settle(session);
  }
  bool open(const std::string& name) {
    session_.load(builtin(name));
    return pumpUntil([&] { return session_.loading().empty(); }) && settle();  // the scene before may be at rest
  }

  /// Turns the camera a little, so often, and lets the session run.
  void move(int times) {
    View view = session_.view();
    for (int i = 0; i < times; ++i) {
      view.angleDeg += 0.01;
      session_.setView(view);
      session_.update(clock_.now());
    }
  }

  const std::shared_ptr<Faults> faults_ = std::make_shared<Faults>();
  const std::shared_ptr<net::IoThread> io_ = std::make_shared<net::IoThread>();
  SteadyClock clock_;
  std::atomic<int> news_ = 0;
  Session session_{settings(), [this] { ++news_; }};
};

}  // namespace warpscope
