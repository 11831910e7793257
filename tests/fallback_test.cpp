// What happens when a device fails: marchers and techniques that go on elsewhere, tell it once, and lose nothing.
// Mirrors render/march/fallback_marcher.h and render/warp/fallback_warp.h, with devices that are made up.
#include <gtest/gtest.h>

#include <atomic>
#include <barrier>
#include <latch>
#include <thread>

#include "render/base/error.h"
#include "render/march/fallback_marcher.h"
#include "render/warp/fallback_warp.h"

namespace warpscope {
namespace {

/// Counts its uses, and fails from the `failsAt`-th on.
struct FailingDevice {
  int failsAt;
  int uses = 0;

  void use() {
    if (++uses >= failsAt) throw DeviceError("lost");
  }
};

class MadeUpMarcher final : public Marcher {
 public:
  MadeUpMarcher(Backend backend, int failsAt, size_t points = 0)
      : backend_(backend), device_{failsAt}, points_(points) {}

  SampleFrame march(const Camera& camera, const MarchSettings&, const std::stop_token&) override {
    device_.use();
    SampleFrame frame;
    frame.camera = camera;
    frame.requestId = (backend_ == Backend::cpu ? 1 : 2) + 10 * points_;
    return frame;
  }
  void render(const Camera&, const RenderSettings&, Image<glm::vec4>& image, const std::stop_token&) override {
    device_.use();
    image.resize(1, 1, glm::vec4(backend_ == Backend::cpu ? 1.0f : 2.0f));
  }
  const VolumePtr& volume() const override { return volume_; }
  Backend backend() const override { return backend_; }
  MarcherCapabilities capabilities() const override {
    return {.pace = backend_ == Backend::cpu ? MarchPace::afterRest : MarchPace::followsCamera};
  }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr) const override {
    return std::make_shared<MadeUpMarcher>(backend_, device_.failsAt, points_);
  }
  MarcherPtr withTransferFunction(TransferFunction function) const override {
    if (device_.failsAt <= 0) throw DeviceError("no memory for another");
    return std::make_shared<MadeUpMarcher>(backend_, device_.failsAt, function.points.size());
  }

 private:
  const Backend backend_;
  FailingDevice device_;
  const size_t points_;  // of the transfer function
  VolumePtr volume_;
};

constexpr int kNever = 1000;

MarcherPtr madeUp(Backend backend, int failsAt) { return std::make_shared<MadeUpMarcher>(backend, failsAt); }

struct Notes {
  std::vector<std::string> reasons;
  std::function<void(const std::string&)> take() {
    return [this](const std::string& reason) { reasons.push_back(reason); };
  }
};

TEST(FallbackMarcher, StaysWhereNothingFails) {
  Notes notes;
  bool madeSecond = false;
  const MarcherPtr marcher = makeFallbackMarcher([] { return madeUp(Backend::cuda, kNever); },
                                                 [&] {
                                                   madeSecond = true;
                                                   return madeUp(Backend::cpu, kNever);
                                                 },
                                                 notes.take());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(marcher->march({}, {}).requestId, 2u);
  EXPECT_EQ(marcher->backend(), Backend::cuda);
  EXPECT_FALSE(madeSecond);
  EXPECT_TRUE(notes.reasons.empty());
}

TEST(FallbackMarcher, GoesOnWithTheSecondFromTheFailureOn) {
  Notes notes;
  const MarcherPtr marcher =
      makeFallbackMarcher([] { return madeUp(Backend::cuda, 2); }, [] { return madeUp(Backend::cpu, kNever); }, notes.take());
  EXPECT_EQ(marcher->march({}, {}).requestId, 2u);
  EXPECT_EQ(marcher->capabilities().pace, MarchPace::followsCamera);
  EXPECT_EQ(marcher->march({}, {}).requestId, 1u);  // the frame that failed is made all the same
  Image<glm::vec4> image;
  marcher->render({}, {}, image);
  EXPECT_EQ(image(0, 0).x, 1.0f);
  EXPECT_EQ(marcher->backend(), Backend::cpu);
  EXPECT_EQ(marcher->capabilities().pace, MarchPace::afterRest);
  EXPECT_EQ(notes.reasons, std::vector<std::string>{"lost"});
}

TEST(FallbackMarcher, ADeviceThatCannotBeHadIsAFailure) {
  Notes notes;
  const MarcherPtr marcher = makeFallbackMarcher([]() -> MarcherPtr { throw DeviceError("out of memory"); },
                                                 [] { return madeUp(Backend::cpu, kNever); }, notes.take());
  EXPECT_EQ(marcher->march({}, {}).requestId, 1u);
  EXPECT_EQ(notes.reasons, std::vector<std::string>{"out of memory"});
}

TEST(FallbackMarcher, TwinsLeaveTogetherAndTellOnce) {
  Notes notes;
  const MarcherPtr first =
      makeFallbackMarcher([] { return madeUp(Backend::cuda, 2); }, [] { return madeUp(Backend::cpu, kNever); }, notes.take());
  const MarcherPtr second = first->twin();
  EXPECT_EQ(first->march({}, {}).requestId, 2u);
  EXPECT_EQ(second->march({}, {}).requestId, 2u);
  EXPECT_EQ(first->march({}, {}).requestId, 1u);
  EXPECT_EQ(second->march({}, {}).requestId, 1u);
  EXPECT_EQ(first->twin()->backend(), Backend::cpu);
  EXPECT_EQ(notes.reasons.size(), 1u);
}

/// Waits until so many march at once, and fails then.
class FailingTogether final : public Marcher {
 public:
  explicit FailingTogether(std::ptrdiff_t threads) : together_(threads) {}
  SampleFrame march(const Camera&, const MarchSettings&, const std::stop_token&) override {
    together_.arrive_and_wait();
    throw DeviceError("lost");
  }
  void render(const Camera&, const RenderSettings&, Image<glm::vec4>&, const std::stop_token&) override {}
  const VolumePtr& volume() const override { return volume_; }
  Backend backend() const override { return Backend::cuda; }
  MarcherCapabilities capabilities() const override { return {.pace = MarchPace::followsCamera}; }
  using Marcher::twin;
  MarcherPtr twin(TurnsPtr) const override { return nullptr; }
  MarcherPtr withTransferFunction(TransferFunction) const override { return nullptr; }

