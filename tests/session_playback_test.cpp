// Recordings shown again in a session: at any time of theirs the frame and the camera that belong to it, by any techniques; stepping, seeking, looping; without
// their volume as well.
// Mirrors app/session/live_playback.h, app/session/recorded_scene.h and app/frames/recorded_frame_source.h.
#include "app/frames/recording_writer.h"
#include "app/session/recorded_scene.h"
#include "app/picture/picture.h"
#include "tests/session_fixture.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

using testing::HasSubstr;

class SessionPlaybackTest : public SessionTest {
 protected:
  static constexpr int kFrames = 4;

  /// Four seconds: a frame each second from 1 on, asked for half a second before it came; the camera turns by 8 degrees a second.
  /// `changed`: shown from 2.5 seconds on by that function, if there is one.
  std::string recorded(const std::string& name, const std::string& text, const std::optional<TransferFunction>& changed = std::nullopt) {
    SceneOverrides overrides;
    overrides.proceduralDims = {16, 16, 16};
    scene_ = openScene("shells", overrides);
    const MarcherPtr marcher = makeMarcher(Backend::cpu, scene_.volume, scene_.transferFunction);
    MarchSettings settings = scene_.march;
    settings.sample.segments = 2;
    settings.sample.proxy = 12;
    RecordingWriter writer(folder_.file(name), scene_, text);
    ProxyPtr proxy;
    for (int i = 0; i <= 80; ++i) {
      const double seconds = 0.05 * i;
      writer.addView(seconds, viewAt(seconds));
      if (changed && i == 50) writer.addFunction(seconds, *changed);
      if (i == 0 || i % 20 != 0) continue;
      auto frame = std::make_shared<SampleFrame>(marcher->march(makeCamera(scene_, viewAt(seconds - 0.5), 40, 48), settings));
      if (proxy) frame->proxy = proxy;
      proxy = frame->proxy;
      frame->requestId = static_cast<uint64_t>(100 + i);
      frames_.push_back(frame);
      writer.addFrame(seconds, frame);
    }
    return folder_.file(name);
  }
  View viewAt(double seconds) const {
    View view = scene_.views.front();
    view.angleDeg += 8.0 * seconds;
    view.distance *= 1.0 + 0.1 * seconds;  // also what directions do not tell
    return view;
  }
  /// What a session over that scene says of itself.
  std::string text(const std::string& scene = "shells") const {
    SessionFile file;
    file.origin.spec = scene;
    file.origin.overrides.proceduralDims = glm::uvec3(16);
    file.panels = {{.technique = &findWarp("points")}, {.technique = &findWarp("segments")}, {.technique = &findWarp("hold")}};
    file.arrangement.ownViews.resize(3);
    file.arrangement.view = View{};
    file.arrangement.march = defaultMarch();
    return textOf(file);
  }
  OriginOpener opener() {
    return [](const SceneOrigin& origin) {
      return LoadJob{origin.spec,
                     [spec = origin.spec](const std::function<void()>& onNews, const std::stop_token& stop) { return openRecording(spec, Backend::cpu, onNews, stop); },
                     origin};
    };
  }
  /// Opened, standing still at its first frame.
  bool openRecorded(const std::string& file) {
    session_.load(opener()({file, {}}));
    if (!pumpUntil([&] { return session_.loading().empty(); }) || !session_.playback().isOpen()) return false;
    session_.playback().setPlaying(false);
    session_.playback().seek(0.0);
    return pumpUntil([&] { return session_.frames().newest() != nullptr; });
  }
  bool shows(size_t frame) {
    return pumpUntil([&] {
      const bool isThere = session_.playback().isAtRest() && session_.frames().newest() && session_.frames().newest()->requestId == frames_[frame]->requestId;
      return isThere && session_.panel(1).requestId == frames_[frame]->requestId && session_.panel(1).picture;
    });
  }

  TestFolder folder_;
  Scene scene_;
  std::vector<SampleFramePtr> frames_;
};

