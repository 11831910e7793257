// GLFW and ImGui, wired together.
// See window.h.
#include "app/ui/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "app/ui/run_window.h"
#include "render/base/error.h"
#include "render/core/expected_break.h"

namespace warpscope::ui {
namespace {

constexpr int kWidth = 1280, kHeight = 800;           // at scale 1
constexpr int kLeastWidth = 640, kLeastHeight = 420;  // at scale 1
constexpr int kUsualRefreshHz = 60;
/// Where the CPU draws the window, and takes longer for it, its pictures are as many as make motion fluent and no more: the rest is for what they show.
constexpr double kCheapFrameMs = 6.0, kDearPeriodMs = 30.0;
constexpr double kIdlePeriodS = 0.5;  // ages go on counting
/// Frames that take longer by themselves are drawn beside what stands back: else that would hardly get on.
constexpr double kMostPausedMs = kDearPeriodMs * 2 / 3;
/// How long what stands back takes to come to the end of a piece, about.
constexpr std::chrono::milliseconds kPiecesEnd(2);
/// What is told of sooner than this after asking for events had waited to be asked for.
constexpr std::chrono::milliseconds kAtOnce(5);

std::string lastGlfwError() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text != nullptr ? text : "unknown reason";
}

/// Events that come through callbacks are noted here; ImGui's own callbacks call these first.
Window& windowOf(GLFWwindow* window) { return *static_cast<Window*>(glfwGetWindowUserPointer(window)); }

int refreshHz() {
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  return mode != nullptr && mode->refreshRate >= 20 ? mode->refreshRate : kUsualRefreshHz;
}

std::string sizeText(const glm::ivec2& size) { return std::to_string(size.x) + "x" + std::to_string(size.y); }

/// What all screens cover together, in screen coordinates; (0, 0) where none is known.
glm::ivec2 screensSize() {
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  glm::ivec2 lower(std::numeric_limits<int>::max()), upper(std::numeric_limits<int>::lowest());
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
    if (mode == nullptr) continue;
    glm::ivec2 corner(0);
    glfwGetMonitorPos(monitors[i], &corner.x, &corner.y);
    lower = glm::min(lower, corner);
    upper = glm::max(upper, corner + glm::ivec2(mode->width, mode->height));
  }
  return lower.x < upper.x ? upper - lower : glm::ivec2(0);
}

/// Throws UsageError for a window in which its parts have no room, or whose pixels no screen has: what they hold is undefined.
void requireSize(const glm::ivec2& size, const glm::ivec2& least) {
  if (size.x < least.x || size.y < least.y)
    throw UsageError("a window of " + sizeText(size) + " is too small: its parts need " + sizeText(least) + " at this scale");
  const glm::ivec2 most = screensSize();
  if (most.x > 0 && (size.x > most.x || size.y > most.y))
    throw UsageError("a window of " + sizeText(size) + " is too large: the screen has " + sizeText(most));
}

KeyChord chordOf(int modifiers) {
  return {.isControl = (modifiers & GLFW_MOD_CONTROL) != 0, .isShift = (modifiers & GLFW_MOD_SHIFT) != 0, .isAlt = (modifiers & GLFW_MOD_ALT) != 0};
}

/// As KeyChord has it; empty for keys that have no name there, and for signs.
std::string nameOfKey(int key, int scancode) {
  if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9) return std::string(1, static_cast<char>('0' + key - GLFW_KEY_0));
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12) return "F" + std::to_string(1 + key - GLFW_KEY_F1);
  switch (key) {
    case GLFW_KEY_ESCAPE: return "Esc";
    case GLFW_KEY_TAB: return "Tab";
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER: return "Enter";
    case GLFW_KEY_SPACE: return "Space";
    case GLFW_KEY_DELETE: return "Delete";
    default: break;
  }
  const char* name = glfwGetKeyName(key, scancode);
  if (name != nullptr && name[0] >= 'a' && name[0] <= 'z' && name[1] == 0) return std::string(1, static_cast<char>(name[0] - 'a' + 'A'));
  return "";
}

}  // namespace

