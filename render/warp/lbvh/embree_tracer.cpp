// Spheres through Embree, eight coherent rays at a time.
// See embree_tracer.h.
#include "render/warp/lbvh/embree_tracer.h"

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>

#include "render/base/error.h"
#include "render/core/floating_point.h"
#include "render/core/ray_sphere.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

constexpr uint32_t kPacketWidth = 4;
constexpr uint32_t kPacketHeight = 2;
constexpr uint32_t kPacketRays = kPacketWidth * kPacketHeight;
constexpr uint32_t kTileSide = 16;

/// A packet's context, with what each of its rays has accepted so far.
struct PacketContext {
  RTCIntersectContext base;  // first, so that Embree's pointer to it is one to this
  float t[kPacketRays];
  uint32_t id[kPacketRays];
};
static_assert(std::is_standard_layout_v<PacketContext>);

/// Rejects exits (a ray may begin within rounding of a surface) and, of equally near spheres, all but the one with the lowest id.
void filterHits(const RTCFilterFunctionNArguments* args) {
  auto& context = *reinterpret_cast<PacketContext*>(args->context);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0) continue;
    const float cosine = RTCHitN_Ng_x(args->hit, args->N, i) * RTCRayN_dir_x(args->ray, args->N, i) +
                         RTCHitN_Ng_y(args->hit, args->N, i) * RTCRayN_dir_y(args->ray, args->N, i) +
                         RTCHitN_Ng_z(args->hit, args->N, i) * RTCRayN_dir_z(args->ray, args->N, i);
    const float t = RTCRayN_tfar(args->ray, args->N, i);
    const uint32_t id = RTCHitN_primID(args->hit, args->N, i);
    const uint32_t ray = RTCRayN_id(args->ray, args->N, i);
    if (cosine > 0.0f || (t == context.t[ray] && id > context.id[ray])) {
      args->valid[i] = 0;
    } else {
      context.t[ray] = t;
      context.id[ray] = id;
    }
  }
}

}  // namespace

/// Embree reports failures from within its functions, also on its worker threads, where throwing would meet code that
/// does not expect it. So the first one is kept here until the call that caused it is over.
class EmbreeTracer::ErrorLog {
 public:
  static void report(void* log, RTCError code, const char* text) {
    auto& self = *static_cast<ErrorLog*>(log);
    const std::lock_guard lock(self.mutex_);
    if (self.first_.empty()) self.first_ = "Embree error " + std::to_string(code) + ": " + (text ? text : "no details");
  }

  void throwIfAny() {
    const std::lock_guard lock(mutex_);
    if (!first_.empty()) throw std::runtime_error(std::exchange(first_, {}));
  }

 private:
  std::mutex mutex_;
  std::string first_;
};

EmbreeTracer::EmbreeTracer() : errors_(std::make_unique<ErrorLog>()), device_(rtcNewDevice(nullptr)) {
  if (!device_) throw InputError("Embree finds no device: error " + std::to_string(rtcGetDeviceError(nullptr)));
  rtcSetDeviceErrorFunction(device_.get(), ErrorLog::report, errors_.get());
}

EmbreeTracer::~EmbreeTracer() = default;

void EmbreeTracer::build(std::span<const Sphere> spheres) {
  scene_.reset();
  nearTracer_.reset();
  spheres_.clear();
  validateSpheres(spheres);
  if (spheres.empty()) return;
  spheres_.assign(spheres.begin(), spheres.end());
  std::unique_ptr<std::remove_pointer_t<RTCScene>, Release> scene(rtcNewScene(device_.get()));
  errors_->throwIfAny();
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_SPHERE_POINT);
  errors_->throwIfAny();
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);  // the scene keeps it
  static_assert(sizeof(Sphere) == 4 * sizeof(float), "x, y, z and radius, as Embree wants them");
  auto* vertices = static_cast<Sphere*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, sizeof(Sphere), spheres.size()));
  errors_->throwIfAny();
  std::copy(spheres.begin(), spheres.end(), vertices);
  exceptionsExpected([&] {
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene.get());
  });
  errors_->throwIfAny();
  scene_ = std::move(scene);
}

bool EmbreeTracer::isNear(const glm::vec3& eye) const {
  return std::any_of(spheres_.begin(), spheres_.end(), [&](const Sphere& sphere) {
    const glm::vec3 toCenter = sphere.center - eye;
    return seenSphere(toCenter, sphere.radius).radius != sphere.radius;
  });
}

void EmbreeTracer::trace(const Camera& camera, Image<uint32_t>& ids, Image<float>* depth,
                         const std::stop_token& stop) const {
  if (isNear(camera.eye)) {
    const std::lock_guard lock(mutex_);
    if (!nearTracer_) {
      auto tracer = std::make_unique<LbvhTracer>();
      tracer->build(spheres_);
      nearTracer_ = std::move(tracer);
    }
    nearTracer_->trace(camera, ids, depth, stop);
    return;
  }
  ids.resize(camera.width, camera.height, kNoSample);
  if (depth) depth->resize(camera.width, camera.height, kNoHit);
  if (!scene_) return;
  const auto tracePacket = [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
    PacketContext context;
    rtcInitIntersectContext(&context.base);
    context.base.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    context.base.filter = filterHits;
    RTCRayHit8 packet;
    alignas(32) int valid[kPacketRays];
    for (uint32_t i = 0; i < kPacketRays; ++i) {
      const uint32_t x = x0 + i % kPacketWidth;
      const uint32_t y = y0 + i / kPacketWidth;
      valid[i] = x < x1 && y < y1 ? -1 : 0;
      const Ray ray = pixelRay(camera, {static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f});
      packet.ray.org_x[i] = ray.origin.x;
      packet.ray.org_y[i] = ray.origin.y;
      packet.ray.org_z[i] = ray.origin.z;
      packet.ray.dir_x[i] = ray.direction.x;
      packet.ray.dir_y[i] = ray.direction.y;
      packet.ray.dir_z[i] = ray.direction.z;
      packet.ray.tnear[i] = 0.0f;
      packet.ray.tfar[i] = kNoHit;
      packet.ray.time[i] = 0.0f;
      packet.ray.mask[i] = ~0u;
      packet.ray.id[i] = i;
      packet.ray.flags[i] = 0;
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
      context.t[i] = kNoHit;
      context.id[i] = kNoSample;
    }
    exceptionsExpected([&] { rtcIntersect8(valid, scene_.get(), &context.base, &packet); });  // Embree's own
    for (uint32_t i = 0; i < kPacketRays; ++i) {
      if (valid[i] == 0 || packet.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      const uint32_t x = x0 + i % kPacketWidth;
      const uint32_t y = y0 + i / kPacketWidth;
      ids(x, y) = packet.hit.primID[i];
      if (depth) (*depth)(x, y) = packet.ray.tfar[i];
    }
  };
  parallelForTiles(camera.width, camera.height, kTileSide, stop,
                   [&](uint32_t x0, uint32_t y0, uint32_t x1, uint32_t y1) {
                     for (uint32_t y = y0; y < y1; y += kPacketHeight)
                       for (uint32_t x = x0; x < x1; x += kPacketWidth) tracePacket(x, y, x1, y1);
                   });
  errors_->throwIfAny();
}

}  // namespace warpscope
