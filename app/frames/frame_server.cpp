// One request after the other.
// See frame_server.h.
#include "app/frames/frame_server.h"

#include <new>

#include "app/frames/wire_fields.h"
#include "render/base/error.h"
#include "render/base/stopwatch.h"
#include "render/codec/codec.h"

namespace warpscope {
namespace {

net::ServerSettings withScene(net::ServerSettings settings, const Scene& scene) {
  settings.scene = toFields(scene);
  return settings;
}

/// A frame that answers `request`, but for who asked and when.
struct Answer {
  net::FrameHead head;
  net::Bytes payload;
};

Answer answerTo(const net::FrameRequest& request, Marcher& marcher, FrameCodec& codec, const std::stop_token& stop) {
  const Camera camera = cameraFrom(request.camera);
  const MarchSettings march = marchFrom(request.settings);
  const CodecSettings coding = codecFrom(request.codec);
  Answer answer;
  if (request.wanted == net::Wanted::samples) {
    const SampleFrame frame = marcher.march(camera, march, stop);
    answer.head = headOf(frame, coding);
    answer.head.stages.encodeMs = milliseconds([&] { answer.payload = codec.encode(frame, coding); });
    return answer;
  }
  Image<glm::vec4> image;
  answer.head.camera = request.camera;
  answer.head.settings = request.settings;
  answer.head.codec = request.codec;
  answer.head.stages.marchMs = milliseconds([&] { marcher.render(camera, march.render, image, stop); });
  answer.head.stages.encodeMs = milliseconds([&] { answer.payload = encodeColors(image); });
  return answer;
}

}  // namespace

FrameServer::FrameServer(std::shared_ptr<net::IoThread> io, const Scene& scene, MarcherPtr marcher, net::ServerSettings settings)
    : marcher_(std::move(marcher)),
      clock_(io->clock()),
      server_(std::move(io), withScene(std::move(settings), scene)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

FrameServer::~FrameServer() {
  thread_.request_stop();
  server_.stop();
}

void FrameServer::run(const std::stop_token& stop) {
  FrameCodec codec;
  while (const std::optional<net::RequestJob> job = server_.requests().take(stop)) {
    const double queueMs = millisecondsBetween(job->arrivedAt, clock_.now());
    // The others do not wait for a march whose client is gone.
    std::stop_source end;
    const std::stop_callback byServer(stop, [&end] { end.request_stop(); });
    const std::stop_callback byClient(job->hasLeft, [&end] { end.request_stop(); });
    try {
      Answer answer = answerTo(job->request, *marcher_, codec, end.get_token());
      answer.head.id = job->request.id;
      answer.head.wanted = job->request.wanted;
      answer.head.requestSentAtNs = job->request.sentAtNs;
      answer.head.stages.queueMs = queueMs;
      server_.answer(job->client, answer.head, std::move(answer.payload));
    } catch (const OperationCancelled&) {
      if (stop.stop_requested()) return;
    } catch (const std::bad_alloc&) {
      server_.answer(job->client, net::Failure{job->request.id, "the server has not enough memory for this"});
    } catch (const std::exception& error) {
      server_.answer(job->client, net::Failure{job->request.id, error.what()});
    }
  }
}

}  // namespace warpscope