/// Where GLFW's callbacks land.
struct WindowEvents {
  static void onKey(GLFWwindow* glfw, int key, int scancode, int action, int modifiers) {
    Window& window = windowOf(glfw);
    window.hasInput_ = true;
    if (action != GLFW_PRESS) return;
    KeyChord press = chordOf(modifiers);
    press.name = nameOfKey(key, scancode);
    if (!press.name.empty()) window.keyPresses_.push_back(press);
    if (key >= 0) window.pressedKeys_.push_back({key, modifiers});
  }
  /// Signs lie on other keys from keyboard to keyboard: they come as what is typed.
  static void onCharacter(GLFWwindow* glfw, unsigned int codePoint) {
    if (codePoint > 127 || std::strchr("?+,.", static_cast<int>(codePoint)) == nullptr) return;
    windowOf(glfw).keyPresses_.push_back({.name = std::string(1, static_cast<char>(codePoint))});
  }
  static void onButton(GLFWwindow* glfw, int button, int action, int) {
    Window& window = windowOf(glfw);
    window.hasInput_ = true;
    window.feed_->press(button, action == GLFW_PRESS);
    if (button != GLFW_MOUSE_BUTTON_LEFT || action != GLFW_PRESS) return;
    const double reach = DoubleClick::kReachPx * window.scale_;
    if (window.clicks_.press(window.momentOfEvent(), window.feed_->pointer(), reach)) window.isDoubleClicked_ = true;
  }
  static void onMove(GLFWwindow* glfw, double x, double y) {
    windowOf(glfw).hasInput_ = true;
    windowOf(glfw).feed_->movePointer({x, y});
  }
  static void onScroll(GLFWwindow* glfw, double, double) { windowOf(glfw).hasInput_ = true; }
  static void onEnter(GLFWwindow* glfw, int isInside) {
    windowOf(glfw).hasInput_ = true;
    windowOf(glfw).feed_->enter(isInside == GLFW_TRUE);
  }
  static void onSize(GLFWwindow* glfw, int width, int height) {
    windowOf(glfw).hasInput_ = true;
    windowOf(glfw).feed_->setSize({width, height});
  }
  static void onFramebufferSize(GLFWwindow* glfw, int width, int height) {
    windowOf(glfw).hasInput_ = true;
    windowOf(glfw).feed_->setFramebufferSize({width, height});
  }
  static void onDrop(GLFWwindow* glfw, int count, const char** paths) {
    windowOf(glfw).hasInput_ = true;
    windowOf(glfw).droppedFiles_.assign(paths, paths + count);
  }
};

Window::Window(const std::string& title, double uiScale, const std::optional<glm::uvec2>& size, const std::optional<glm::uvec2>& usual) : uiScale_(uiScale) {
  if (glfwInit() != GLFW_TRUE) throw NoDisplay("no window can be opened here: " + lastGlfwError());
  try {
    open(title);
    feed_ = std::make_unique<ImGuiFeed>(window_);
    gl_ = std::make_unique<WindowGl>([](const char* name) { return reinterpret_cast<WindowGl::Function>(glfwGetProcAddress(name)); });
    listen();
    startImGui();
  } catch (...) {
    feed_.reset();
    glfwTerminate();
    throw;
  }
  try {
    warmUp();
    showAt(size, usual);
    beginFrame();  // the first that is shown waits for the screen
    endFrame();
  } catch (...) {
    close();
    throw;
  }
}

Window::~Window() { close(); }

void Window::close() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  feed_.reset();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::open(const std::string& title) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);  // ImGui draws in order; drivers that draw by the CPU are spared memory at each new size
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "warpscope");
  glfwWindowHintString(GLFW_X11_INSTANCE_NAME, "warpscope");
  window_ = glfwCreateWindow(kWidth, kHeight, title.c_str(), nullptr, nullptr);
  if (window_ == nullptr) throw NoDisplay("no window with OpenGL 3.3 can be opened here: " + lastGlfwError());
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
}