TEST_F(SessionPlaybackTest, FramesAndCameraBelongToTheTime) {
  ASSERT_TRUE(openRecorded(recorded("a.warpscope", text())));
  LivePlayback& playback = session_.playback();
  EXPECT_DOUBLE_EQ(playback.firstSeconds(), 1.0);
  EXPECT_DOUBLE_EQ(playback.lastSeconds(), 4.0);
  EXPECT_EQ(session_.whyNoTruth(), "");
  for (const auto& [seconds, frame] : {std::pair<double, size_t>{1.0, 0}, {2.7, 1}, {4.0, 3}, {1.9, 0}, {3.0, 2}}) {
    SCOPED_TRACE(seconds);
    playback.seek(seconds);
    ASSERT_TRUE(shows(frame));
    EXPECT_EQ(session_.view(), viewAt(seconds));
    EXPECT_EQ(session_.frames().newest()->samples, frames_[frame]->samples);
    EXPECT_EQ(playback.frame(), frame);
    // It was asked for half a second before it came, and left a twentieth later.
    EXPECT_NEAR(session_.ageMs(1, clock_.now()).value_or(-1.0), 1e3 * (seconds - (1.0 + static_cast<double>(frame) - 0.45)), 1e-6);
    EXPECT_NEAR(session_.frames().askedBy(frames_[frame]->requestId)->view.angleDeg, viewAt(0.5 + static_cast<double>(frame)).angleDeg, 1e-9);
    EXPECT_GT(session_.frames().bytesOfNewest().samples, 0u);
    EXPECT_GT(session_.frames().bytesOfNewest().segments, 0u);
    EXPECT_GT(session_.frames().bytesOfNewest().proxy, 0u) << "it came with the first frame";
  }
  EXPECT_TRUE(pumpUntil([&] { return session_.panel(1).errorsAreCurrent; })) << "there is a ground truth";
  EXPECT_FALSE(session_.whyFunctionIsFixed().empty());
  EXPECT_EQ(session_.error(), "");
}

TEST_F(SessionPlaybackTest, TheGroundTruthIsByTheFunctionOfThatTime) {
  TransferFunction changed = openScene("shells", {}).transferFunction;
  for (TransferPoint& point : changed.points) point.alpha *= 0.3f;
  ASSERT_TRUE(openRecorded(recorded("a.warpscope", text(), changed)));
  LivePlayback& playback = session_.playback();
  const TransferFunction first = session_.scene()->transferFunction;
  EXPECT_EQ(first, scene_.transferFunction);
  const auto truthAt = [&](double seconds) -> std::shared_ptr<const PanelPixels> {
    playback.seek(seconds);
    if (!pumpUntil([&] { return playback.isAtRest() && session_.panel(1).errorsAreCurrent && session_.panel(1).currentPixels() != nullptr; })) return nullptr;
    return session_.panel(1).pixels;
  };
  const auto before = truthAt(2.45);
  ASSERT_TRUE(before);
  playback.seek(2.55);
  ASSERT_TRUE(pumpUntil([&] { return session_.scene()->transferFunction == changed; }));
  EXPECT_EQ(session_.frames().newest()->proxy->function, changed) << "what fills gaps as well";
  const auto after = truthAt(2.55);
  ASSERT_TRUE(after);
  const auto opacityOf = [](const PanelPixels& pixels) {
    double sum = 0.0;
    const Image<glm::vec4>& truth = *pixels.inputs().reference;
    for (const glm::vec4& pixel : truth) sum += static_cast<double>(pixel.a);
    return sum;
  };
  EXPECT_LT(opacityOf(*after), 0.8 * opacityOf(*before));
  playback.seek(1.0);
  ASSERT_TRUE(pumpUntil([&] { return session_.scene()->transferFunction == first; }));
  EXPECT_EQ(session_.error(), "");
}

TEST_F(SessionPlaybackTest, StepsStayAndPlayingGoesOnToTheEnd) {
  ASSERT_TRUE(openRecorded(recorded("a.warpscope", text())));
  LivePlayback& playback = session_.playback();
  for (const auto& [by, frame] : {std::pair<int, size_t>{1, 1}, {1, 2}, {-1, 1}, {-5, 0}, {9, 3}}) {
    playback.setPlaying(true);
    playback.step(by);
    EXPECT_FALSE(playback.isPlaying());
    ASSERT_TRUE(shows(frame));
    EXPECT_DOUBLE_EQ(playback.seconds(), 1.0 + static_cast<double>(frame));
  }
  playback.setSpeed(4.0);
  playback.setPlaying(true);  // from the end on: from the beginning
  session_.update(clock_.now());
  EXPECT_LT(playback.seconds(), 2.0);
  ASSERT_TRUE(pumpUntil([&] { return !playback.isPlaying(); }));
  EXPECT_DOUBLE_EQ(playback.seconds(), 4.0);
  EXPECT_TRUE(shows(3));
  playback.setLooping(true);
  playback.setPlaying(true);
  ASSERT_TRUE(pumpUntil([&] { return playback.seconds() > 3.5; }));
  ASSERT_TRUE(pumpUntil([&] { return playback.seconds() < 2.0; }));
  EXPECT_TRUE(playback.isPlaying());
  playback.setSpeed(1e9);
  EXPECT_EQ(playback.speed(), kPlaybackSpeedRange.highest);
}

