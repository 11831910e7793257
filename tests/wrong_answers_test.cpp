// Servers that answer something else than they were asked, and whoever takes their frames: the source behind a window
// and commands, and the marcher behind ground truth. Each lie is a sentence, is not decoded, and ends the connection
// for good. Mirrors faultOf() and decodedFrom() of app/frames/wire_fields.h, and their users.
#include <gmock/gmock.h>

#include <limits>
#include <random>

#include "app/frames/backend.h"
#include "app/frames/color_bytes.h"
#include "app/frames/frame_fetch.h"
#include "app/frames/remote_marcher.h"
#include "app/frames/scene_connection.h"
#include "app/frames/wire_fields.h"
#include "render/base/error.h"
#include "tests/headless.h"
#include "tests/net/adversarial_server.h"

namespace warpscope {
namespace {

using net::AdversarialServer;
using net::BareSocket;
using net::echoOf;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr size_t kMiB = size_t{1} << 20;

/// What an honest server says of `frame` in answer to `request`.
net::FrameHead honestHead(const net::FrameRequest& request, const SampleFrame& frame) {
  net::FrameHead head = headOf(frame, codecFrom(request.codec));
  const net::FrameHead echo = echoOf(request);
  head.id = echo.id;
  head.wanted = echo.wanted;
  head.settings = echo.settings;
  return head;
}

class WrongAnswers : public testing::Test {
 protected:
  WrongAnswers()
      : scene_(smallScene("shells")), marcher_(makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction)) {
    camera_ = makeCamera(scene_, scene_.views.front(), 64, 48);
  }

  /// What each way in says to a server that answers so.
  std::vector<std::string> sentences(const AdversarialServer::Answer& answer) {
    std::vector<std::string> said;
    {
      const AdversarialServer server(toFields(scene_), answer);
      const ConnectedScene connected = connectScene(io_, server.address(), transport_, [] {}, {});
      said.push_back(sentenceOf([&] { fetchFrom(connected.source)(camera_, settings_, {}); }));
      EXPECT_EQ(server.connections(), 1);
      // A window has a marcher of its own for what it compares with.
      said.push_back(sentenceOf([&] { connected.display->march(camera_, settings_, {}); }));
      EXPECT_EQ(server.connections(), 2);
    }
    const AdversarialServer server(toFields(scene_), answer);
    const MarcherPtr alone = connectMarcher(io_, server.address(), transport_, {});
    said.push_back(sentenceOf([&] { alone->march(camera_, settings_, {}); }));
    return said;
  }
  /// The same for an honest frame whose head is changed; `payload` may be, too.
  std::vector<std::string> sentences(const std::function<void(net::FrameHead&, ByteVector&)>& change) {
    return sentences([&](BareSocket& to, const net::FrameRequest& request) {
      const SampleFrame frame = marcher_->march(camera_, settings_);
      net::FrameHead head = honestHead(request, frame);
      ByteVector payload = FrameCodec().encode(frame, codecFrom(request.codec));
      change(head, payload);
      return to.send(net::frameMessage(head, payload.size())) && to.send(payload);
    });
  }
  void expectAll(const std::function<void(net::FrameHead&, ByteVector&)>& change, const std::string& sentence) {
    const net::PeakMemory peak;
    EXPECT_THAT(sentences(change), testing::Each(HasSubstr(sentence)));
    if (const auto grown = peak.grownBytes(); grown && !net::kIsSanitized) EXPECT_LT(*grown, 32 * kMiB) << sentence;
  }

  template <class Call>
  static std::string sentenceOf(Call call) {
    try {
      call();
    } catch (const InputError& error) {
      return error.what();
    }
    return "it was taken";
  }

