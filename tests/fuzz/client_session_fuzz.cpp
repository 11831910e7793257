// A whole session of a client with a server made up by libFuzzer: greeting, scene, answers, through net::Client into
// scenes and frames. Whatever the server says: nothing throws where it must not, nothing is taken that was not asked
// for, nothing is larger than what was. The first byte: client_session.h. Then see memory_stream.h.
#include <cstdlib>
#include <semaphore>

#include "app/frames/color_bytes.h"
#include "net/client.h"
#include "render/base/error.h"
#include "render/codec/payload_hash.h"
#include "tests/fuzz/client_session.h"
#include "tests/fuzz/memory_stream.h"

namespace {

using namespace warpscope;
namespace asio = net::asio;

void require(bool condition) {
  if (!condition) std::abort();
}

/// What is read comes after what the client wants to write: its request is under way when the answer is there.
class AnsweringStream final : public net::Stream {
 public:
  AnsweringStream(const asio::any_io_executor& executor, const net::FuzzedPeer& peer)
      : inner_(executor, peer.bytes, peer.pieces) {}

  using Stream::write;
  net::Awaitable<size_t> readSome(asio::mutable_buffer buffer) override {
    for (int i = 0; i < 3; ++i) co_await asio::post(inner_.executor(), asio::use_awaitable);
    const size_t count = co_await inner_.readSome(buffer);
    co_return count;
  }
  net::Awaitable<void> write(std::span<const asio::const_buffer>) override { co_return; }
  net::Awaitable<void> finish(net::TimePoint deadline) override { co_await inner_.finish(deadline); }
  void close() noexcept override { inner_.close(); }
  void abort() noexcept override { inner_.abort(); }
  asio::any_io_executor executor() override { return inner_.executor(); }
  const std::string& peer() const override { return inner_.peer(); }

 private:
  net::MemoryStream inner_;
};

class Taker final : public net::ClientEvents {
 public:
  Taker(const AskedInFuzzing& asked, bool seals) : asked_(asked), seals_(seals) {}

  void onState(const net::ConnectionState& state) override {
    require(state.phase != net::ConnectionPhase::waiting);
    if (state.phase == net::ConnectionPhase::refused) ended.release();
  }
  void onScene(const net::SceneFields& fields) override {
    require(!fields.views.empty());
    take([&] {
      const Scene scene = sceneFrom(fields);
      require(scene.views.size() == fields.views.size() && scene.volume == nullptr);
    });
  }
  std::string faultOf(const net::FrameHead& head, uint64_t payloadBytes) override {
    require(head.camera == toFields(asked_.camera) && head.wanted == asked_.wanted);
    return warpscope::faultOf(head, payloadBytes);
  }
  bool admits(const net::SettingFields& asked, const net::SettingFields& answered) override { return warpscope::admits(asked, answered); }
  void onFrame(net::Frame frame, const net::FrameArrival&) override {
    constexpr size_t kMostBytes = 1 << 20;  // of 64 x 48 pixels with three samples each and sixteen planes
    require(frame.payload.size() <= kMostBytes && frame.payload.capacity() <= kMostBytes);
    if (seals_) sealPayload(frame.payload);
    take([&] {
      if (asked_.wanted == net::Wanted::picture) {
        decodeColors(frame.payload, asked_.camera.width, asked_.camera.height);
        return;
      }
      const SampleFrame decoded = decodedFrom(frame.head, frame.payload, codec_);
      require(decoded.camera == asked_.camera && decoded.size() == frame.head.sampleCount);
      require(decoded.size() <= size_t{64} * 48 * static_cast<size_t>(asked_.settings.sample.samplesPerRay));
      for (const PackedSample sample : decoded.samples) require(radiusCode(sample) != 0);
    });
  }
  void onFailure(const net::Failure& failure) override { require(failure.sentence.size() < net::kMaxFailureBytes); }

  std::binary_semaphore ended{0};

 private:
  /// Bad input is InputError or UsageError.
  template <class F>
  static void take(F f) {
    try {
      f();
    } catch (const InputError&) {
    } catch (const UsageError&) {
    }
  }

  const AskedInFuzzing asked_;
  const bool seals_;
  static inline FrameCodec codec_;  // its buffers are used again, as in a session
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  static const auto io = std::make_shared<net::IoThread>();
  const AskedInFuzzing asked(data[0]);
  const net::FuzzedPeer peer(std::span(data, size).subspan(1));
  Taker taker(asked, data[0] & 1);
  net::ClientSettings settings;
  settings.depth = 2;
  settings.connectsAgain = false;
  settings.opener = [&peer](asio::io_context& context) {
    return std::make_unique<AnsweringStream>(context.get_executor(), peer);
  };
  {
    net::Client client(io, settings, taker);
    client.request(asked.request(1));
    taker.ended.acquire();
  }
  io->call([] {});  // what the client left on the thread
  return 0;
}
