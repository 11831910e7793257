// Contexts through EGL: Mesa's surfaceless platform first, else the first device that can make one.
// EGL 1.5 section 3.2; EGL_EXT_platform_base, EGL_EXT_device_enumeration, EGL_KHR_surfaceless_context.
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <array>
#include <cstdio>
#include <cstring>

#include "render/base/error.h"
#include "render/gl/context.h"

namespace warpscope::gl {
namespace {

std::string eglErrorText(const char* call) {
  char text[80];
  std::snprintf(text, sizeof text, "%s failed with error 0x%x", call, static_cast<unsigned>(eglGetError()));
  return text;
}

class EglContext final : public Context {
 public:
  EglContext(EGLDisplay display, EGLContext context, const char* name, std::shared_ptr<EntryPoints> entryPoints)
      : display_(display), context_(context), name_(name), entryPoints_(std::move(entryPoints)) {}
  ~EglContext() override {
    // The display stays initialised: other threads of the process may have contexts on it.
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }
  void makeCurrent() override {
    eglBindAPI(EGL_OPENGL_API);
    if (!eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
      throw InputError(eglErrorText("eglMakeCurrent"));
    entryPoints_->load();
  }
  std::string_view platformName() const override { return name_; }

 private:
  EGLDisplay display_;
  EGLContext context_;
  const char* name_;
  const std::shared_ptr<EntryPoints> entryPoints_;
};

std::unique_ptr<Context> contextOn(EGLDisplay display, const char* name, const std::shared_ptr<EntryPoints>& entryPoints,
                                   std::string& reason) {
  if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) {
    reason += std::string(name) + ": " + eglErrorText("eglInitialize") + "; ";
    return nullptr;
  }
  eglBindAPI(EGL_OPENGL_API);
  constexpr std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, 0, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint configs = 0;
  if (!eglChooseConfig(display, wanted.data(), &config, 1, &configs) || configs == 0) config = EGL_NO_CONFIG_KHR;
  constexpr std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION, 4, EGL_CONTEXT_MINOR_VERSION, 5,
                                             EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
  const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
  if (context == EGL_NO_CONTEXT) {
    reason += std::string(name) + ": " + eglErrorText("eglCreateContext") + "; ";
    return nullptr;
  }
  auto made = std::make_unique<EglContext>(display, context, name, entryPoints);
  try {
    made->makeCurrent();
  } catch (const InputError& error) {
    reason += std::string(name) + ": " + error.what() + "; ";
    return nullptr;
  }
  return made;
}

bool hasClientExtension(const char* name) {
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  return extensions != nullptr && std::strstr(extensions, name) != nullptr;
}

std::unique_ptr<Context> onDevices(const std::shared_ptr<EntryPoints>& entryPoints, std::string& reason) {
  const auto queryDevices = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  if (queryDevices == nullptr) return nullptr;
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint count = 0;
  if (!queryDevices(static_cast<EGLint>(devices.size()), devices.data(), &count)) return nullptr;
  for (EGLint i = 0; i < count; ++i) {
    const EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
    if (auto context = contextOn(display, "EGL device", entryPoints, reason)) return context;
  }
  return nullptr;
}

}  // namespace

std::unique_ptr<Context> makeEglContext(std::string& reason) {
  std::shared_ptr<EntryPoints> entryPoints;
  try {
    entryPoints = std::make_shared<EntryPoints>(eglGetProcAddress, "EGL");
  } catch (const InputError& error) {
    reason = error.what();
    return nullptr;
  }
  std::unique_ptr<Context> context;
  // A device may be a GPU; Mesa's surfaceless platform is what a machine without one has. Mesa lists its software rasteriser as a
  // device too, last, so that asking for devices first is right everywhere.
  if (hasClientExtension("EGL_EXT_device_enumeration") || hasClientExtension("EGL_EXT_device_base"))
    context = onDevices(entryPoints, reason);
  if (!context && hasClientExtension("EGL_MESA_platform_surfaceless"))
    context = contextOn(eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr),
                        "EGL surfaceless", entryPoints, reason);
  if (!context && reason.empty()) reason = "neither devices nor a surfaceless platform are offered";
  return context;
}

}  // namespace warpscope::gl