TEST_F(SessionPlaybackTest, TheHandThatMovesTheCameraHasIt) {
  ASSERT_TRUE(openRecorded(recorded("a.warpscope", text())));
  turn(session_, 30.0);
  const View mine = session_.view();
  session_.playback().seek(3.0);
  ASSERT_TRUE(shows(2));
  EXPECT_FALSE(session_.playback().followsCamera());
  EXPECT_EQ(session_.view(), mine);
  session_.playback().setFollowsCamera(true);
  session_.update(clock_.now());
  EXPECT_EQ(session_.view(), viewAt(3.0));
}

TEST_F(SessionPlaybackTest, WithoutItsVolumeFramesAreShownAndTheRestSaysWhy) {
  for (const std::string& said : {std::string(), text("missing.raw"), text("warp://127.0.0.1:1"), text("torture/of-another-version"), std::string("{}")}) {
    SCOPED_TRACE(said);
    frames_.clear();
    ASSERT_TRUE(openRecorded(recorded("a.warpscope", said)));
    session_.playback().seek(2.0);
    ASSERT_TRUE(shows(1));
    EXPECT_THAT(session_.whyNoTruth(), HasSubstr("no ground truth: "));
    EXPECT_EQ(session_.error(), "");
    session_.setTechnique(0, findWarp("reference"));
    ASSERT_TRUE(pumpUntil([&] { return !session_.panel(0).error.empty(); }));
    EXPECT_THAT(session_.panel(0).error, HasSubstr("no ground truth: "));
    session_.setTechnique(0, findWarp("points"));
    ASSERT_TRUE(pumpUntil([&] { return session_.panel(0).error.empty() && session_.panel(0).picture; }));
  }
}

TEST_F(SessionPlaybackTest, ItIsTheSessionThatWasRecorded) {
  const std::string file = recorded("a.warpscope", text());
  const std::optional<SessionFile> session = sessionFileOfRecording(file);
  ASSERT_TRUE(session);
  EXPECT_EQ(session->origin.spec, file);
  restore(*session, session_, opener());
  ASSERT_TRUE(pumpUntil([&] { return session_.playback().isOpen(); }));
  ASSERT_EQ(session_.panelCount(), 3u);
  EXPECT_EQ(session_.panel(1).technique->name, "segments");
  EXPECT_EQ(sessionFileOf(session_).origin.spec, file) << "it can be saved as a session, and opened again";
  EXPECT_EQ(readSessionText(textForRecording(session_), "text").origin.spec, "shells") << "a recording of it has a ground truth as well";
  EXPECT_FALSE(sessionFileOfRecording(recorded("b.warpscope", "")));
  EXPECT_THROW(sessionFileOfRecording(recorded("c.warpscope", "[]")), InputError);
  session_.load(builtin("block"));
  ASSERT_TRUE(pumpUntil([&] { return session_.scene()->name == "block"; }));
  EXPECT_FALSE(session_.playback().isOpen()) << "another scene ends it";
  EXPECT_TRUE(settle());
}

TEST_F(SessionPlaybackTest, AFrameThatIsDamagedIsASentenceAndOthersGoOn) {
  const std::string file = recorded("a.warpscope", text());
  const Recording recording = readRecording(file);
  ASSERT_EQ(recording.frames.size(), static_cast<size_t>(kFrames));
  {
    std::fstream damaged(file, std::ios::in | std::ios::out | std::ios::binary);
    damaged.seekp(static_cast<std::streamoff>(recording.frames[1].payloadAt));
    const std::string junk(recording.frames[1].payloadBytes, 'x');
    damaged.write(junk.data(), static_cast<std::streamsize>(junk.size()));
  }
  ASSERT_TRUE(openRecorded(file));
  session_.playback().seek(2.0);
  ASSERT_TRUE(pumpUntil([&] { return !session_.error().empty(); }));
  EXPECT_THAT(session_.error(), HasSubstr("frame 2 is damaged"));
  session_.playback().seek(3.0);
  ASSERT_TRUE(shows(2));
  EXPECT_EQ(session_.error(), "");
}