 private:
  std::barrier<> together_;
  VolumePtr volume_;
};

TEST(FallbackMarcher, CallsThatFailTogetherAllGoOn) {
  constexpr int kThreads = 4;
  Notes notes;
  const MarcherPtr marcher = makeFallbackMarcher([&] { return std::make_shared<FailingTogether>(kThreads); }, [] { return madeUp(Backend::cpu, kNever); }, notes.take());
  std::atomic<int> marched = 0;
  {
    std::vector<std::jthread> threads;
    for (int i = 0; i < kThreads; ++i)
      threads.emplace_back([&] {
        try {
          marched += marcher->march({}, {}).requestId == 1u;
        } catch (const DeviceError&) {
        }
      });
  }
  EXPECT_EQ(marched, kThreads);
  EXPECT_EQ(notes.reasons.size(), 1u);
}

TEST(FallbackMarcher, WhileTheSecondIsMadeOthersAskWhatTheFirstCould) {
  std::latch isMaking(1), mayGoOn(1);
  const MarcherPtr marcher = makeFallbackMarcher([] { return madeUp(Backend::cuda, 1); },
                                                 [&] {
                                                   isMaking.count_down();
                                                   mayGoOn.wait();
                                                   return madeUp(Backend::cpu, kNever);
                                                 },
                                                 {});
  std::jthread marching([&] { marcher->march({}, {}); });
  isMaking.wait();
  EXPECT_EQ(marcher->backend(), Backend::cuda);  // hangs if it waits for the second
  EXPECT_EQ(marcher->capabilities().pace, MarchPace::followsCamera);
  mayGoOn.count_down();
  marching.join();
  EXPECT_EQ(marcher->backend(), Backend::cpu);
}

TransferFunction functionOf(size_t points) { return {std::vector<TransferPoint>(points)}; }

TEST(FallbackMarcher, OtherTransferFunctionsLeaveTogetherAndGoOnByTheirs) {
  Notes notes;
  int secondsMade = 0;
  const MarcherPtr first = makeFallbackMarcher([] { return madeUp(Backend::cuda, 2); },
                                               [&] {
                                                 ++secondsMade;
                                                 return madeUp(Backend::cpu, kNever);
                                               },
                                               notes.take());
  const MarcherPtr other = first->withTransferFunction(functionOf(3));
  EXPECT_EQ(other->march({}, {}).requestId, 32u);
  EXPECT_EQ(first->march({}, {}).requestId, 2u);
  const MarcherPtr third = other->withTransferFunction(functionOf(4));
  EXPECT_EQ(third->march({}, {}).requestId, 42u);
  EXPECT_EQ(secondsMade, 0);
  EXPECT_EQ(other->march({}, {}).requestId, 31u);  // the device is lost
  EXPECT_EQ(third->march({}, {}).requestId, 41u);
  EXPECT_EQ(third->twin()->march({}, {}).requestId, 41u);
  EXPECT_EQ(first->march({}, {}).requestId, 1u);
  EXPECT_EQ(first->withTransferFunction(functionOf(5))->march({}, {}).requestId, 51u);
  EXPECT_EQ(other->withTransferFunction(functionOf(6))->backend(), Backend::cpu);
  EXPECT_EQ(secondsMade, 1);
  EXPECT_EQ(notes.reasons, std::vector<std::string>{"lost"});
}

TEST(FallbackMarcher, ADeviceThatCannotTakeAnotherTransferFunctionIsLeft) {
  Notes notes;
  const MarcherPtr first = makeFallbackMarcher([] { return madeUp(Backend::cuda, 0); },
                                               [] { return madeUp(Backend::cpu, kNever); }, notes.take());
  EXPECT_EQ(first->withTransferFunction(functionOf(3))->march({}, {}).requestId, 31u);
  EXPECT_EQ(first->march({}, {}).requestId, 1u);
  EXPECT_EQ(notes.reasons, std::vector<std::string>{"no memory for another"});
}

TEST(FallbackMarcher, OtherErrorsAndTheSecondsAreTheCallers) {
  Notes notes;
  const MarcherPtr marcher =
      makeFallbackMarcher([] { return madeUp(Backend::cuda, 1); }, [] { return madeUp(Backend::cpu, 1); }, notes.take());
  EXPECT_THROW(marcher->march({}, {}), DeviceError);
  EXPECT_EQ(notes.reasons.size(), 1u);
}

/// Draws the backend's number; fails at the `failsAt`-th picture or frame.
class MadeUpWarp final : public Warp {
 public:
  MadeUpWarp(Backend backend, int failsAt, size_t* frames = nullptr) : backend_(backend), device_{failsAt}, frames_(frames) {}

