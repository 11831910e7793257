// Sessions in files: what is saved comes back as it was; what is wrong is named with its line; the command shows the same.
// Mirrors app/session/session_file.h and app/shell/user_folders.h.
#include "app/session/session_file.h"

#include <cstdlib>

#include "app/shell/user_folders.h"
#include "net/link_settings.h"
#include "render/warp/fill.h"
#include "app/scene/json_document.h"
#include "tests/session_fixture.h"
#include "tests/test_folder.h"

namespace warpscope {
namespace {

using testing::HasSubstr;

class SessionFileTest : public SessionTest {
 protected:
  LoadJob jobOf(const SceneOrigin& origin) {
    LoadJob job = builtin(origin.spec);
    job.origin = origin;
    return job;
  }
  bool openOriginal() {
    session_.load(jobOf({"shells", {}}));
    return settle();
  }
  /// Tests' is smaller.
  void useUsualServerSide() {
    LiveSettings knobs = session_.knobs();
    knobs.serverSidePx = LiveSettings{}.serverSidePx;
    session_.setKnobs(knobs);
  }
  std::string refusalOf(const std::string& text) const {
    try {
      readSessionFile(folder_.write("session.json", text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TestFolder folder_;
};

TEST_F(SessionFileTest, WhatIsSavedComesBack) {
  ASSERT_TRUE(openOriginal());
  session_.addPanel({.technique = &findWarp("points")});
  session_.setContent(1, PictureContent::holes);
  session_.setContent(0, PictureContent::difference, 0.25f);
  KnobValues own;
  own.set(kFillKnob, Fill::pullPush);
  session_.setPanelKnobs(1, own);
  session_.setOwnCamera(2, true);
  session_.setView(2, {.angleDeg = 33.0});
  session_.setView({.angleDeg = 12.5, .elevationDeg = -7.0, .distance = 1.5, .pan = {0.1, -0.2}});
  LiveSettings knobs = session_.knobs();
  knobs.march.sample.heuristic = Heuristic::median;
  knobs.march.render.effects.shading.strength = 0.5f;
  knobs.transport.link = net::parseLinkSettings("satellite");
  knobs.transport.link.down.loss = 0.02;
  knobs.transport.codec.jpegQuality = 77;
  knobs.marks = {0xff0000ffu, 0xff00ff00u};
  knobs.serverSidePx = 64;
  session_.setKnobs(knobs);
  TransferFunction function = session_.scene()->transferFunction;
  for (TransferPoint& point : function.points) point.alpha *= 0.5f;
  session_.setTransferFunction(function);
  ASSERT_TRUE(pumpUntil([&] { return session_.panel(2).picture; }));

  const SessionFile saved = sessionFileOf(session_);
  const SessionFile read = readSessionFile(folder_.write("session.json", textOf(saved)));
  EXPECT_EQ(textOf(read), textOf(saved));
  Session other(settings(), [] {});
  other.setPanelSize(kPanelPx);
  restore(read, other, [&](const SceneOrigin& origin) { return jobOf(origin); });
  ASSERT_TRUE(pumpUntil(other, [&] { return other.scene() != nullptr && other.panel(2).picture; }));
  EXPECT_EQ(textOf(sessionFileOf(other)), textOf(saved));
  EXPECT_EQ(other.panelCount(), 3u);
  EXPECT_EQ(other.view(), session_.view());
  EXPECT_EQ(other.view(2), session_.view(2));
  EXPECT_EQ(other.panel(0).contentRange, 0.25f);
  EXPECT_EQ(other.panel(1).knobs, own);
  EXPECT_EQ(other.knobs().march, session_.knobs().march);
  EXPECT_EQ(other.knobs().transport, session_.knobs().transport);
  EXPECT_EQ(other.knobs().marks, session_.knobs().marks);
  ASSERT_EQ(other.scene()->transferFunction.points.size(), function.points.size());
  for (size_t i = 0; i < function.points.size(); ++i) EXPECT_FLOAT_EQ(other.scene()->transferFunction.points[i].alpha, function.points[i].alpha);
}

TEST_F(SessionFileTest, WithMorePanelsThanBeforeAndWithFewer) {
  ASSERT_TRUE(openOriginal());
  SessionFile file = sessionFileOf(session_);
  const auto opener = [&](const SceneOrigin& origin) { return jobOf(origin); };
  for (const size_t count : {6u, 1u, 4u}) {
    file.panels.assign(count, {.technique = &findWarp("hold")});
    file.arrangement.ownViews.assign(count, std::nullopt);
    restore(file, session_, opener);
    ASSERT_TRUE(pumpUntil([&] { return session_.loading().empty(); }));
    EXPECT_EQ(session_.panelCount(), count);
    ASSERT_TRUE(settle());
  }
}

TEST_F(SessionFileTest, WhereItsSceneCannotBeOpenedAllStaysAsItIs) {
  ASSERT_TRUE(openOriginal());
  const std::string before = textOf(sessionFileOf(session_));
  SessionFile file = sessionFileOf(session_);
  file.panels.assign(5, {.technique = &findWarp("hold")});
  file.arrangement.ownViews.assign(5, std::nullopt);
  file.knobs.budgetMs = 77.0;
  restore(file, session_, [&](const SceneOrigin& origin) {
    return LoadJob{.name = origin.spec, .open = [](const std::function<void()>&, const std::stop_token&) -> ConnectedScene { throw InputError("it is gone"); }};
  });
  ASSERT_TRUE(pumpUntil([&] { return session_.loading().empty(); }));
  EXPECT_EQ(session_.error(), "it is gone");
  EXPECT_EQ(textOf(sessionFileOf(session_)), before);
}

TEST_F(SessionFileTest, WithoutASceneOrItsNameThereIsNothingToSave) {
  EXPECT_THROW(sessionFileOf(session_), InputError);
  ASSERT_TRUE(open("block"));  // by a job that has no origin
  EXPECT_THROW(sessionFileOf(session_), InputError);
  EXPECT_THROW(commandLineOf(session_), InputError);
}

TEST_F(SessionFileTest, WhatIsWrongIsNamedWithItsLine) {
  ASSERT_TRUE(openOriginal());
  const std::string good = textOf(sessionFileOf(session_));
  EXPECT_EQ(refusalOf(good), "");
  const auto with = [&](std::string_view before, std::string_view after) {
    std::string text = good;
    const size_t at = text.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    return text.replace(at, before.size(), after);
  };
  EXPECT_THAT(refusalOf(with("\"warpscopeSession\": 1", "\"warpscopeSession\": 2")), HasSubstr("later program"));
  EXPECT_THAT(refusalOf(with("\"hold\"", "\"held\"")), testing::AllOf(HasSubstr("session.json:"), HasSubstr("technique")));
  EXPECT_THAT(refusalOf(with("\"link\": \"none\"", "\"link\": \"string\"")), HasSubstr("link"));
  EXPECT_THAT(refusalOf(with("\"budgetMs\"", "\"budget\"")), HasSubstr("budget"));
  EXPECT_THAT(refusalOf("{}"), HasSubstr("warpscopeSession"));
  EXPECT_THAT(refusalOf("[]"), testing::Not(""));
  EXPECT_TRUE(isSession(JsonDocument(good, "session.json")));
  EXPECT_FALSE(isSession(JsonDocument("{}", "other.json")));
  EXPECT_FALSE(isSession(JsonDocument("[]", "other.json")));
}

TEST_F(SessionFileTest, TheCommandHasWhatOptionsSay) {
  SceneOrigin origin{"shells", {}};
  origin.overrides.proceduralDims = glm::uvec3(16);
  session_.load(jobOf(origin));
  ASSERT_TRUE(settle());
  useUsualServerSide();
  EXPECT_EQ(commandLineOf(session_), "warpscope view shells --volume-size 16x16x16 --panels hold,spheres");
  LiveSettings knobs = session_.knobs();
  knobs.march.sample.heuristic = Heuristic::median;
  knobs.transport.link = net::parseLinkSettings("4g");
  session_.setKnobs(knobs);
  session_.setAutomatic(0);
  EXPECT_EQ(commandLineOf(session_), "warpscope view shells --volume-size 16x16x16 --panels auto,spheres --heuristic median --link 4g");
  knobs.marks = {0xff0080ffu, 0xff00ff00u};
  knobs.budgetMs = 12.5;
  knobs.takesShortcuts = kShortcutsKnob.defaultValue == 0.0;
  session_.setKnobs(knobs);
  EXPECT_THAT(commandLineOf(session_), testing::EndsWith(" --uncovered ff8000 --filled 00ff00 --budget-ms 12.5 --shortcuts " + textOf(kShortcutsKnob, knobs.takesShortcuts ? 1.0 : 0.0)));
}

TEST_F(SessionFileTest, TheCommandHasTheOptionsThatTheSceneWasOpenedWith) {
  LoadJob job = jobOf({"shells", {}});
  job.open = [open = std::move(job.open)](const std::function<void()>& onNews, const std::stop_token& stop) {
    ConnectedScene opened = open(onNews, stop);
    opened.scene.describedMarch = opened.scene.march;
    opened.scene.march.sample.heuristic = Heuristic::median;
    return opened;
  };
  session_.load(std::move(job));
  ASSERT_TRUE(settle());
  useUsualServerSide();
  EXPECT_EQ(commandLineOf(session_), "warpscope view shells --panels hold,spheres --heuristic median");
}

TEST_F(SessionFileTest, TheCommandHasTheSessionWhereOptionsDoNotSayAll) {
  ASSERT_TRUE(openOriginal());
  useUsualServerSide();
  const std::string begin = "warpscope view --session '", plain = commandLineOf(session_);
  ASSERT_THAT(plain, testing::Not(HasSubstr("--session")));
  const auto readBack = [&](const std::string& line) {
    EXPECT_THAT(line, testing::AllOf(testing::StartsWith(begin), testing::EndsWith("'"), testing::Not(HasSubstr("\n"))));
    return readSessionText(line.substr(begin.size(), line.size() - begin.size() - 1), "--session");
  };
  View view = session_.view();
  view.angleDeg = 33.0;
  session_.setView(view);
  SessionFile read = readBack(commandLineOf(session_));
  EXPECT_FALSE(read.arrangement.transferFunction) << "the scene has it";
  read.arrangement.transferFunction = session_.scene()->transferFunction;
  EXPECT_EQ(textOf(read), textOf(sessionFileOf(session_)));
  session_.resetView();
  EXPECT_EQ(commandLineOf(session_), plain);

  session_.setContent(1, PictureContent::flip, 0.25f);
  EXPECT_EQ(readBack(commandLineOf(session_)).panels[1].contentRange, 0.25f);
  session_.setContent(1, PictureContent::picture);
  LiveSettings knobs = session_.knobs();
  knobs.serverSidePx = 300;
  session_.setKnobs(knobs);
  EXPECT_EQ(readBack(commandLineOf(session_)).knobs.serverSidePx, 300u);
  knobs.serverSidePx = LiveSettings{}.serverSidePx;
  session_.setKnobs(knobs);
  EXPECT_EQ(commandLineOf(session_), plain);

  KnobValues first = session_.panel(0).knobs;
  const std::vector<const Knob*> knobsOfWarps = warpKnobs();
  const Knob& ofPanel = **std::ranges::find_if(knobsOfWarps, [](const Knob* knob) { return knob->isOfPanel && knob->choices.empty(); });
  first.set(ofPanel, ofPanel.range.highest);
  session_.setPanelKnobs(0, first);
  EXPECT_EQ(readBack(commandLineOf(session_)).panels[0].knobs[ofPanel], ofPanel.range.highest) << "options are those of the other panels";
  session_.setPanelKnobs(0, {});
  EXPECT_EQ(commandLineOf(session_), plain);

  session_.setOwnCamera(1, true);
  EXPECT_TRUE(readBack(commandLineOf(session_)).arrangement.ownViews[1].has_value());
  session_.setOwnCamera(1, false);
  TransferFunction function = session_.scene()->transferFunction;
  function.points.front().alpha = 0.125f;
  session_.setTransferFunction(function);
  EXPECT_EQ(textOf(readBack(commandLineOf(session_))), textOf(sessionFileOf(session_)));

  function.points.clear();
  for (size_t i = 0; i < 4000; ++i) function.points.push_back({.value = static_cast<double>(i) / 3000.0, .color = glm::vec3(0.1f / 3.0f, 0.7f, 0.1f), .alpha = 0.3f});
  session_.setTransferFunction(function);
  EXPECT_THROW(commandLineOf(session_), InputError) << "more than one argument may be long";
}

TEST(UserFolders, FollowTheXdgSpecification) {
  const char* const state = std::getenv("XDG_STATE_HOME");
  const std::optional<std::string> before = state != nullptr ? std::optional<std::string>(state) : std::nullopt;
  setenv("XDG_STATE_HOME", "/somewhere", 1);
  EXPECT_EQ(stateFolder(), std::filesystem::path("/somewhere/warpscope"));
  EXPECT_EQ(lastSessionFile(), std::filesystem::path("/somewhere/warpscope/last-session.json"));
  setenv("XDG_STATE_HOME", "not/absolute", 1);
  EXPECT_TRUE(!stateFolder() || stateFolder()->parent_path().filename() == "state");
  if (before)
    setenv("XDG_STATE_HOME", before->c_str(), 1);
  else
    unsetenv("XDG_STATE_HOME");
}

}  // namespace
}  // namespace warpscope
