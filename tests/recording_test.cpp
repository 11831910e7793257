// Recordings: what was recorded comes back, as much of it as was written; what is damaged is a sentence; replays are the same on every run.
// Mirrors app/frames/recording.h and app/experiment/replay.h.
#include "app/frames/recording.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include "app/experiment/replay.h"
#include "app/frames/recorded_frames.h"
#include "app/frames/recording_format.h"
#include "app/frames/recording_writer.h"
#include "app/frames/wire_fields.h"
#include "render/base/error.h"
#include "tests/headless.h"
#include "tests/session_fixture.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

using testing::HasSubstr;

class RecordingTest : public ::testing::Test {
 protected:
  RecordingTest() {
    SceneOverrides overrides;
    overrides.proceduralDims = {16, 16, 16};
    scene_ = openScene("shells", overrides);
    marcher_ = makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction);
    settings_ = scene_.march;
    settings_.sample.segments = 2;
    settings_.sample.proxy = 12;
    frames_ = {frameAt(0.0, 7), frameAt(20.0, 9)};
  }

  SampleFramePtr frameAt(double angleDeg, uint64_t id) {
    View view = scene_.views.front();
    view.angleDeg += angleDeg;
    auto frame = std::make_shared<SampleFrame>(marcher_->march(makeCamera(scene_, view, 40, 30), settings_));
    frame->requestId = id;
    if (proxy_) frame->proxy = proxy_;
    proxy_ = frame->proxy;
    return frame;
  }
  /// Two seconds: a frame at 0.2 and one at 1, the camera turning all the time.
  std::string recorded(const std::string& name) {
    const std::string file = folder_.file(name);
    RecordingWriter writer(file, scene_, "the text");
    for (int i = 0; i <= 20; ++i) {
      writer.addView(0.1 * i, {.angleDeg = 3.0 * i});
      if (i == 2) writer.addFrame(0.2, frames_[0]);
      if (i == 10) writer.addFrame(1.0, frames_[1]);
    }
    EXPECT_EQ(writer.framesLeftOut(), 0u);
    return file;
  }
  std::string refusalOf(const std::string& bytes) {
    try {
      readRecording(folder_.write("read.warpscope", bytes));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  static std::string bytesOf(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  TestFolder folder_;
  Scene scene_;
  MarcherPtr marcher_;
  MarchSettings settings_;
  ProxyPtr proxy_;
  std::array<SampleFramePtr, 2> frames_;
};

TEST_F(RecordingTest, WhatWasRecordedComesBack) {
  const Recording recording = readRecording(recorded("a.warpscope"));
  EXPECT_EQ(recording.text, "the text");
  EXPECT_EQ(recording.scene.name, scene_.name);
  EXPECT_EQ(recording.scene.geometry().dims, scene_.volume->dims());
  EXPECT_FALSE(recording.scene.volume);
  EXPECT_DOUBLE_EQ(recording.seconds, 2.0);
  EXPECT_DOUBLE_EQ(recording.path.at(1.05).angleDeg, 31.5);
  ASSERT_EQ(recording.frames.size(), 2u);
  RecordedFrames frames(recording);
  EXPECT_EQ(frames.at(0.1), nullptr);
  for (const auto& [seconds, wanted] : {std::pair{0.2, 0}, {0.9, 0}, {1.0, 1}, {5.0, 1}, {0.5, 0}}) {  // back as well
    const SampleFramePtr frame = frames.at(seconds);
    ASSERT_TRUE(frame) << seconds;
    const SampleFrame& expected = *frames_[static_cast<size_t>(wanted)];
    EXPECT_EQ(frame->requestId, expected.requestId);
    EXPECT_EQ(frame->samples, expected.samples);
    EXPECT_EQ(frame->colors, expected.colors) << "without loss";
    EXPECT_EQ(frame->segments.depths, expected.segments.depths);
    EXPECT_EQ(frame->settings, expected.settings);
    EXPECT_EQ(frame->camera, expected.camera);
    ASSERT_TRUE(frame->proxy) << "it was written with the first frame alone";
    EXPECT_EQ(frame->proxy->sizeBytes(), expected.proxy->sizeBytes());
  }
}

TEST_F(RecordingTest, FunctionsHoldFromTheirTimesOn) {
  TransferFunction later = scene_.transferFunction;
  for (TransferPoint& point : later.points) point.alpha *= 0.25f;
  {
    RecordingWriter writer(folder_.file("a.warpscope"), scene_, "");
    writer.addView(0.0, {});
    writer.addFrame(0.2, frames_[0]);
    writer.addFunction(1.0, later);
    writer.addFrame(1.5, frames_[1]);
    writer.addView(2.0, {});
  }
  const Recording recording = readRecording(folder_.file("a.warpscope"));
  ASSERT_EQ(recording.functions.size(), 2u);
  EXPECT_EQ(recording.scene.transferFunction, scene_.transferFunction);
  EXPECT_EQ(*functionAt(recording, 0.99), scene_.transferFunction);
  EXPECT_EQ(*functionAt(recording, 1.0), later);
  RecordedFrames frames(recording);
  for (const auto& [seconds, function] : {std::pair{0.5, scene_.transferFunction}, {1.2, later}, {1.6, later}, {0.2, scene_.transferFunction}}) {
    const SampleFramePtr frame = frames.at(seconds);
    ASSERT_TRUE(frame && frame->proxy);
    EXPECT_EQ(frame->proxy->function, function) << seconds;
  }
  // What marches follows, too.
  ReplaySettings settings;
  settings.columns = {{{&findWarp("reference"), {}}}};
  settings.picturesPerSecond = 2.0;
  settings.width = settings.height = 40;
  settings.hasLabels = false;
  settings.resources.marcher = marcher_;
  std::vector<Image<Rgba8>> pictures;
  replay(recording, settings, [&](size_t, const Image<Rgba8>& picture) { pictures.push_back(picture); }, {});
  ASSERT_EQ(pictures.size(), 5u);
  EXPECT_EQ(pictures[1], pictures[0]);
  EXPECT_NE(pictures[2], pictures[1]) << "the camera stands still, the function does not";
  EXPECT_EQ(pictures[4], pictures[2]);
}

TEST_F(RecordingTest, LinksHoldFromTheirTimesOn) {
  const net::DuplexLinkSettings satellite = net::parseLinkSettings("satellite"), own = net::parseLinkSettings("delay=40,down.rate=2M");
  {
    RecordingWriter writer(folder_.file("a.warpscope"), scene_, "");
    writer.addView(0.0, {});
    writer.addLink(0.5, signOf(satellite, false));
    writer.addLink(1.0, signOf(own, true));
    writer.addLink(2.0, {});
    writer.addView(3.0, {});
  }
  const Recording recording = readRecording(folder_.file("a.warpscope"));
  EXPECT_EQ(linkAt(recording, 0.4), LinkSign{});
  EXPECT_EQ(linkAt(recording, 0.5), signOf(satellite, false));
  EXPECT_EQ(linkAt(recording, 0.5).brief, "Simulated link: satellite, 600 ms round trip");
  EXPECT_EQ(linkAt(recording, 1.9), signOf(own, true));
  EXPECT_EQ(linkAt(recording, 1.9).full, "Simulated outage: nothing passes");
  EXPECT_EQ(linkAt(recording, 2.5), LinkSign{});
  EXPECT_EQ(signOf(own, false).full, "Simulated link: 80 ms round trip, 2 Mbit/s down");
  // One that cannot be is a damaged record.
  std::string bytes = bytesOf(folder_.file("a.warpscope"));
  const size_t at = bytes.find("Simulated link");
  ASSERT_NE(at, std::string::npos);
  std::string other = bytes;
  other[at - 1] = 2;  // neither an outage nor none
  EXPECT_THAT(refusalOf(other), HasSubstr("is damaged"));
  other = bytes;
  other[other.find('\n', at)] = ' ';  // one sign
  EXPECT_THAT(refusalOf(other), HasSubstr("is damaged"));
  // What a terminal or a screen would take for more than text is not shown.
  bytes[at] = '\x1b';
  EXPECT_EQ(refusalOf(bytes), "");
  EXPECT_EQ(linkAt(readRecording(folder_.file("read.warpscope")), 0.5).full.find('\x1b'), std::string::npos);
}

TEST_F(RecordingTest, LabelsBelowPicturesSayWhatWasSimulatedAndHowFarFromTheTruthTheyAre) {
  const auto write = [&](const std::string& name, const LinkSign& sign) {
    RecordingWriter writer(folder_.file(name), scene_, "");
    writer.addView(0.0, {});
    writer.addFrame(0.0, frames_[0]);
    writer.addLink(0.0, sign);
    writer.addView(1.0, {});
  };
  write("plain.warpscope", {});
  write("satellite.warpscope", signOf(net::parseLinkSettings("satellite"), false));
  ReplaySettings settings;
  settings.columns = {{{&findWarp("hold"), {}}}, {{&findWarp("reference"), {}}}};
  settings.picturesPerSecond = 1.0;
  settings.width = settings.height = 200;
  settings.resources.marcher = marcher_;
  const auto first = [&](const std::string& name) {
    std::optional<Image<Rgba8>> picture;
    replay(readRecording(folder_.file(name)), settings, [&](size_t index, const Image<Rgba8>& page) { if (index == 0) picture = page; }, {});
    return *picture;
  };
  /// Whether two pages differ in a line of text below the pictures, counted from 0.
  const auto differ = [&](const Image<Rgba8>& a, const Image<Rgba8>& b, uint32_t line, uint32_t left = 0) {
    constexpr uint32_t kLine = 24;
    for (uint32_t y = settings.height + line * kLine; y < settings.height + (line + 1) * kLine; ++y)
      if (!std::equal(a.row(y) + left, a.row(y) + left + settings.width, b.row(y) + left)) return true;
    return false;
  };
  const Image<Rgba8> plain = first("plain.warpscope"), over = first("satellite.warpscope");
  ASSERT_EQ(plain.height(), 248u);
  EXPECT_FALSE(differ(plain, over, 0));
  EXPECT_TRUE(differ(plain, over, 1)) << "the sign of the link";
  settings.hasErrors = true;
  const Image<Rgba8> judged = first("plain.warpscope");
  ASSERT_EQ(judged.height(), 272u);
  EXPECT_FALSE(differ(plain, judged, 0));
  // Another frame has other errors; the truth has none.
  frames_[0] = frames_[1];
  write("other.warpscope", {});
  const Image<Rgba8> other = first("other.warpscope");
  EXPECT_TRUE(differ(judged, other, 1));
  EXPECT_FALSE(differ(judged, other, 1, settings.width + 4));
}

TEST_F(RecordingTest, AReplayShowsTheContentsThatAreAskedFor) {
  const Recording recording = readRecording(recorded("a.warpscope"));
  ReplaySettings settings;
  settings.picturesPerSecond = 1.0;
  settings.width = settings.height = 64;
  settings.hasLabels = false;
  settings.resources.marcher = marcher_;
  const auto last = [&](const std::vector<ReplayColumn>& columns) {
    settings.columns = columns;
    Image<Rgba8> picture;
    replay(recording, settings, [&](size_t, const Image<Rgba8>& page) { picture = page; }, {});
    return picture;
  };
  const TechniqueInUse spheres{&findWarp("spheres"), {}}, reference{&findWarp("reference"), {}}, hold{&findWarp("hold"), {}};
  const Image<Rgba8> picture = last({{spheres}});
  EXPECT_NE(last({{spheres, PictureContent::depth}}), picture);
  const Image<Rgba8> wide = last({{spheres, PictureContent::flip, 1.0f}}), narrow = last({{spheres, PictureContent::flip, 0.1f}});
  EXPECT_NE(wide, picture);
  EXPECT_NE(wide, narrow) << "the ramp's range";
  // The truth differs from itself nowhere.
  const Image<Rgba8> same = last({{reference, PictureContent::difference}});
  EXPECT_EQ(std::count(same.begin(), same.end(), differenceColor(0.0f)), 64 * 64);
  settings.hasLabels = true;
  settings.width = 320;  // for all of the label
  const Image<Rgba8> wideWithLabel = last({{spheres, PictureContent::flip, 1.0f}}), narrowWithLabel = last({{spheres, PictureContent::flip, 0.1f}});
  EXPECT_FALSE(std::equal(wideWithLabel.row(64), wideWithLabel.row(64) + 24 * 320, narrowWithLabel.row(64))) << "the label's numbers";

  EXPECT_TRUE(needsMarcher(std::vector<ReplayColumn>{{spheres, PictureContent::flip}}, false));
  EXPECT_FALSE(needsMarcher(std::vector<ReplayColumn>{{spheres, PictureContent::depth}}, false));
  settings.columns = {{reference, PictureContent::depth}};
  EXPECT_THROW(requireDrawable(recording, settings), InputError);
  settings.columns = {{hold, PictureContent::segments}};
  EXPECT_THROW(requireDrawable(recording, settings), InputError);
  std::vector<ReplayColumn> columns{{reference, PictureContent::depth}, {spheres, PictureContent::flip}, {spheres, PictureContent::depth}};
  showWhatThereIs(columns, false);
  EXPECT_EQ(columns[0].content, PictureContent::picture);
  EXPECT_EQ(columns[1].content, PictureContent::picture);
  EXPECT_EQ(columns[2].content, PictureContent::depth);
}

TEST_F(RecordingTest, CutOffAnywhereTheRestIsThere) {
  const std::string whole = bytesOf(recorded("a.warpscope"));
  size_t frames = 0, refused = 0;
  for (size_t length = 0; length < whole.size(); length += 97) {
    const std::string why = refusalOf(whole.substr(0, length));
    if (!why.empty()) {
      ++refused;
      EXPECT_THAT(why, testing::AnyOf(HasSubstr("is no recording"), HasSubstr("ends before anything was shown"))) << length;
      continue;
    }
    const Recording recording = readRecording(folder_.file("read.warpscope"));
    EXPECT_GE(recording.frames.size(), frames);
    frames = recording.frames.size();
    RecordedFrames all(recording);
    EXPECT_NO_THROW(all.at(100.0));
  }
  EXPECT_EQ(frames, 2u);
  EXPECT_GT(refused, 0u);
}

TEST_F(RecordingTest, DamageIsASentence) {
  const std::string whole = bytesOf(recorded("a.warpscope"));
  EXPECT_THAT(refusalOf("something else altogether"), HasSubstr("is no recording"));
  EXPECT_THAT(refusalOf(""), HasSubstr("is no recording"));
  EXPECT_THAT(refusalOf(std::string(kRecordingMagic)), HasSubstr("ends before anything"));
  std::string later = whole;
  later[7] = 9;
  EXPECT_THAT(refusalOf(later), HasSubstr("another version"));
  EXPECT_THROW(readRecording(folder_.file("missing")), InputError);
  EXPECT_THROW(readRecording(folder_.path()), InputError);
  const std::vector<Recording::Frame> frames = readRecording(folder_.write("read.warpscope", whole)).frames;
  size_t sentences = 0, inPayloads = 0;
  for (size_t at = 8; at < whole.size(); at += 31) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x5a);
    const size_t before = sentences;
    try {
      const Recording recording = readRecording(folder_.write("read.warpscope", damaged));
      RecordedFrames read(recording);
      for (const double seconds : {0.5, 1.5}) read.at(seconds);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()), "");
      ++sentences;
    }
    if (std::ranges::none_of(frames, [at](const auto& frame) { return at >= frame.payloadAt && at < frame.payloadAt + frame.payloadBytes; })) continue;
    ++inPayloads;
    EXPECT_GT(sentences, before) << "the byte at " << at << " is of a frame that is shown";
  }
  EXPECT_GT(inPayloads, 10u);
}