  void setFrame(SampleFramePtr frame, const WarpSettings&, const std::stop_token&) override {
    device_.use();
    if (frames_ != nullptr) ++*frames_;
    frame_ = std::move(frame);
  }
  void draw(const Camera&, const WarpSettings&, WarpedImage& image, const std::stop_token&) override {
    device_.use();
    image.samples.resize(1, 1, frame_ ? static_cast<uint32_t>(frame_->requestId) : 0);
    image.color.resize(1, 1, glm::vec4(backend_ == Backend::cpu ? 1.0f : 2.0f));
  }

 private:
  const Backend backend_;
  FailingDevice device_;
  size_t* const frames_;  // that it was given
  SampleFramePtr frame_;
};

TEST(FallbackWarp, GoesOnWithTheSameFrame) {
  auto frame = std::make_shared<SampleFrame>();
  frame->requestId = 77;
  for (const int failsAt : {0, 1, 2, 3}) {  // when made, at the frame, at the first picture, at the second
    SCOPED_TRACE(failsAt);
    Notes notes;
    const std::unique_ptr<Warp> warp = makeFallbackWarp(
        [&]() -> std::unique_ptr<Warp> {
          if (failsAt == 0) throw DeviceError("none");
          return std::make_unique<MadeUpWarp>(Backend::cuda, failsAt);
        },
        [] { return std::make_unique<MadeUpWarp>(Backend::cpu, kNever); }, notes.take());
    WarpedImage image;
    warp->setFrame(frame, {});
    for (int picture = 0; picture < 3; ++picture) {
      warp->draw({}, {}, image);
      EXPECT_EQ(image.samples(0, 0), 77u);
    }
    EXPECT_EQ(image.color(0, 0).x, 1.0f);
    EXPECT_EQ(notes.reasons.size(), 1u);
  }
}

TEST(FallbackWarp, TheSecondGetsEachFrameOnce) {
  Notes notes;
  size_t frames = 0;
  const std::unique_ptr<Warp> warp = makeFallbackWarp([] { return std::make_unique<MadeUpWarp>(Backend::cuda, 1); },
                                                      [&] { return std::make_unique<MadeUpWarp>(Backend::cpu, kNever, &frames); }, notes.take());
  warp->setFrame(std::make_shared<SampleFrame>(), {});
  EXPECT_EQ(frames, 1u);
}

TEST(FallbackWarp, ThoseOfOneDeviceLeaveTogetherAndTellOnce) {
  auto frame = std::make_shared<SampleFrame>();
  frame->requestId = 7;
  Notes notes;
  size_t tried = 0;
  const auto hasFailed = std::make_shared<bool>(false);
  const auto make = [&] {
    return makeFallbackWarp(
        [&] {
          ++tried;
          return std::make_unique<MadeUpWarp>(Backend::cuda, 3);
        },
        [] { return std::make_unique<MadeUpWarp>(Backend::cpu, kNever); }, notes.take(), hasFailed);
  };
  const std::unique_ptr<Warp> first = make(), second = make();
  WarpedImage image;
  for (const auto& warp : {first.get(), second.get()}) warp->setFrame(frame, {});
  for (int picture = 0; picture < 3; ++picture) first->draw({}, {}, image);
  ASSERT_EQ(notes.reasons.size(), 1u);
  second->draw({}, {}, image);
  EXPECT_EQ(image.samples(0, 0), 7u) << "its frame goes along";
  EXPECT_EQ(image.color(0, 0).x, 1.0f) << "by the second, without a try";
  make()->draw({}, {}, image);
  EXPECT_EQ(image.color(0, 0).x, 1.0f);
  EXPECT_EQ(tried, 2u);
  EXPECT_EQ(notes.reasons.size(), 1u);
}

}  // namespace
}  // namespace warpscope