  const std::shared_ptr<net::IoThread> io_ = std::make_shared<net::IoThread>();
  Scene scene_;
  MarcherPtr marcher_;
  Camera camera_;
  MarchSettings settings_;
  TransportSettings transport_{.link = {}, .codec = {}, .depth = 1};
};

TEST_F(WrongAnswers, AnHonestAnswerIsTaken) {
  EXPECT_THAT(sentences([](net::FrameHead&, ByteVector&) {}), testing::Each("it was taken"));
}

TEST_F(WrongAnswers, AnInventedCameraIsNotDecoded) {
  // Few bytes that would be many samples: a frame of 8192 x 8192 in which nearly nothing is seen.
  expectAll([](net::FrameHead& head, ByteVector&) { head.camera.width = head.camera.height = 8192; },
            "the server answered something else than it was asked: a size of 8192x8192 pixels, not 64x48");
  expectAll([](net::FrameHead& head, ByteVector&) { head.camera.eye[0] += 1.0f; }, "asked: another camera");
}

TEST_F(WrongAnswers, OtherFramesSettingsAndCodecsAreNotDecoded) {
  expectAll([](net::FrameHead& head, ByteVector&) { head.id += 1; }, "nobody waits for frame");
  expectAll([](net::FrameHead& head, ByteVector&) { head.wanted = net::Wanted::picture; },
            "a picture where samples were wanted");
  expectAll([](net::FrameHead& head, ByteVector&) { head.codec.format = 0; }, "another codec");
  expectAll(
      [](net::FrameHead& head, ByteVector&) {
        std::ranges::find(head.settings, "samplesPerRay", &net::SettingField::name)->value = "8";
      },
      "the setting samplesPerRay is not 1");
}

void setOf(net::FrameHead& head, std::string_view name, const std::string& value) {
  const auto found = std::ranges::find(head.settings, name, &net::SettingField::name);
  if (found == head.settings.end())
    head.settings.push_back({std::string(name), value});
  else
    found->value = value;
}

TEST_F(WrongAnswers, ACoarserStepIsTakenFromThoseAloneThatWereAllowedIt) {
  const auto withStep = [](const char* step) { return [step](net::FrameHead& head, ByteVector&) { setOf(head, "step", step); }; };
  expectAll(withStep("1.5"), "the setting step is not 0.5");
  transport_.server.movingMs = 40;
  // The source behind windows and commands says so; what marches ground truth does not, and takes nothing else.
  const auto answers = [&](const std::function<void(net::FrameHead&, ByteVector&)>& change) { return sentences(change).front(); };
  for (const float step : {1.5f, 2.0f}) {
    const auto marched = [&](BareSocket& to, const net::FrameRequest& request) {
      MarchSettings coarser = settings_;
      coarser.render.step = step;
      const SampleFrame frame = marcher_->march(camera_, coarser);
      net::FrameHead head = honestHead(request, frame);
      head.settings = headOf(frame, codecFrom(request.codec), wishesFrom(request.settings)).settings;
      const ByteVector payload = FrameCodec().encode(frame, codecFrom(request.codec));
      return to.send(net::frameMessage(head, payload.size())) && to.send(payload);
    };
    EXPECT_EQ(sentences(marched).front(), "it was taken") << step;
  }
  EXPECT_THAT(answers(withStep("1.5")), HasSubstr("other camera or settings than the sender's")) << "said, and not done";
  EXPECT_THAT(sentences(withStep("1.5"))[1], HasSubstr("the setting step is not 0.5"));
  for (const char* step : {"0.25", "2.01", "1000", "nan", "-1", "", "coarse"})
    EXPECT_THAT(answers(withStep(step)), HasSubstr("the setting step is not 0.5")) << step;
  EXPECT_THAT(answers([](net::FrameHead& head, ByteVector&) {
                setOf(head, "step", "1.5");
                setOf(head, "contribution", "0.25");
              }),
              HasSubstr("is not"));
  EXPECT_THAT(answers([](net::FrameHead& head, ByteVector&) { setOf(head, "heuristic", "exit"); }), HasSubstr("the setting heuristic is not gradient"));
  for (const char* allowed : {"0", "41", "many"})
    EXPECT_THAT(answers([&](net::FrameHead& head, ByteVector&) {
                  setOf(head, "step", "1.5");
                  setOf(head, "serverMs", allowed);
                }),
                HasSubstr("is not"))
        << allowed;
  EXPECT_THAT(answers([](net::FrameHead& head, ByteVector&) { std::erase_if(head.settings, [](const auto& field) { return field.name == "serverMs"; }); }),
              HasSubstr("the setting serverMs is not 40"));
}

TEST_F(WrongAnswers, ImpossibleNumbersOfSamplesAndBytesAreNotRead) {
  expectAll([](net::FrameHead& head, ByteVector&) { head.sampleCount = 64 * 48 + 1; },
            "3073 samples, where 3072 are the most");
  expectAll([](net::FrameHead& head, ByteVector&) { head.sampleCount = ~uint64_t{0}; },
            "18446744073709551615 samples, where 3072 are the most");
  // A gibibyte is announced, and zeros keep coming.
  const auto zeros = [&](BareSocket& to, const net::FrameRequest& request) {
    to.send(net::frameMessage(honestHead(request, marcher_->march(camera_, settings_)), net::kMaxFrameBytes - 10'000));
    const net::Bytes some(kMiB);
    while (to.send(some)) continue;
    return false;
  };
  const net::PeakMemory peak;
  EXPECT_THAT(sentences(zeros), testing::Each(HasSubstr("bytes for the samples, where")));
  if (const auto grown = peak.grownBytes(); grown && !net::kIsSanitized) EXPECT_LT(*grown, 32 * kMiB);
}

TEST_F(WrongAnswers, WhatNothingCanBeDrawnFromIsTheFramesFault) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  const std::pair<float net::FrameHead::*, std::vector<float>> numbers[] = {
      {&net::FrameHead::radiusUnit, {0.0f, -1.0f, nan, infinite, 3.0f, 0x1p120f, 0x1p-120f}},
      {&net::FrameHead::nearDepth, {-1.0f, nan, infinite, 1e30f}},
      {&net::FrameHead::depthStep, {0.0f, -1.0f, nan, infinite, 1e15f}},
      {&net::FrameHead::voxelRadius, {0.0f, -1.0f, nan, infinite, 1e30f}},
  };
  const SampleFrame frame = marcher_->march(camera_, settings_);
  net::FrameHead honest = headOf(frame, transport_.codec);
  EXPECT_EQ(faultOf(honest, 100), "");
  const auto faultAfter = [&](auto change) {
    net::FrameHead head = honest;
    change(head);
    return faultOf(head, 100);
  };
  for (const auto& [number, values] : numbers)
    for (const float value : values)
      EXPECT_THAT(faultAfter([&](net::FrameHead& head) { head.*number = value; }), HasSubstr("the server's frame has"))
          << value;
  for (const size_t place : {0, 5})
    for (const float value : {nan, infinite, -infinite, 1e30f, -1e30f})
      EXPECT_THAT(faultAfter([&](net::FrameHead& head) { head.bounds[place] = value; }),
                  HasSubstr("the server's frame has bounds"))
          << value;
  for (const double value : {-1.0, double{nan}, double{infinite}, 1e300})
    EXPECT_EQ(faultAfter([&](net::FrameHead& head) { head.stages.marchMs = value; }),
              "the server's frame has times that are none");
  // Said as it is by every way in, before the payload has come.
  expectAll([](net::FrameHead& head, ByteVector&) { head.radiusUnit = 0x1p120f; },
            "the server's frame has a unit of radii");
}

TEST_F(WrongAnswers, WhatIsWrongInsideAPayloadIsASentence) {
  expectAll([](net::FrameHead&, ByteVector& payload) { payload[payload.size() / 2] ^= std::byte{1}; },
            "the payload is damaged");
  expectAll([](net::FrameHead&, ByteVector& payload) { payload.clear(); }, "another format than its head says");
  expectAll([](net::FrameHead&, ByteVector& payload) { payload[0] = std::byte{0}; },
            "another format than its head says");
  expectAll(
      [&](net::FrameHead& head, ByteVector& payload) {
        SampleFrame frame = marcher_->march(camera_, settings_);
        frame.samples[7] &= kPositionMask;
        head.sampleCount = frame.size();
        payload = FrameCodec().encode(frame, codecFrom(head.codec));
      },
      "the server's frame has samples without a radius");
}

TEST_F(WrongAnswers, PicturesAreJudgedAsFramesAre) {
  const auto sentence = [&](const std::function<void(net::FrameHead&, ByteVector&)>& change) {
    const AdversarialServer server(toFields(scene_), [&](BareSocket& to, const net::FrameRequest& request) {
      Image<glm::vec4> image;
      marcher_->render(camera_, settings_.render, image);
      net::FrameHead head = echoOf(request);
      ByteVector payload = encodeColors(image);
      change(head, payload);
      return to.send(net::frameMessage(head, payload.size())) && to.send(payload);
    });
    const MarcherPtr marcher = connectMarcher(io_, server.address(), transport_, {});
    Image<glm::vec4> image;
    return sentenceOf([&] { marcher->render(camera_, settings_.render, image); });
  };
  EXPECT_EQ(sentence([](net::FrameHead&, ByteVector&) {}), "it was taken");
  EXPECT_THAT(sentence([](net::FrameHead& head, ByteVector&) { head.wanted = net::Wanted::samples; }),
              HasSubstr("samples where a picture was wanted"));
  EXPECT_THAT(sentence([](net::FrameHead& head, ByteVector&) { head.camera.width = 8192; }),
              HasSubstr("a size of 8192x48 pixels, not 64x48"));
  EXPECT_THAT(sentence([](net::FrameHead& head, ByteVector&) { head.sampleCount = 1; }),
              HasSubstr("1 samples in a picture, where 0 are the most"));
  EXPECT_THAT(sentence([](net::FrameHead& head, ByteVector&) {
                head.planes = {{"extent", 2}};
              }),
              HasSubstr("1 planes of samples in a picture"));
  EXPECT_THAT(sentence([](net::FrameHead&, ByteVector& payload) { payload.resize(16 * 64 * 48 + 16 * 4 + 1, std::byte{0}); }),
              HasSubstr("49217 bytes for the picture, where 49216 are the most"));
  EXPECT_THAT(sentence([](net::FrameHead&, ByteVector& payload) { payload.resize(16 * 64 * 48 + 16 * 4, std::byte{0}); }),
              HasSubstr("the server's picture is damaged"));
}

TEST_F(WrongAnswers, PicturesOfNoiseAreWithinTheirBound) {
  std::mt19937 random(3);
  for (const glm::uvec2 size : {glm::uvec2(1, 1), glm::uvec2(37, 11), glm::uvec2(256, 256)}) {
    Image<glm::vec4> image(size.x, size.y);
    for (size_t i = 0; i < image.size(); ++i)
      for (int k = 0; k < 4; ++k) image[i][k] = std::bit_cast<float>(static_cast<uint32_t>(random()));
    EXPECT_EQ(encodeColors(image).size(), mostColorBytes(size.x, size.y)) << "nothing of it can be compressed";
  }
}

/// A march that takes as long as the test wants.
TEST_F(WrongAnswers, ABusyServerIsSaidAndForgottenWithTheAnswer) {
  std::atomic<bool> mayAnswer = false;
  const AdversarialServer server(toFields(scene_), [&](BareSocket& to, const net::FrameRequest& request) {
    to.send(net::busyMessage(7));
    while (!mayAnswer) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const SampleFrame frame = marcher_->march(camera_, settings_);
    const ByteVector payload = FrameCodec().encode(frame, codecFrom(request.codec));
    return to.send(net::frameMessage(honestHead(request, frame), payload.size())) && to.send(payload);
  });
  const ConnectedScene connected = connectScene(io_, server.address(), transport_, [] {}, {});
  std::vector<uint16_t> told;
  const FrameFetch fetch = fetchFrom(connected.source, [&](uint16_t others) {
    told.push_back(others);
    EXPECT_EQ(connected.source->status().busyWith, std::optional<uint16_t>(7));
    mayAnswer = true;
  });
  EXPECT_TRUE(fetch(camera_, settings_, {}).frame);
  EXPECT_THAT(told, AllOf(testing::Not(testing::IsEmpty()), testing::Each(7)));
  EXPECT_EQ(connected.source->status().busyWith, std::nullopt);
  EXPECT_EQ(busySentence(1), "the server is busy with 1 other");
  EXPECT_EQ(busySentence(7), "the server is busy with 7 others");

  std::atomic<int> heard = 0;
  const MarcherPtr marcher =
      connectMarcher(io_, server.address(), transport_, [&](uint16_t others) { heard += others; });
  marcher->march(camera_, settings_);
  EXPECT_EQ(heard, 7);
}

}  // namespace
}  // namespace warpscope
