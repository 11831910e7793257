// Marchers that are another, but for what a test adds.
#pragma once

#include <atomic>
#include <memory>
#include <utility>

#include "render/march/marcher.h"

namespace warpscope {

/// Is another, but for what those that derive from it do themselves.
class MarcherAround : public Marcher {
 public:
  explicit MarcherAround(MarcherPtr inner) : inner_(std::move(inner)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override { return inner_->march(camera, settings, stop); }
  void render(const Camera& camera, const RenderSettings& settings, Image<glm::vec4>& image, const std::stop_token& stop) override {
    inner_->render(camera, settings, image, stop);
  }
  const VolumePtr& volume() const override { return inner_->volume(); }
  Backend backend() const override { return inner_->backend(); }
  MarcherCapabilities capabilities() const override { return inner_->capabilities(); }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr turns) const override { return around(inner_->twin(std::move(turns))); }
  MarcherPtr withTransferFunction(TransferFunction function) const override { return around(inner_->withTransferFunction(std::move(function))); }

 protected:
  virtual MarcherPtr around(MarcherPtr inner) const = 0;

  const MarcherPtr inner_;
};

/// Counts the marches that it and its twins have begun.
class BegunMarcher final : public MarcherAround {
 public:
  BegunMarcher(MarcherPtr inner, std::shared_ptr<std::atomic<int>> begun) : MarcherAround(std::move(inner)), begun_(std::move(begun)) {}

  SampleFrame march(const Camera& camera, const MarchSettings& settings, const std::stop_token& stop) override {
    ++*begun_;
    return inner_->march(camera, settings, stop);
  }

 private:
  MarcherPtr around(MarcherPtr inner) const override { return std::make_shared<BegunMarcher>(std::move(inner), begun_); }

  const std::shared_ptr<std::atomic<int>> begun_;
};

}  // namespace warpscope
