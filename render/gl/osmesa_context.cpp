// Contexts through OSMesa: Mesa's software rasteriser without any window system or device.
// Mesa 22 osmesa.h, OSMesaCreateContextAttribs.
// The loader's header comes first: it keeps Mesa's own gl.h out, which <GL/osmesa.h> includes.
#include "render/gl/context.h"

#include <GL/osmesa.h>

#include <vector>

#include "render/base/error.h"

namespace warpscope::gl {
namespace {

class OsmesaContext final : public Context {
 public:
  OsmesaContext(OSMesaContext context, std::unique_ptr<EntryPoints> entryPoints)
      : context_(context), entryPoints_(std::move(entryPoints)) {}
  ~OsmesaContext() override { OSMesaDestroyContext(context_); }
  void makeCurrent() override {
    // OSMesa insists on a buffer for a default framebuffer; nothing is ever drawn into it.
    if (!OSMesaMakeCurrent(context_, buffer_.data(), GL_UNSIGNED_BYTE, 1, 1))
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
    entryPoints = std::make_unique<EntryPoints>(reinterpret_cast<GLADloadfunc>(OSMesaGetProcAddress), "OSMesa");
  } catch (const InputError& error) {
    reason = error.what();
    return nullptr;
  }
  const int attributes[] = {OSMESA_FORMAT,  OSMESA_RGBA, OSMESA_DEPTH_BITS, 0, OSMESA_PROFILE, OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION, 4, OSMESA_CONTEXT_MINOR_VERSION, 5, 0};
  OSMesaContext context = OSMesaCreateContextAttribs(attributes, nullptr);
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
