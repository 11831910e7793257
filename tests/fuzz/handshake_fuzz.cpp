// Greetings made up by libFuzzer, for both sides, as bytes and through a stream in pieces: whatever is taken is what would be sent.
// See memory_stream.h for what the first bytes are.
#include <cstdint>
#include <cstdlib>

#include "net/reading.h"
#include "tests/fuzz/memory_stream.h"

namespace {

using namespace warpscope::net;

void require(bool condition) {
  if (!condition) std::abort();
}

/// What was read of bytes has to be what writes them.
template <class Hello>
void requireSame(const std::optional<Hello>& hello, ByteView bytes) {
  if (hello && hello->version == kProtocolVersion) require(std::ranges::equal(toBytes(*hello), bytes));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static asio::io_context io(1);
  const FuzzedPeer peer(std::span(data, size));
  const ByteView bytes = std::as_bytes(peer.bytes);
  requireSame(readClientHello(bytes), bytes);
  requireSame(readServerHello(bytes), bytes);
  if (readHelloVersion(bytes)) require(beginsLikeMagic(bytes));

  const TimePoint never = TimePoint::max();
  runOnBytes(io, [&]() -> Awaitable<void> {
    MemoryStream stream(io.get_executor(), peer.bytes, peer.pieces);
    const ClientHello hello = co_await receiveClientHello(stream, never);
    require(hello.version != kProtocolVersion || std::ranges::equal(toBytes(hello), bytes.first(kClientHelloBytes)));
  });
  runOnBytes(io, [&]() -> Awaitable<void> {
    MemoryStream stream(io.get_executor(), peer.bytes, peer.pieces);
    const ServerHello hello = co_await receiveServerHello(stream, never);
    require(hello.version != kProtocolVersion || std::ranges::equal(toBytes(hello), bytes.first(kServerHelloBytes)));
  });
  return 0;
}