TEST_F(RecordingTest, WhereNothingCanBeWrittenItSaysSo) {
  ASSERT_EQ(mkfifo(folder_.file("pipe").c_str(), 0600), 0);
  EXPECT_THROW(RecordingWriter(folder_.file("pipe"), scene_, ""), InputError) << "nothing waits for its reader";
  EXPECT_THROW(readRecording(folder_.file("pipe")), InputError);
  EXPECT_THROW(RecordingWriter(folder_.path() / "no" / "folder", scene_, ""), InputError);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(RecordingWriter("/dev/full", scene_, ""), InputError);
}

TEST_F(RecordingTest, AReplayIsTheSameOnEveryRun) {
  const Recording recording = readRecording(recorded("a.warpscope"));
  ReplaySettings settings;
  settings.columns = {{{&findWarp("hold"), {}}}, {{&findWarp("spheres"), {}}}, {{&findWarp("reference"), {}}}};
  settings.picturesPerSecond = 5.0;
  settings.width = 60;
  settings.height = 40;
  settings.resources.marcher = marcher_;
  const auto play = [&] {
    std::vector<Image<Rgba8>> pictures;
    replay(recording, settings, [&](size_t index, const Image<Rgba8>& picture) {
      EXPECT_EQ(index, pictures.size());
      pictures.push_back(picture);
    }, {});
    return pictures;
  };
  const std::vector<Image<Rgba8>> first = play();
  EXPECT_EQ(first.size(), 11u);
  EXPECT_EQ(pictureCount(recording, 5.0), 11u);
  EXPECT_EQ(play(), first);
  EXPECT_EQ(first[0].width(), 3u * 60 + 2 * 4);
  EXPECT_EQ(first[0].height(), replayHeight(settings));
  for (size_t i = 1; i < first.size(); ++i) EXPECT_NE(first[i], first[i - 1]) << "the camera moves";
  // Before the first frame, techniques that need one show nothing; what marches shows the scene.
  const auto isBlank = [&](const Image<Rgba8>& picture, uint32_t left) {
    for (uint32_t y = 0; y < 40; ++y)
      for (uint32_t x = 0; x < 60; ++x)
        if (picture(left + x, y) != picture(0, 0)) return false;
    return true;
  };
  EXPECT_TRUE(isBlank(first[0], 0));
  EXPECT_TRUE(isBlank(first[0], 64));
  EXPECT_FALSE(isBlank(first[0], 128));
  EXPECT_FALSE(isBlank(first[1], 0));
  settings.hasLabels = false;
  EXPECT_EQ(play()[0].height(), 40u);
  std::stop_source stopped;
  stopped.request_stop();
  EXPECT_THROW(replay(recording, settings, [](size_t, const Image<Rgba8>&) {}, stopped.get_token()), OperationCancelled);
}

