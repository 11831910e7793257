// `serve` and `--connect` through the built program: one URL, the same pictures as at home, clean ends, no secrets in logs.
// The contract is in README; what goes over the wire is tested in tests/net and scene_connection_test.cpp, refusals in cli_connect_test.cpp.
#include "net/address.h"
#include "net/certificate.h"
#include "render/warp/warp.h"
#include "tests/running_server.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// --- what is printed

TEST_F(Serving, PrintsOneUrlAndThePort) {
  RunningServer server(kSmallScene);
  const int port = std::stoi(server.port());
  EXPECT_GT(port, 1023);
  EXPECT_EQ(server.folder().read("port"), server.port() + "\n");
  const ProgramResult result = server.end();
  EXPECT_EQ(result.code, kSuccess);
  EXPECT_EQ(result.out, "warp://127.0.0.1:" + server.port() + "\n");
  EXPECT_EQ(result.err, "");
}

TEST_F(Serving, JsonIsOneDocument) {
  RunningServer server({"block", "--volume-size", "24x22x20", "--json"});
  const ProgramResult result = server.end();
  EXPECT_EQ(result.code, kSuccess);
  const json document = json::parse(result.out, nullptr, false);
  ASSERT_FALSE(document.is_discarded()) << result.out;
  EXPECT_EQ(document["url"], "warp://127.0.0.1:" + server.port());
  EXPECT_EQ(std::to_string(document["port"].get<int>()), server.port());
  EXPECT_EQ(document["scene"], "block");
  EXPECT_EQ(result.err, "");
}

TEST_F(Serving, AFileThatIsCutOffWhileItIsShownEndsItWithASentence) {
  const TestFolder data;
  data.write("cut_64x64x64_uint8.raw", std::string(64 * 64 * 64, 'x'));
  RunningServer server({data.file("cut_64x64x64_uint8.raw")});
  fs::resize_file(data.file("cut_64x64x64_uint8.raw"), 0);
  EXPECT_EQ(run(shot(server.plainUrl())).code, kFailure);
  const ProgramResult result = server.wait();
  EXPECT_EQ(result.code, kFailure);
  EXPECT_THAT(result.err, testing::MatchesRegex("warpscope: .*/cut_64x64x64_uint8\\.raw: bytes [0-9]+ to [0-9]+ cannot be read: it has become shorter while it was read, or its disk fails\n"));
}

TEST_F(Serving, BeyondLoopbackThereIsAlwaysTlsAndAToken) {
  for (const std::string host : {"0.0.0.0", "[::]"}) {
    SCOPED_TRACE(host);
    RunningServer server(kSmallScene, host);
    const net::Address address = net::parseAddress(server.url());
    ASSERT_TRUE(address.isEncrypted()) << server.url();
    EXPECT_NE(address.where.host, "0.0.0.0") << "no client can connect to that";
    EXPECT_EQ(std::to_string(address.where.port), server.port());
    const fs::path identity = server.folder().path() / ".local/share/warpscope/identity.pem";
    EXPECT_EQ(fs::status(identity).permissions(), fs::perms::owner_read | fs::perms::owner_write);
    // Whatever the machine is called: through loopback, with what was printed, and not without.
    net::Address near = address;
    near.where.host = "127.0.0.1";
    if (host == "0.0.0.0") succeed(shot(net::toString(near), {"--quiet"}));
    EXPECT_EQ(server.end().code, kSuccess);
  }
}

TEST_F(Serving, ItIsTheSameServerNextTime) {
  const TestFolder home;
  const Arguments environment{"XDG_DATA_HOME=" + home.path().string()};
  std::vector<net::Address> addresses;
  for (int i = 0; i < 2; ++i) {
    RunningServer server({"block", "--volume-size", "9x9x9", "--secure"}, "127.0.0.1", environment);
    addresses.push_back(net::parseAddress(server.url()));
    EXPECT_EQ(server.end().code, kSuccess);
  }
  EXPECT_EQ(addresses[0].credentials->fingerprint, addresses[1].credentials->fingerprint);
  EXPECT_FALSE(addresses[0].credentials->token == addresses[1].credentials->token);
}

