// Registering, mapping, copying.
// See gl_interop.h.
#include "render/cuda/gl_interop.h"

// CUDA's header wants OpenGL's own; nothing of it is used.
#include <GL/gl.h>
#include <cuda_gl_interop.h>

#include "render/cuda/cuda_picture.h"

namespace warpscope::cuda {

std::string whyNoInterop() {
  unsigned count = 0;
  int device = 0;
  const cudaError_t asked = cudaGLGetDevices(&count, &device, 1, cudaGLDeviceListAll);
  if (asked == cudaSuccess && count > 0) return {};
  cudaGetLastError();
  return asked == cudaSuccess || asked == cudaErrorNoDevice ? "this OpenGL driver does not run on a CUDA device" : cudaGetErrorString(asked);
}

struct InteropTexture::Registration {
  cudaGraphicsResource_t resource = nullptr;
  uint32_t width = 0;
  uint32_t height = 0;
  Stream stream;

  ~Registration() {
    if (resource != nullptr) cudaGraphicsUnregisterResource(resource);
  }
};

InteropTexture::InteropTexture(unsigned texture, uint32_t width, uint32_t height) : registration_(std::make_unique<Registration>()) {
  registration_->width = width;
  registration_->height = height;
  WARPSCOPE_CUDA_CHECK(
      cudaGraphicsGLRegisterImage(&registration_->resource, texture, GL_TEXTURE_2D, cudaGraphicsRegisterFlagsWriteDiscard));
}

InteropTexture::~InteropTexture() = default;

void InteropTexture::show(const DevicePicture& picture) {
  const auto* source = dynamic_cast<const CudaPicture*>(&picture);
  if (source == nullptr || picture.width() != registration_->width || picture.height() != registration_->height)
    throw InputError("a picture of another device or size cannot go into this texture");
  WARPSCOPE_CUDA_CHECK(cudaGraphicsMapResources(1, &registration_->resource, registration_->stream));
  cudaArray_t pixels = nullptr;
  cudaError_t copied = cudaGraphicsSubResourceGetMappedArray(&pixels, registration_->resource, 0, 0);
  const size_t rowBytes = size_t{picture.width()} * sizeof(Rgba8);
  if (copied == cudaSuccess)
    copied = cudaMemcpy2DToArrayAsync(pixels, 0, 0, source->data(), rowBytes, rowBytes, picture.height(), cudaMemcpyDeviceToDevice,
                                      registration_->stream);
  // Unmapped in any case: a texture that stays mapped is lost to OpenGL.
  WARPSCOPE_CUDA_CHECK(cudaGraphicsUnmapResources(1, &registration_->resource, registration_->stream));
  WARPSCOPE_CUDA_CHECK(copied);
  // The picture's memory may be drawn into again as soon as its last holder lets go.
  registration_->stream.synchronize();
}

}  // namespace warpscope::cuda
