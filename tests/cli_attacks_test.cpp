// Commands that connect to a server which lies: a sentence each that says so, exit code 1, at once, and no memory
// beyond their own. Mirrors the rows of tests/README.md's table of attacks that a client answers for.
#include "app/frames/backend.h"
#include "app/frames/color_bytes.h"
#include "app/frames/wire_fields.h"
#include "app/scene/scene.h"
#include "tests/net/adversarial_server.h"
#include "tests/running_server.h"

namespace warpscope {
namespace {

using net::AdversarialServer;
using net::BareSocket;

/// What commands take at most when they are lied to; they take about 100 MiB themselves.
constexpr long kMostKiB = 400 << 10;

class CliAttacks : public Serving {
 protected:
  static Scene scene() {
    SceneOverrides overrides;
    overrides.proceduralDims = glm::uvec3(24, 22, 20);
    return openScene("block", overrides);
  }
  /// A head that echoes the request and could be drawn, changed; then zeros for as long as they are taken.
  static AdversarialServer::Answer zerosAfter(void (*change)(net::FrameHead&), size_t payloadBytes) {
    return [=](BareSocket& to, const net::FrameRequest& request) {
      net::FrameHead head = net::echoOf(request);
      change(head);
      to.send(net::frameMessage(head, payloadBytes));
      const net::Bytes zeros(size_t{1} << 20);
      while (to.send(zeros)) continue;
      return false;
    };
  }
  void expectSaid(const AdversarialServer::Answer& answer, const std::string& reason) const {
    const AdversarialServer server(toFields(scene()), answer);
    for (const Arguments& arguments :
         {shot(server.url()), Arguments{"compare", "--connect", server.url(), "--size", "40x30", "--out", "c"}}) {
      SCOPED_TRACE(arguments[0]);
      const ProgramResult result = run(arguments);
      EXPECT_EQ(result.code, kFailure) << result.err;
      EXPECT_THAT(result.err, testing::HasSubstr(reason));
      EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("sphere 0")));
      EXPECT_LT(result.seconds, 10.0) << "there is nothing to wait for";
      if (!net::kIsSanitized) EXPECT_LT(result.peakKiB, kMostKiB);
    }
  }
};

TEST_F(CliAttacks, InventedCamerasAreSaid) {
  expectSaid(zerosAfter([](net::FrameHead& head) { head.camera.width = head.camera.height = 8192; }, 500'000),
             "the server answered something else than it was asked: a size of 8192x8192 pixels, not 40x30");
}

TEST_F(CliAttacks, AGibibyteOfZerosIsSaid) {
  expectSaid(zerosAfter([](net::FrameHead&) {}, (size_t{1} << 30) - 10'000),
             "the server answered something else than it was asked: 10737");
}

TEST_F(CliAttacks, ImpossibleNumbersAreSaid) {
  expectSaid(zerosAfter([](net::FrameHead& head) { head.sampleCount = 1u << 20; }, 1000),
             "1048576 samples, where 1200 are the most");
  expectSaid(zerosAfter([](net::FrameHead& head) { head.radiusUnit = 0x1p120f; }, 1000),
             "the server's frame has a unit of radii");
}

TEST_F(CliAttacks, ABusyServerIsSaidOnce) {
  const Scene shown = scene();
  const MarcherPtr marcher = makeMarcher(Backend::cpu, shown.volume, shown.transferFunction);
  const AdversarialServer server(toFields(shown), [&](BareSocket& to, const net::FrameRequest& request) {
    for (uint16_t i = 0; i < 50; ++i) to.send(net::busyMessage(3));
    std::this_thread::sleep_for(milliseconds(50));
    net::FrameHead head = net::echoOf(request);
    ByteVector payload;
    const Camera camera = cameraFrom(request.camera);
    const MarchSettings settings = marchFrom(request.settings);
    if (request.wanted == net::Wanted::samples) {
      const SampleFrame frame = marcher->march(camera, settings);
      head = headOf(frame, codecFrom(request.codec));
      head.id = request.id;
      payload = FrameCodec().encode(frame, codecFrom(request.codec));
    } else {
      Image<glm::vec4> image;
      marcher->render(camera, settings.render, image);
      payload = encodeColors(image);
    }
    return to.send(net::frameMessage(head, payload.size())) && to.send(payload);
  });
  const ProgramResult result = succeed(shot(server.url()));
  const std::string said = "the server is busy with 3 others";
  const size_t first = result.err.find(said);
  ASSERT_NE(first, std::string::npos) << result.err;
  EXPECT_EQ(result.err.find(said, first + 1), std::string::npos) << result.err;
}

TEST_F(CliAttacks, AWindowShowsWhatTheServerDid) {
  if (runShell("command -v xvfb-run", folder_.path()).code != 0)
    GTEST_SKIP() << "no xvfb-run (Debian: apt-get install xvfb)";
  const AdversarialServer server(
      toFields(scene()),
      zerosAfter([](net::FrameHead& head) { head.camera.width = head.camera.height = 8192; }, 500'000));
  const ProgramResult result = runShell("xvfb-run -a \"$W\" view --connect " + server.url() +
                                            " --size 800x600 --screenshot w.png --after-ms 1500 --report r.json",
                                        folder_.path());
  ASSERT_EQ(result.code, kSuccess) << result.err;
  const nlohmann::json report = nlohmann::json::parse(folder_.read("r.json"));
  EXPECT_EQ(report["framesReceived"], 0);
  EXPECT_EQ(report["server"]["isConnected"], false);
  EXPECT_THAT(report["server"]["sentence"].get<std::string>(),
              testing::HasSubstr("the server answered something else than it was asked: a size of 8192x8192"));
  EXPECT_LE(server.connections(), 2) << "one for frames and one for what they are compared with: neither comes back";
  if (!net::kIsSanitized) EXPECT_LT(result.peakKiB, kMostKiB);
}

}  // namespace
}  // namespace warpscope