// --- the same pictures as at home

TEST_F(Serving, ShotsAreTheLocalOnesByteForByte) {
  RunningServer plain(kSmallScene);
  RunningServer secure({"block", "--volume-size", "24x22x20", "--secure"});
  for (const WarpDescriptor& technique : warpRegistry()) {
    SCOPED_TRACE(technique.name);
    const Arguments how{"--technique", std::string(technique.name), "--view-angle", "20", "--size", "61x43", "--heuristic", "median", "--step", "0.4"};
    const auto take = [&](Arguments arguments, const std::string& name) {
      arguments.insert(arguments.begin(), "shot");
      arguments.insert(arguments.end(), how.begin(), how.end());
      arguments.insert(arguments.end(), {"-o", name, "--quiet"});
      succeed(arguments);
      return folder_.read(name);
    };
    const std::string local = take(kSmallScene, "local.png");
    EXPECT_TRUE(take({"--connect", plain.plainUrl()}, "plain.png") == local);
    EXPECT_TRUE(take({"--connect", secure.url()}, "secure.png") == local);
    EXPECT_TRUE(take({"--connect", plain.plainUrl(), "--codec", "raw"}, "raw.png") == local);
  }
  // Compressed colours are others, and the same every time.
  succeed(shot(plain.plainUrl(), {"--color", "jpeg", "--quality", "20", "--quiet"}));
  const std::string compressed = folder_.read("a.png");
  succeed(shot(plain.plainUrl(), {"--quiet"}));
  EXPECT_FALSE(folder_.read("a.png") == compressed);
}

TEST_F(Serving, CompareWritesEverything) {
  RunningServer server(kSmallScene);
  const json here = document({"compare", "block", "--volume-size", "24x22x20", "--size", "40x30", "--out", "here", "--json"});
  const json there = document({"compare", "--connect", server.plainUrl(), "--size", "40x30", "--out", "there", "--json"});
  ASSERT_EQ(there["rows"].size(), here["rows"].size());
  EXPECT_EQ(there["scene"], here["scene"]);
  for (size_t i = 0; i < here["rows"].size(); ++i)
    for (const char* key : {"technique", "view", "psnrDb", "holeFraction", "samples", "bytes"})
      EXPECT_EQ(there["rows"][i][key], here["rows"][i][key]) << key;
  size_t files = 0;
  for (const std::string& name : folder_.listing())
    if (name.starts_with("here/view")) {
      ++files;
      EXPECT_TRUE(folder_.read(name) == folder_.read("t" + name)) << name;
    }
  EXPECT_EQ(files, here["rows"].size());
  EXPECT_TRUE(fs::exists(folder_.path() / "there/montage.png"));
  EXPECT_EQ(json::parse(folder_.read("there/metrics.json")), there);
}

TEST_F(Serving, TwoClientsAtOnceGetTheSamePictures) {
  RunningServer server({"shells", "--volume-size", "48x48x48"});
  const auto command = [&](const std::string& name) {
    return Arguments{"shot", "--connect", server.plainUrl(), "--size", "400x300", "--view-angle", "15", "-o", name, "--quiet"};
  };
  std::vector<std::unique_ptr<Program>> clients;
  for (const std::string name : {"a.png", "b.png", "c.png"}) clients.push_back(std::make_unique<Program>(command(name), folder_.path()));
  for (const auto& client : clients) {
    const ProgramResult result = client->wait();
    EXPECT_EQ(result.code, kSuccess) << result.err;
  }
  succeed({"shot", "shells", "--volume-size", "48x48x48", "--size", "400x300", "--view-angle", "15", "-o", "local.png", "--quiet"});
  for (const char* name : {"a.png", "b.png", "c.png"}) EXPECT_TRUE(folder_.read(name) == folder_.read("local.png")) << name;
}