void Window::listen() {
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, WindowEvents::onKey);
  glfwSetCharCallback(window_, WindowEvents::onCharacter);
  glfwSetMouseButtonCallback(window_, WindowEvents::onButton);
  glfwSetCursorPosCallback(window_, WindowEvents::onMove);
  glfwSetScrollCallback(window_, WindowEvents::onScroll);
  glfwSetCursorEnterCallback(window_, WindowEvents::onEnter);
  glfwSetWindowSizeCallback(window_, WindowEvents::onSize);
  glfwSetFramebufferSizeCallback(window_, WindowEvents::onFramebufferSize);
  glfwSetDropCallback(window_, WindowEvents::onDrop);
}

void Window::startImGui() {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
  io.ConfigWindowsMoveFromTitleBarOnly = true;
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
  followScale(true);
}

void Window::warmUp() {
  beginFrame();
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled({0.0f, 0.0f}, {1.0f, 1.0f}, ImGui::ColorConvertFloat4ToU32(palette().frame));
  // Drivers that compile do so for each kind of picture: with a power of two of pixels or not, smooth or not.
  std::vector<std::unique_ptr<PictureTexture>> textures;
  for (const uint32_t length : {2u, 3u})
    for (const bool isSmooth : {false, true}) {
      if (isSmooth && gl_->isDrawnByCpu) continue;  // never drawn so
      PictureTexture& texture = *textures.emplace_back(std::make_unique<PictureTexture>(*gl_));
      texture.show({std::make_shared<const Image<Rgba8>>(length, length), nullptr});
      texture.setSmooth(isSmooth);
      texture.draw(list, {0.0f, 0.0f}, {1.0f, 1.0f});
      list.AddImage(texture.id(), {0.0f, 0.0f}, {1.0f, 1.0f});  // as the loupe does
    }
  endFrame();
}

void Window::showAt(const std::optional<glm::uvec2>& size, const std::optional<glm::uvec2>& usual) {
  // The usual size, as far as the screen has room for it.
  int x = 0, y = 0, width = 0, height = 0;
  if (GLFWmonitor* monitor = glfwGetPrimaryMonitor()) glfwGetMonitorWorkarea(monitor, &x, &y, &width, &height);
  const auto fitted = [&](int length, int room) {
    const int wanted = static_cast<int>(std::lround(static_cast<float>(length) * scale_));
    return room > 0 ? std::min(wanted, room) : wanted;
  };
  const glm::ivec2 least(fitted(kLeastWidth, width), fitted(kLeastHeight, height));
  if (size) requireSize(glm::ivec2(*size), least);
  glm::ivec2 chosen(fitted(kWidth, width), fitted(kHeight, height));
  if (usual && width > 0) chosen = glm::max(least, glm::ivec2(fitted(static_cast<int>(usual->x), width), fitted(static_cast<int>(usual->y), height)));
  if (size) chosen = glm::ivec2(*size);
  glfwSetWindowSizeLimits(window_, least.x, least.y, GLFW_DONT_CARE, GLFW_DONT_CARE);
  glfwSetWindowSize(window_, chosen.x, chosen.y);
  // In the middle; a window that covers more than the work area begins where that does.
  if (width > 0) glfwSetWindowPos(window_, x + std::max(0, width - chosen.x) / 2, y + std::max(0, height - chosen.y) / 2);
  glfwShowWindow(window_);
  feed_->askForSizes();
}

void Window::followScale(bool isFirst) {
  float contentScale = 1.0f, ignored = 1.0f;
  glfwGetWindowContentScale(window_, &contentScale, &ignored);
  const int width = feed_->size().x, pixelsWide = feed_->framebufferSize().x;
  // Where a window's unit is a pixel (X11) all of the content scale is ImGui's business, where it is not (macOS) none of it.
  const float pixelsPerUnit = width > 0 && pixelsWide > 0 ? static_cast<float>(pixelsWide) / static_cast<float>(width) : pixelsPerUnit_;
  const float wanted = uiScale_ > 0.0 ? static_cast<float>(uiScale_) : contentScale / pixelsPerUnit;
  const float scale = std::clamp(wanted, 0.5f, 4.0f);
  if (!isFirst && std::abs(scale - scale_) < 0.01f && std::abs(pixelsPerUnit - pixelsPerUnit_) < 0.01f) return;
  scale_ = scale;
  pixelsPerUnit_ = pixelsPerUnit;
  fonts_ = applySizes(scale_, pixelsPerUnit_);
  if (!isFirst) {
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
  }
}

