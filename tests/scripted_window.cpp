// Frames for scripts.
// See scripted_window.h.
#include "tests/scripted_window.h"

namespace warpscope::ui {
namespace {

/// Stands in for any function of OpenGL that gives nothing back: the caller's arguments are the caller's.
void doNothing() {}
void makeName(GLsizei count, GLuint* names) {
  for (GLsizei i = 0; i < count; ++i) names[i] = 1;
}
const GLubyte* sayNothing(GLenum) { return nullptr; }

WindowGl::Function functionFor(const char* name) {
  const std::string_view wanted(name);
  if (wanted == "glGenTextures") return reinterpret_cast<WindowGl::Function>(makeName);
  if (wanted == "glGetString") return reinterpret_cast<WindowGl::Function>(sayNothing);
  return doNothing;
}

}  // namespace

WindowGl noGl() { return WindowGl(functionFor); }

ScriptedWindow::ScriptedWindow(const glm::uvec2& size, Session& session, const SceneOpener& openScene, std::unique_ptr<DrawnWindow> drawn)
    : session_(session), context_(ImGui::CreateContext()), drawn_(std::move(drawn)), gl_(drawn_ ? drawn_->gl() : noGl()), view_(gl_, openScene, std::nullopt, remembered, [] {}) {
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.DeltaTime = 1.0f / 60.0f;
  io.ConfigWindowsMoveFromTitleBarOnly = true;
  io.ClipboardUserData = this;
  io.SetClipboardTextFn = [](void* window, const char* text) { static_cast<ScriptedWindow*>(window)->clipboard_ = text; };
  io.GetClipboardTextFn = [](void* window) { return static_cast<ScriptedWindow*>(window)->clipboard_.c_str(); };
  for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;  // scripts press these
  resize(size);
  fonts_ = applySizes(1.0f, 1.0f);
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  if (drawn_)
    drawn_->begin();
  else
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  frames(2);
}

ScriptedWindow::~ScriptedWindow() {
  if (drawn_) drawn_->end();
  ImGui::DestroyContext(context_);
}

void ScriptedWindow::frame() {
  const auto now = clock_.now();
  session_.update(now);
  if (drawn_) drawn_->beginFrame();
  ImGui::NewFrame();
  view_.draw(session_, 60.0, held, {fonts_, 1.0f, 1.0f, now, &hover_, std::exchange(isDoubleClick_, false)});
  ImGui::Render();
  ImGui::GetIO().MouseWheel = 0.0f;
}

void ScriptedWindow::frames(int count) {
  for (int i = 0; i < count; ++i) frame();
}

void ScriptedWindow::moveTo(const glm::vec2& at) {
  ImGui::GetIO().MousePos = {at.x, at.y};
  frame();
}

void ScriptedWindow::hold(int button, bool isDown) {
  ImGui::GetIO().MouseDown[button] = isDown;
  frame();
}

void ScriptedWindow::click(const glm::vec2& at, int button) {
  moveTo(at);
  hold(button, true);
  hold(button, false);
  frame();
}

void ScriptedWindow::doubleClick(const glm::vec2& at) {
  moveTo(at);
  isDoubleClick_ = true;
  hold(0, true);
  hold(0, false);
}

void ScriptedWindow::drag(const glm::vec2& from, const glm::vec2& to, int button) {
  moveTo(from);
  hold(button, true);
  for (int i = 1; i <= 4; ++i) moveTo(glm::mix(from, to, static_cast<float>(i) / 4.0f));
  hold(button, false);
}

void ScriptedWindow::wheel(float notches) {
  ImGui::GetIO().MouseWheel = notches;
  frame();
}

void ScriptedWindow::key(const KeyChord& chord) {
  view_.press(chord, session_);
  frame();
}

void ScriptedWindow::type(const std::string& text) {
  ImGui::GetIO().AddInputCharactersUTF8(text.c_str());
  frame();
}

}  // namespace warpscope::ui
