// Choosing a context and loading entry points.
// See context.h.
#include "render/gl/context.h"

#include <mutex>

#include "render/core/error.h"

namespace warpscope::gl {
namespace {

std::string glString(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text != nullptr ? text : "?";
}

}  // namespace

std::string Context::renderer() const { return glString(GL_RENDERER); }
std::string Context::version() const { return glString(GL_VERSION); }

void loadFunctions(GLADloadfunc loader) {
  static std::mutex mutex;
  static GLADloadfunc loaded = nullptr;
  const std::scoped_lock lock(mutex);
  if (loaded == loader) return;
  const int version = gladLoadGL(loader);
  if (version < GLAD_MAKE_VERSION(4, 5))
    throw InputError("OpenGL 4.5 is needed, but this driver offers " + std::to_string(GLAD_VERSION_MAJOR(version)) + "." +
                     std::to_string(GLAD_VERSION_MINOR(version)));
  loaded = loader;
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
