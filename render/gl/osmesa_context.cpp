// Contexts through OSMesa: Mesa's software rasteriser without any window system or device. Mesa 22 osmesa.h, OSMesaCreateContextAttribs.
// Loaded when it is asked for: it brings LLVM along, and a program that is linked with it takes three times as long to start.
// The loader's header comes first: it keeps Mesa's own gl.h out, which <GL/osmesa.h> includes.
#include "render/gl/context.h"

#include <GL/osmesa.h>
#include <dlfcn.h>

#include <string>
#include <type_traits>
#include <vector>

#include "render/base/error.h"

namespace warpscope::gl {
namespace {

/// What is used of the library, which stays once it is loaded. Contexts must not outlive main(): what it registers for the program's end comes after statics that are older.
class Osmesa {
 public:
  /// Throws InputError.
  static const Osmesa& instance() {
    static const Osmesa library;
    return library;
  }

  decltype(&OSMesaGetProcAddress) getProcAddress;
  decltype(&OSMesaCreateContextAttribs) createContext;
  decltype(&OSMesaMakeCurrent) makeCurrent;
  decltype(&OSMesaDestroyContext) destroyContext;

 private:
  Osmesa() {
    void* const library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) throw InputError("its library cannot be used: " + std::string(dlerror()));
    const auto find = [library](const char* name, auto& function) {
      void* const found = dlsym(library, name);
      if (found == nullptr) throw InputError("its library lacks " + std::string(name));
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(found);
    };
    find("OSMesaGetProcAddress", getProcAddress);
    find("OSMesaCreateContextAttribs", createContext);
    find("OSMesaMakeCurrent", makeCurrent);
    find("OSMesaDestroyContext", destroyContext);
  }
};

class OsmesaContext final : public Context {
 public:
  OsmesaContext(OSMesaContext context, std::unique_ptr<EntryPoints> entryPoints)
      : context_(context), entryPoints_(std::move(entryPoints)) {}
  ~OsmesaContext() override { Osmesa::instance().destroyContext(context_); }
  void makeCurrent() override {
    // OSMesa insists on a buffer for a default framebuffer; nothing is ever drawn into it.
    if (!Osmesa::instance().makeCurrent(context_, buffer_.data(), GL_UNSIGNED_BYTE, 1, 1))
      throw InputError("OSMesaMakeCurrent failed");
    entryPoints_->load();
  }
  std::string_view platformName() const override { return "OSMesa"; }

 private:
  OSMesaContext context_;
  const std::unique_ptr<EntryPoints> entryPoints_;
  std::vector<unsigned char> buffer_ = std::vector<unsigned char>(16);
};

}  // namespace

std::unique_ptr<Context> makeOsmesaContext(std::string& reason) {
  std::unique_ptr<EntryPoints> entryPoints;
  try {
    entryPoints = std::make_unique<EntryPoints>(reinterpret_cast<GLADloadfunc>(Osmesa::instance().getProcAddress), "OSMesa");
  } catch (const InputError& error) {
    reason = error.what();
    return nullptr;
  }
  const int attributes[] = {OSMESA_FORMAT,  OSMESA_RGBA, OSMESA_DEPTH_BITS, 0, OSMESA_PROFILE, OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION, 4, OSMESA_CONTEXT_MINOR_VERSION, 5, 0};
  OSMesaContext context = Osmesa::instance().createContext(attributes, nullptr);
  if (context == nullptr) {
    reason = "no OpenGL 4.5 core context";
    return nullptr;
  }
  auto made = std::make_unique<OsmesaContext>(context, std::move(entryPoints));
  try {
    made->makeCurrent();
  } catch (const InputError& error) {
    reason = error.what();
    return nullptr;
  }
  return made;
}

}  // namespace warpscope::gl
