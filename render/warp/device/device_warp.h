// What techniques that redraw samples on a CUDA device share: the frame's copy, colours, pictures, times. For .cu files.
// A technique derives from it and says what it builds and which sample each pixel sees.
#pragma once

#include <vector>

#include "render/cuda/cuda_picture.h"
#include "render/warp/device/device_frame.h"
#include "render/warp/warp.h"

namespace warpscope {

/// One value for each pixel, in device memory.
struct DevicePixels {
  uint32_t* samples = nullptr;  ///< place in the frame of the sample seen, kNotASample, kFilled or kNoSample
  /// Linear, premultiplied; only techniques that blend samples write it, see DeviceWarp::blends.
  glm::vec4* color = nullptr;
};

class DeviceWarp : public Warp {
 public:
  DeviceWarp();

  void setFrame(SampleFramePtr frame, const WarpSettings& settings, const std::stop_token& stop) final;
  void draw(const Camera& camera, const WarpSettings& settings, WarpedImage& image, const std::stop_token& stop) final;
  DevicePicturePtr drawForScreen(const Camera& camera, const WarpSettings& settings, const glm::vec3& background, const PixelMarks& marks,
                                 const std::stop_token& stop) final;
  std::optional<DeviceTimings> deviceTimings() const final { return timings_; }

 protected:
  /// Copies of the frame what drawing needs, in stream order: its samples, unless a technique draws others.
  virtual void upload(const SampleFrame& frame, cudaStream_t stream) { deviceFrame_.upload(frame, stream); }
  /// Derives from the frame what drawing needs, in stream order; after upload() what any picture does, after prepare() what the next one does.
  virtual void build(const DeviceFrameView& frame, const WarpSettings& settings, cudaStream_t stream) = 0;
  /// Writes every pixel, in stream order.
  virtual void trace(const DeviceFrameView& frame, const Camera& camera, const WarpSettings& settings, const DevicePixels& pixels,
                     cudaStream_t stream) = 0;
  /// After the stream has got there: throws if the device reported that a trace is not to be used.
  virtual void checkTrace() {}
  /// Chooses how the next picture is made; true if build() of the same frame has to come first.
  virtual bool prepare(const WarpSettings&, const Camera&) { return false; }
  /// True if trace() writes colours; else they are the samples' own.
  virtual bool blends() const { return false; }
  /// Nothing anywhere, in stream order; for those that blend.
  static void clearPixels(const Camera& camera, const DevicePixels& pixels, cudaStream_t stream);
  /// As upload() has copied it.
  const DeviceFrame& frameThere() const { return deviceFrame_; }
  /// In device memory.
  const ColorTables* colorTables() const { return colorTables_.data(); }

 private:
  void rebuild(const WarpSettings& settings);
  DevicePixels pixelsFor(const Camera& camera);
  void traceInto(const DevicePixels& pixels, const Camera& camera, const WarpSettings& settings);

  cuda::Stream stream_;
  cuda::Event begin_, middle_, end_;
  DeviceTimings timings_;
  SampleFramePtr frame_;
  DeviceFrame deviceFrame_;
  cuda::DeviceBuffer<ColorTables> colorTables_;
  cuda::DeviceBuffer<uint32_t> samples_;
  cuda::DeviceBuffer<glm::vec4> color_;
  std::vector<std::shared_ptr<cuda::CudaPicture>> pictures_;  // reused when nobody else holds them any more
};

}  // namespace warpscope
