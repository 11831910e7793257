// Headless OpenGL 4.5 core contexts through EGL (surfaceless, else a device) or OSMesa, and the function pointers that go with them.
// EGL_MESA_platform_surfaceless, EGL_EXT_platform_device; Mesa's off-screen interface.
#pragma once

#include <glad/gl.h>

#include <array>
#include <memory>
#include <string>
#include <string_view>

#include "render/base/named_value.h"

namespace warpscope::gl {

/// How to reach OpenGL without a window. `automatic` tries EGL, then OSMesa.
enum class Platform { automatic, egl, osmesa };

inline constexpr std::array<NamedValue<Platform>, 3> kPlatforms{{
    {Platform::automatic, "auto", ""}, {Platform::egl, "egl", "EGL, on a GPU or Mesa's drivers"}, {Platform::osmesa, "osmesa", "Mesa, into memory"}}};

/// A context without a default framebuffer (draw into your own). Belongs to the thread on which it was made current last.
class Context {
 public:
  virtual ~Context() = default;
  /// Makes the context current on the calling thread. Throws InputError if the driver refuses.
  virtual void makeCurrent() = 0;
  /// The same for destructors: false if the driver refuses. What was made in the context must then be abandoned, not deleted.
  bool tryMakeCurrent() noexcept;
  /// "EGL surfaceless", "EGL device" or "OSMesa".
  virtual std::string_view platformName() const = 0;

  /// Driver strings; the context must be current.
  std::string renderer() const;
  std::string version() const;
};

/// Makes it current, and returns it: for those whose members are made in it.
inline Context& current(Context& context) {
  context.makeCurrent();
  return context;
}

/// Makes a context and makes it current. Throws InputError that says what was tried and what each answered.
std::unique_ptr<Context> makeHeadlessContext(Platform platform = Platform::automatic);

/// A context's share in the process's one set of OpenGL entry points. They belong to one platform for as long as any context of it lives:
/// another platform's would be swapped in under a running thread.
class EntryPoints {
 public:
  /// `loader` is the platform's lookup function, `platform` its name in complaints. Throws InputError while another platform has them.
  EntryPoints(GLADloadfunc loader, std::string_view platform);
  ~EntryPoints();
  EntryPoints(const EntryPoints&) = delete;
  EntryPoints& operator=(const EntryPoints&) = delete;

  /// Loads them if no context of the platform has yet; one must be current. Throws InputError below OpenGL 4.5; nothing counts as
  /// loaded then.
  void load();
};

// The makers that makeHeadlessContext chooses from; null and a reason where there is no such context here.
std::unique_ptr<Context> makeEglContext(std::string& reason);
std::unique_ptr<Context> makeOsmesaContext(std::string& reason);

}  // namespace warpscope::gl