TEST_F(SessionPlaybackTest, PicturesAreExportedWhileTheWindowGoesOn) {
  ASSERT_TRUE(openRecorded(recorded("a.warpscope", text())));
  session_.setTechnique(0, findWarp("reference"));
  ReplayExport& exporting = session_.exporting();
  const auto ended = [&] {
    std::optional<std::string> note;
    EXPECT_TRUE(pumpUntil([&] { return (note = exporting.takeNote()).has_value(); }));
    EXPECT_FALSE(exporting.isAtWork());
    return note.value_or("");
  };
  session_.startExport(folder_.file("out.png"));
  EXPECT_TRUE(exporting.isAtWork());
  EXPECT_EQ(exporting.steps(), 121u) << "four seconds";
  EXPECT_EQ(ended(), "exported 121 pictures: " + folder_.file("out-000001.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_.file("out-000121.png")));
  const Image<Rgba8> picture = readPng(folder_.file("out-000061.png"));
  const auto count = static_cast<uint32_t>(session_.panelCount());
  EXPECT_EQ(picture.width(), count * session_.pictureSize().x + 4 * (count - 1));
  EXPECT_NE(picture, readPng(folder_.file("out-000121.png")));
  EXPECT_THROW(session_.startExport(folder_.file("out.PNG")), InputError) << "pictures of such names are there";
  EXPECT_THROW(session_.startExport(folder_.file("out.avi")), InputError);
  session_.startExport(folder_.file("missing/deeper/out.png"));  // made
  EXPECT_THAT(ended(), HasSubstr("exported 121 pictures"));
  // Given up: nothing of it is there.
  session_.startExport(folder_.file("second.png"));
  ASSERT_TRUE(pumpUntil([&] { return exporting.begun() > 2; }));
  exporting.cancel();
  EXPECT_FALSE(exporting.isAtWork());
  session_.startExport(folder_.file("third.png"));
  EXPECT_THAT(ended(), HasSubstr("third-000001.png"));
  EXPECT_FALSE(std::filesystem::exists(folder_.file("second-000001.png")));
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) EXPECT_EQ(entry.path().string().find("partial"), std::string::npos) << entry.path();
  folder_.write("file", "in the way");
  session_.startExport(folder_.file("file/out.png"));
  EXPECT_THAT(ended(), HasSubstr("not exported: "));
  EXPECT_EQ(folder_.read("file"), "in the way");
}

TEST_F(SessionPlaybackTest, FilmsAreExportedWhereThereIsTheProgramForThem) {
  ASSERT_TRUE(openRecorded(recorded("a.warpscope", text())));
  if (!canFilm()) {
    EXPECT_THROW(session_.startExport(folder_.file("film.mp4")), InputError);
    GTEST_SKIP() << "ffmpeg is not installed";
  }
  folder_.write("film.gif", "an older one");
  for (const char* name : {"film.mp4", "film.gif"}) {
    session_.startExport(folder_.file(name));
    std::optional<std::string> note;
    ASSERT_TRUE(pumpUntil([&] { return (note = session_.exporting().takeNote()).has_value(); }));
    EXPECT_EQ(*note, "exported 121 pictures: " + folder_.file(name));
    EXPECT_GT(std::filesystem::file_size(folder_.file(name)), 5000u);
  }
  size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) files += entry.path().filename() != "a.warpscope";
  EXPECT_EQ(files, 2u) << "the films alone";
}

TEST_F(SessionPlaybackTest, WhatCannotBeExportedIsSaid) {
  EXPECT_THROW(session_.startExport(folder_.file("out.png")), InputError) << "there is no recording";
  ASSERT_TRUE(openRecorded(recorded("a.warpscope", "")));
  session_.setTechnique(0, findWarp("reference"));
  EXPECT_THROW(session_.startExport(folder_.file("out.png")), InputError) << "its volume is not known";
  session_.setTechnique(0, findWarp("hold"));
  session_.startExport(folder_.file("out.png"));
  std::optional<std::string> note;
  ASSERT_TRUE(pumpUntil([&] { return (note = session_.exporting().takeNote()).has_value(); }));
  EXPECT_THAT(*note, HasSubstr("exported 121 pictures"));
}

}  // namespace
}  // namespace warpscope