bool Window::shouldClose() const { return glfwWindowShouldClose(window_) == GLFW_TRUE; }

void Window::keepOpen() { glfwSetWindowShouldClose(window_, GLFW_FALSE); }

glm::uvec2 Window::size() const {
  if (isFullScreen()) return glm::uvec2(beforeFullScreen_.size);
  return glm::uvec2(feed_->size());
}

void Window::setTitle(const std::string& title) { glfwSetWindowTitle(window_, title.c_str()); }

bool Window::isHeld(const KeyChord& key) const {
  const auto isDown = [&](int code) { return glfwGetKey(window_, code) == GLFW_PRESS; };
  if (key.name == "Shift") return isDown(GLFW_KEY_LEFT_SHIFT) || isDown(GLFW_KEY_RIGHT_SHIFT);
  for (int code = GLFW_KEY_A; code <= GLFW_KEY_Z; ++code)
    if (isDown(code) && nameOfKey(code, glfwGetKeyScancode(code)) == key.name) return true;
  return false;
}

bool Window::isFullScreen() const { return glfwGetWindowMonitor(window_) != nullptr; }

void Window::setFullScreen(bool isFullScreen) {
  if (isFullScreen == this->isFullScreen()) return;
  if (!isFullScreen) {
    const auto& [at, size] = beforeFullScreen_;
    glfwSetWindowMonitor(window_, nullptr, at.x, at.y, size.x, size.y, GLFW_DONT_CARE);
    return;
  }
  glfwGetWindowPos(window_, &beforeFullScreen_.at.x, &beforeFullScreen_.at.y);
  glfwGetWindowSize(window_, &beforeFullScreen_.size.x, &beforeFullScreen_.size.y);
  const glm::ivec2 middle = beforeFullScreen_.at + beforeFullScreen_.size / 2;
  int count = 0;
  GLFWmonitor** const monitors = glfwGetMonitors(&count);
  GLFWmonitor* chosen = glfwGetPrimaryMonitor();
  for (int i = 0; i < count; ++i) {
    const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
    glm::ivec2 corner(0);
    glfwGetMonitorPos(monitors[i], &corner.x, &corner.y);
    const bool holdsMiddle = mode != nullptr && middle.x >= corner.x && middle.y >= corner.y && middle.x < corner.x + mode->width && middle.y < corner.y + mode->height;
    if (holdsMiddle) chosen = monitors[i];
  }
  const GLFWvidmode* mode = chosen != nullptr ? glfwGetVideoMode(chosen) : nullptr;
  if (mode != nullptr) glfwSetWindowMonitor(window_, chosen, 0, 0, mode->width, mode->height, mode->refreshRate);
}

bool Window::isDear() const { return gl_->isDrawnByCpu && frameMs_ > kCheapFrameMs; }

void Window::waitForNextFrame(bool isMoving) {
  othersPause_.reset();  // only now: who is woken may well run at once, instead of this thread
  if (!isMoving && !hasInput_) takeEvents(kIdlePeriodS);
  // Drivers without a screen to wait for swap at once; a little less than a period leaves the pace to those that do wait.
  const double periodMs = 900.0 / refreshHz();
  const auto due = frameBegan_ + durationOfMs(isDear() ? std::max(kDearPeriodMs, periodMs) : periodMs);
  // By itself: where one was held up, what stands back has to pause all the more.
  const bool doOthersPause = isDear() && *std::ranges::min_element(lastFramesMs_) < kMostPausedMs;
  if (doOthersPause) expectBreak(due - kPiecesEnd);
  takeEvents(0.0);
  const auto takeEventsUntil = [&](Clock::TimePoint time) {
    for (auto now = Clock::TimePoint::clock::now(); now < time && !shouldClose(); now = Clock::TimePoint::clock::now())
      takeEvents(std::chrono::duration<double>(time - now).count());
  };
  if (doOthersPause) {
    takeEventsUntil(due - kPiecesEnd);
    othersPause_.emplace();
  }
  takeEventsUntil(due);
}

