// Trying the first, remembering that it failed.
// See fallback_marcher.h.
#include "render/march/fallback_marcher.h"

#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

#include "render/base/error.h"

namespace warpscope {
namespace {

/// What all marchers of a volume share: the first's failure, and the second.
class Fallback {
 public:
  Fallback(std::function<MarcherPtr()> makeSecond, std::function<void(const std::string&)> onFallback)
      : onFallback_(std::move(onFallback)), makeSecond_(std::move(makeSecond)) {}

  bool hasFailed() const {
    const std::scoped_lock lock(mutex_);
    return hasFailed_;
  }
  void fail(const std::string& reason) {
    {
      const std::scoped_lock lock(mutex_);
      if (hasFailed_) return;
      hasFailed_ = true;
    }
    if (onFallback_) onFallback_(reason);
  }
  /// The second, by the transfer function that it was made with.
  MarcherPtr second() {
    const std::scoped_lock lock(secondMutex_);
    if (!second_) second_ = makeSecond_();
    return second_;
  }

 private:
  mutable std::mutex mutex_;
  bool hasFailed_ = false;
  const std::function<void(const std::string&)> onFallback_;
  std::mutex secondMutex_;  // of the second alone: making one takes long
  MarcherPtr second_;
  const std::function<MarcherPtr()> makeSecond_;
};

/// What twins share.
class Plan {
 public:
  /// Without a function, that which the second is made with.
  explicit Plan(std::shared_ptr<Fallback> fallback, std::optional<TransferFunction> function = {})
      : fallback_(std::move(fallback)), function_(std::move(function)) {}

  bool hasFailed() const { return fallback_->hasFailed(); }
  void fail(const std::string& reason) { fallback_->fail(reason); }
  MarcherPtr second(const TurnsPtr& turns) {
    const std::scoped_lock lock(mutex_);
    const bool isFirstUse = !second_;
    if (isFirstUse) second_ = function_ ? fallback_->second()->withTransferFunction(*function_) : fallback_->second();
    return isFirstUse && !turns ? second_ : second_->twin(turns);
  }
  std::shared_ptr<Plan> with(TransferFunction function) const {
    return std::make_shared<Plan>(fallback_, std::move(function));
  }

 private:
  const std::shared_ptr<Fallback> fallback_;
  const std::optional<TransferFunction> function_;
  std::mutex mutex_;
  MarcherPtr second_;
};

class FallbackMarcher final : public Marcher {
 public:
  /// `first` is null where it could not be made.
  FallbackMarcher(MarcherPtr first, std::shared_ptr<Plan> plan, TurnsPtr turns)
      : plan_(std::move(plan)), turns_(std::move(turns)), marcher_(std::move(first)) {
    if (!marcher_) leave();
    volume_ = marcher_->volume();
  }

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    return attempt([&](Marcher& marcher) { return marcher.march(camera, settings, stop); });
  }
  SampleFrame marchToCode(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    return attempt([&](Marcher& marcher) { return marcher.marchToCode(camera, settings, stop); });
  }
  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override {
    attempt([&](Marcher& marcher) { marcher.render(camera, settings, image, stop); });
  }
  const VolumePtr& volume() const override { return volume_; }
  Backend backend() const override { return current()->backend(); }
  MarcherCapabilities capabilities() const override { return current()->capabilities(); }
  std::optional<EffectPlan> plan(const RenderSettings& settings, const std::optional<SampleSettings>& sample) const override {
    return current()->plan(settings, sample);
  }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr turns) const override {
    if (isSecond() || plan_->hasFailed()) return plan_->second(turns);
    try {
      return std::make_shared<FallbackMarcher>(current()->twin(turns), plan_, turns);
    } catch (const DeviceError& error) {
      plan_->fail(error.what());
      return plan_->second(turns);
    }
  }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    std::shared_ptr<Plan> plan = plan_->with(function);
    if (isSecond() || plan->hasFailed()) return plan->second(turns_);
    try {
      return std::make_shared<FallbackMarcher>(current()->withTransferFunction(std::move(function)), plan, turns_);
    } catch (const DeviceError& error) {
      plan->fail(error.what());
      return plan->second(turns_);
    }
  }

 private:
  template <class Work>
  std::invoke_result_t<const Work&, Marcher&> attempt(const Work& work) {
    if (!isSecond() && plan_->hasFailed()) leave();
    const auto [marcher, isSecondOne] = currentAndWhich();
    if (isSecondOne) return work(*marcher);
    try {
      return work(*marcher);
    } catch (const DeviceError& error) {
      plan_->fail(error.what());  // another call may have left before
      leave();
    }
    return work(*current());
  }

  std::pair<MarcherPtr, bool> currentAndWhich() const {
    const std::scoped_lock lock(mutex_);
    return {marcher_, isSecond_};
  }
  MarcherPtr current() const { return currentAndWhich().first; }
  bool isSecond() const { return currentAndWhich().second; }
  void leave() {
    if (isSecond()) return;
    MarcherPtr second = plan_->second(turns_);  // which takes long: others ask meanwhile what the first could do
    const std::scoped_lock lock(mutex_);
    if (isSecond_) return;
    marcher_ = std::move(second);
    isSecond_ = true;
  }

  const std::shared_ptr<Plan> plan_;
  const TurnsPtr turns_;
  VolumePtr volume_;
  mutable std::mutex mutex_;
  MarcherPtr marcher_;
  bool isSecond_ = false;
};

}  // namespace

MarcherPtr makeFallbackMarcher(const std::function<MarcherPtr()>& makeFirst, std::function<MarcherPtr()> makeSecond,
                               std::function<void(const std::string&)> onFallback) {
  auto plan = std::make_shared<Plan>(std::make_shared<Fallback>(std::move(makeSecond), std::move(onFallback)));
  MarcherPtr first;
  try {
    first = makeFirst();
  } catch (const DeviceError& error) {
    plan->fail(error.what());
  }
  return std::make_shared<FallbackMarcher>(std::move(first), std::move(plan), nullptr);
}

}  // namespace warpscope