TEST_F(Serving, ASimulatedLinkTakesItsTime) {
  RunningServer server(kSmallScene);
  // Two round trips of 600 ms: the greeting and the frame.
  for (const Arguments& link : {Arguments{"--link", "delay=300"}, {"--delay-ms", "600"}}) EXPECT_GT(succeed(shot(server.plainUrl(), link)).seconds, 1.1) << link.front();
}

// --- ends

TEST_F(Serving, SignalsEndItAtOnce) {
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    RunningServer server(kSmallScene);
    const auto start = std::chrono::steady_clock::now();
    const ProgramResult result = server.end(number);
    EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(2));
    EXPECT_EQ(result.code, kSuccess) << number << ": " << result.err;
    EXPECT_EQ(result.err, "");
  }
}

TEST_F(Serving, SignalsEndItInTheMiddleOfAMarch) {
  for (const int number : {SIGINT, SIGTERM}) {
    RunningServer server({"vessels", "--verbose"});
    Program client({"shot", "--connect", server.plainUrl(), "--size", "3000x3000", "--step", "0.003", "-o", "a.png", "--quiet"}, folder_.path());
    const auto connections = [&] {
      const std::string text = server.errSoFar();
      size_t count = 0;
      for (size_t at = text.find(" connected"); at != std::string::npos; at = text.find(" connected", at + 1)) ++count;
      return count;
    };
    // The scene and the frame come over one.
    const auto deadline = std::chrono::steady_clock::now() + seconds(30);
    while (connections() < 1 && !client.hasEnded() && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(milliseconds(5));
    std::this_thread::sleep_for(milliseconds(600));  // it marches
    ASSERT_FALSE(client.hasEnded()) << client.errSoFar();
    const auto start = std::chrono::steady_clock::now();
    const ProgramResult result = server.end(number);
    EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(2));
    EXPECT_EQ(result.code, kSuccess) << result.err;
    client.signal(SIGINT);
    EXPECT_EQ(client.wait().code, kFailure);
    EXPECT_TRUE(folder_.listing().empty());
  }
}

TEST_F(Serving, AServerThatEndsIsASentenceToItsClient) {
  auto server = std::make_unique<RunningServer>(Arguments{"vessels", "--verbose"});
  Program client({"shot", "--connect", server->plainUrl(), "--size", "3000x3000", "--step", "0.003", "-o", "a.png"}, folder_.path());
  while (server->errSoFar().find(" connected") == std::string::npos && !client.hasEnded()) std::this_thread::sleep_for(milliseconds(5));
  std::this_thread::sleep_for(milliseconds(600));  // it marches
  server->end();
  const ProgramResult result = client.wait();
  EXPECT_EQ(result.code, kFailure);
  const std::string address = "127.0.0.1:" + server->port();  // said soon, and at the end
  EXPECT_THAT(result.err, testing::MatchesRegex("warning: [^\n]*" + address + "[^\n]*; trying again for 15 s\nwarpscope: [^\n]*" + address + "[^\n]*\n"));
  EXPECT_TRUE(folder_.listing().empty());
}

/// Its server does not take it for a connection that broke.
TEST_F(Serving, AClientThatIsDoneLeaves) {
  for (const bool isSecure : {false, true}) {
    RunningServer server(isSecure ? Arguments{"block", "--volume-size", "24x22x20", "--verbose", "--secure"}
                                  : Arguments{"block", "--volume-size", "24x22x20", "--verbose"});
    succeed(shot(server.url()));
    succeed({"compare", "--connect", server.url(), "--size", "40x30", "--out", "out"});
    const ProgramResult result = server.end();
    EXPECT_THAT(result.err, testing::HasSubstr(" left\n"));
    EXPECT_THAT(result.err, testing::Not(testing::HasSubstr(" left: "))) << "the server takes it for a failure";
    EXPECT_THAT(result.err, testing::Not(testing::HasSubstr("reset by peer")));
  }
}