void Window::takeEvents(double patienceS) {
  askedForEvents_ = Clock::TimePoint::clock::now();
  if (patienceS > 0.0)
    glfwWaitEventsTimeout(patienceS);
  else
    glfwPollEvents();
  tookEvents_ = Clock::TimePoint::clock::now();
}

Moment Window::momentOfEvent() const {
  // GLFW does not say when an event happened. One that is waited for is told of as it comes; others came since GLFW was last asked.
  const Clock::TimePoint now = Clock::TimePoint::clock::now();
  return {now - askedForEvents_ < kAtOnce ? tookEvents_ : now, now};
}

void Window::wake() { glfwPostEmptyEvent(); }

void Window::beginFrame() {
  frameBegan_ = Clock::TimePoint::clock::now();
  hadInput_ = std::exchange(hasInput_, false);
  followScale(false);
  ImGui_ImplOpenGL3_NewFrame();
  feed_->beginFrame();
  holdShortKeys();
  ImGui::NewFrame();
}

void Window::holdShortKeys() {
  // ImGui 1.86 looks at keys once a frame; one that was pressed and released since the last would be lost, and so would what was held with it.
  ImGuiIO& io = ImGui::GetIO();
  for (const int key : heldKeys_) io.KeysDown[key] = glfwGetKey(window_, key) == GLFW_PRESS;
  heldKeys_.clear();
  io.KeyCtrl = io.KeysDown[GLFW_KEY_LEFT_CONTROL] || io.KeysDown[GLFW_KEY_RIGHT_CONTROL];
  io.KeyShift = io.KeysDown[GLFW_KEY_LEFT_SHIFT] || io.KeysDown[GLFW_KEY_RIGHT_SHIFT];
  io.KeyAlt = io.KeysDown[GLFW_KEY_LEFT_ALT] || io.KeysDown[GLFW_KEY_RIGHT_ALT];
  for (const auto& [key, modifiers] : std::exchange(pressedKeys_, {})) {
    io.KeyCtrl |= (modifiers & GLFW_MOD_CONTROL) != 0;
    io.KeyShift |= (modifiers & GLFW_MOD_SHIFT) != 0;
    io.KeyAlt |= (modifiers & GLFW_MOD_ALT) != 0;
    if (io.KeysDown[key]) continue;
    io.KeysDown[key] = true;
    heldKeys_.push_back(key);
  }
  // A field takes no characters while Ctrl is down: what was typed after a shortcut, in one frame with it, waits for the next.
  laterCharacters_.insert(laterCharacters_.end(), io.InputQueueCharacters.begin(), io.InputQueueCharacters.end());
  io.ClearInputCharacters();
  if (io.KeyCtrl && !io.KeyAlt) return;
  for (const unsigned int character : std::exchange(laterCharacters_, {})) io.AddInputCharacter(character);
}

void Window::endFrame(Image<Rgba8>* photograph) {
  ImGui::Render();
  const glm::ivec2 size = feed_->framebufferSize();
  gl_->viewport(0, 0, size.x, size.y);
  gl_->clearColor(palette().frame.x, palette().frame.y, palette().frame.z, 1.0f);
  gl_->clear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  if (photograph != nullptr && size.x > 0 && size.y > 0) *photograph = readPicture(*gl_, glm::uvec2(size));
  glfwSwapBuffers(window_);
  const double ms = millisecondsBetween(frameBegan_, Clock::TimePoint::clock::now());
  frameMs_ += 0.2 * (ms - frameMs_);
  std::ranges::rotate(lastFramesMs_, lastFramesMs_.begin() + 1);
  lastFramesMs_.back() = ms;
}

}  // namespace warpscope::ui
