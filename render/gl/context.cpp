// Choosing a context and loading entry points.
// See context.h.
#include "render/gl/context.h"

#include <mutex>

#include "render/base/error.h"

namespace warpscope::gl {
namespace {

std::string glString(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text != nullptr ? text : "?";
}

/// Whose the entry points are.
struct Shared {
  std::mutex mutex;  // of everything below, and of glad's pointers while they are loaded
  GLADloadfunc loader = nullptr;
  std::string platform;
  size_t users = 0;
  bool isLoaded = false;
};
Shared shared;

}  // namespace

std::string Context::renderer() const { return glString(GL_RENDERER); }
std::string Context::version() const { return glString(GL_VERSION); }

bool Context::tryMakeCurrent() noexcept {
  try {
    makeCurrent();
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

EntryPoints::EntryPoints(GLADloadfunc loader, std::string_view platform) {
  const std::scoped_lock lock(shared.mutex);
  if (shared.users > 0 && shared.loader != loader)
    throw InputError(std::string(platform) + " cannot be used while contexts of " + shared.platform + " are alive in this process");
  if (shared.users == 0) {
    shared.loader = loader;
    shared.platform = platform;
  }
  ++shared.users;
}

EntryPoints::~EntryPoints() {
  const std::scoped_lock lock(shared.mutex);
  if (--shared.users == 0) shared.isLoaded = false;  // the next platform's may differ
}

void EntryPoints::load() {
  const std::scoped_lock lock(shared.mutex);
  if (shared.isLoaded) return;
  const int version = gladLoadGL(shared.loader);
  if (version < GLAD_MAKE_VERSION(4, 5))
    throw InputError("OpenGL 4.5 is needed, but this driver offers " + std::to_string(GLAD_VERSION_MAJOR(version)) + "." +
                     std::to_string(GLAD_VERSION_MINOR(version)));
  shared.isLoaded = true;
}

std::unique_ptr<Context> makeHeadlessContext(Platform platform) {
  std::string eglReason, osmesaReason;
  std::unique_ptr<Context> context;
  if (platform != Platform::osmesa) context = makeEglContext(eglReason);
  if (!context && platform != Platform::egl) context = makeOsmesaContext(osmesaReason);
  if (!context) {
    std::string text = "no OpenGL 4.5 context without a window:";
    if (!eglReason.empty()) text += " EGL: " + eglReason + ".";
    if (!osmesaReason.empty()) text += " OSMesa: " + osmesaReason + ".";
    throw InputError(text);
  }
  return context;
}

}  // namespace warpscope::gl