TEST_F(Serving, AClientThatIsInterruptedLeaves) {
  RunningServer server({"vessels", "--verbose"});
  Program client({"shot", "--connect", server.plainUrl(), "--size", "3000x3000", "--step", "0.003", "-o", "a.png", "--quiet"}, folder_.path());
  const auto deadline = std::chrono::steady_clock::now() + seconds(30);
  while (server.errSoFar().find(" connected") == std::string::npos && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(milliseconds(5));
  std::this_thread::sleep_for(milliseconds(300));  // it marches
  client.signal(SIGINT);
  EXPECT_EQ(client.wait().code, kFailure);
  EXPECT_THAT(server.end().err, testing::HasSubstr(" left\n"));
}

// --- secrets

TEST_F(Serving, TokensAreInNoLog) {
  RunningServer server({"block", "--volume-size", "24x22x20", "--secure", "--verbose"});
  const std::string token = net::parseAddress(server.url()).credentials->token.text();
  const ProgramResult right = succeed(shot(server.url(), {"--verbose"}));
  const ProgramResult wrong = run(shot(withOther(server.url(), "token=", kToken), {"--verbose"}));
  EXPECT_EQ(wrong.code, kFailure);
  const ProgramResult result = server.end();
  for (const std::string& text : {right.err, wrong.err, result.err}) {
    EXPECT_THAT(text, testing::Not(testing::HasSubstr(token)));
    EXPECT_THAT(text, testing::Not(testing::HasSubstr(kToken)));
  }
  EXPECT_THAT(result.err, testing::HasSubstr("token=..."));
  EXPECT_THAT(result.err, testing::HasSubstr("wrong token"));
}

TEST_F(Serving, WrongTokensAreLoggedAndListenedToLessAndLess) {
  RunningServer server({"block", "--volume-size", "24x22x20", "--secure"});
  const Arguments wrong = shot(withOther(server.url(), "token=", kToken));
  for (int i = 0; i < 4; ++i) expectRefused(wrong, kFailure, {"does not accept this token"});
  // Not listened to for a second: both clients try again by themselves, and learn what they would have.
  const auto start = std::chrono::steady_clock::now();
  expectRefused(wrong, kFailure, {"does not accept this token"});
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds(500));
  succeed(shot(server.url()));
  const std::string log = server.end().err;
  EXPECT_THAT(log, testing::ContainsRegex("warning: 127.0.0.1:[0-9]+: a wrong token\n"));
  EXPECT_THAT(log, testing::ContainsRegex("warning: 127.0.0.1:[0-9]+: a wrong token, number 4 in a row; not listened to for 1 s\n"));
  EXPECT_THAT(log, testing::HasSubstr("number 5 in a row"));
}

TEST_F(Serving, OldTlsIsRefused) {
  if (std::system("openssl version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no openssl here";
  RunningServer server({"block", "--volume-size", "24x22x20", "--secure"});
  const auto agrees = [&](const std::string& offer) {
    const ProgramResult result = runShell("openssl s_client -brief " + offer + " -connect 127.0.0.1:" + server.port() + " < /dev/null 2>&1 | grep 'Protocol version'", folder_.path());
    return result.out;
  };
  EXPECT_THAT(agrees(""), testing::HasSubstr("TLSv1.3"));
  EXPECT_THAT(agrees("-tls1_2 -cipher ECDHE-ECDSA-AES128-GCM-SHA256"), testing::HasSubstr("TLSv1.2"));
  for (const std::string offer : {"-tls1_2 -cipher ECDHE-ECDSA-AES128-SHA", "-tls1_2 -cipher ECDHE-ECDSA-AES256-SHA384", "-tls1_1 -cipher ALL:@SECLEVEL=0"}) EXPECT_EQ(agrees(offer), "") << offer;
}

}  // namespace
}  // namespace warpscope
