// Messages made up by libFuzzer, for every reader: nothing, or what writes the very same bytes.
// The first byte chooses the reader; the rest is a head, or a body.
#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "net/messages.h"

namespace {

using namespace warpscope::net;

void requireSame(const Bytes& written, ByteView bytes) {
  if (!std::ranges::equal(written, bytes)) std::abort();
}

ByteView bodyOf(const Bytes& message) { return ByteView(message).subspan(kMessageHeadBytes); }

void check(uint8_t reader, ByteView bytes) {
  switch (reader) {
    case 0:
      if (const auto head = readMessageHead(bytes)) {
        Bytes written;
        append(written, *head);
        requireSame(written, bytes);
      }
      break;
    case 1:
      if (const auto scene = readScene(bytes)) {
        const Bytes message = sceneMessage(*scene);
        requireSame({bodyOf(message).begin(), bodyOf(message).end()}, bytes);
      }
      break;
    case 2:
      if (const auto request = readRequest(bytes)) {
        const Bytes message = requestMessage(*request);
        requireSame({bodyOf(message).begin(), bodyOf(message).end()}, bytes);
      }
      break;
    case 3:
      if (const auto head = readFrameHead(bytes)) {
        const Bytes message = frameMessage(*head, 0);
        requireSame({bodyOf(message).begin(), bodyOf(message).end()}, bytes);
        if (readFrameHeadLength(bytes.first(kFrameHeadLengthBytes)) != bytes.size()) std::abort();
      }
      break;
    case 4:
      if (const auto failure = readFailure(bytes)) {
        const Bytes message = failureMessage(*failure);
        requireSame({bodyOf(message).begin(), bodyOf(message).end()}, bytes);
      }
      break;
    case 5:
      if (const auto others = readBusy(bytes)) {
        const Bytes message = busyMessage(*others);
        requireSame({bodyOf(message).begin(), bodyOf(message).end()}, bytes);
      }
      break;
    case 6:
      if (const auto processes = readProcesses(bytes)) {
        const Bytes message = processesMessage(*processes);
        requireSame({bodyOf(message).begin(), bodyOf(message).end()}, bytes);
      }
      break;
    default:
      if (const auto beat = readBeat(bytes)) {
        const Bytes message = beatMessage(MessageType::ping, *beat);
        requireSame({bodyOf(message).begin(), bodyOf(message).end()}, bytes);
      }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  check(data[0] % 8, std::as_bytes(std::span(data, size)).subspan(1));
  return 0;
}