using SessionRecordingTest = SessionTest;

TEST_F(SessionRecordingTest, FramesAndTheCameraOfASession) {
  const TestFolder folder;
  EXPECT_THROW(session_.startRecording(folder.file("a.warpscope"), ""), InputError) << "without a scene";
  ASSERT_TRUE(open("shells"));
  session_.startRecording(folder.file("a.warpscope"), "text");
  EXPECT_TRUE(session_.isRecording());
  session_.update(clock_.now());
  for (int i = 0; i < 3; ++i) {
    turn(session_, 15.0);
    ASSERT_TRUE(settle());
  }
  session_.stopRecording();
  const Recording recording = readRecording(folder.file("a.warpscope"));
  EXPECT_GE(recording.frames.size(), 4u);
  EXPECT_EQ(marchFrom(recording.frames.back().head.settings).sample.segments, session_.knobs().march.sample.segments) << "for any technique, whatever is on show";
  EXPECT_NEAR(recording.path.at(recording.seconds).angleDeg, session_.view().angleDeg, 1e-9);
  RecordedFrames frames(recording);
  EXPECT_EQ(frames.at(recording.seconds)->samples, session_.frames().newest()->samples);
  // A function that changes is recorded with its time, and the frame that is on show is not recorded anew for it.
  session_.startRecording(folder.file("c.warpscope"), "");
  session_.update(clock_.now());
  TransferFunction function = session_.scene()->transferFunction;
  for (int i = 0; i < 3; ++i) {
    for (TransferPoint& point : function.points) point.alpha *= 0.9f;
    session_.setTransferFunction(function);
    session_.update(clock_.now());
  }
  ASSERT_TRUE(settle());
  session_.stopRecording();
  const Recording changed = readRecording(folder.file("c.warpscope"));
  EXPECT_EQ(changed.functions.size(), 4u);
  EXPECT_LE(changed.frames.size(), 3u);
  EXPECT_EQ(*functionAt(changed, changed.seconds), function);
  // So is what is simulated of the link, outages among it.
  LiveSettings knobs = session_.knobs();
  knobs.transport.link = net::parseLinkSettings("delay=5");
  session_.setKnobs(knobs);
  session_.startRecording(folder.file("d.warpscope"), "");
  session_.update(clock_.now());
  session_.beginOutage(std::chrono::milliseconds(1), clock_.now());
  session_.update(clock_.now());
  ASSERT_TRUE(settle());
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  session_.update(clock_.now());
  session_.startRecording(folder.file("b.warpscope"), "");  // of the one before, the end may still be on its way
  ASSERT_TRUE(pumpUntil([&] { return !session_.isWritingRecording(); }));
  const Recording linked = readRecording(folder.file("d.warpscope"));
  ASSERT_EQ(linked.links.size(), 3u);
  for (size_t i = 0; i < linked.links.size(); ++i) EXPECT_EQ(linked.links[i].sign, signOf(knobs.transport.link, i == 1)) << i;
  ASSERT_TRUE(open("block"));
  EXPECT_FALSE(session_.isRecording()) << "it was of the scene before";
}

TEST_F(SessionRecordingTest, WhoClosesWaitsUntilAllOfItIsWritten) {
  const TestFolder folder;
  ASSERT_TRUE(open("shells"));
  session_.startRecording(folder.file("a.warpscope"), "");
  session_.update(clock_.now());
  for (int i = 0; i < 3; ++i) {
    turn(session_, 15.0);
    ASSERT_TRUE(settle());
  }
  session_.close(milliseconds(0));  // other threads need not have ended by then
  EXPECT_GE(readRecording(folder.file("a.warpscope")).frames.size(), 4u);
  EXPECT_EQ(session_.recordingFailure(), "");
}

}  // namespace
}  // namespace warpscope
