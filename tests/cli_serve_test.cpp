// `serve` and `--connect` through the built program: one URL, the same pictures as at home, clean ends, and what is refused.
// The contract is in README; what goes over the wire is tested in tests/net and hosting_test.cpp.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <functional>

#include "net/address.h"
#include "net/certificate.h"
#include "render/warp/warp.h"
#include "tests/cli.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using std::chrono::milliseconds;
using std::chrono::seconds;

const std::string kFingerprint(64, 'a'), kToken(32, 'b');

/// `serve` on a free port of a host, ready for clients.
class RunningServer {
 public:
  explicit RunningServer(Arguments arguments = {}, const std::string& host = "127.0.0.1", const Arguments& environment = {}) {
    arguments.insert(arguments.begin(), {"serve", "--listen", host + ":0", "--port-file", "port"});
    Arguments variables = environment;  // the first of a name counts
    variables.insert(variables.end(), {"HOME=" + folder_.path().string(), "XDG_DATA_HOME="});
    program_ = std::make_unique<Program>(arguments, folder_.path(), variables);
    const auto deadline = std::chrono::steady_clock::now() + seconds(30);
    while (folder_.read("port").empty() && !program_->hasEnded() && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(milliseconds(5));
    EXPECT_FALSE(program_->hasEnded()) << program_->errSoFar();
  }

  std::string port() const {
    const std::string text = folder_.read("port");
    return text.substr(0, text.find('\n'));
  }
  /// Of a server on loopback without TLS.
  std::string plainUrl() const { return "warp://127.0.0.1:" + port(); }
  std::string errSoFar() const { return program_->errSoFar(); }
  const TestFolder& folder() const { return folder_; }
  /// What was printed; a JSON document if --json was given.
  std::string outSoFar() const { return program_->outSoFar(); }
  std::string url() const {
    const std::string out = outSoFar();
    return out.substr(0, out.find('\n'));
  }

  void signal(int number) const { program_->signal(number); }
  ProgramResult wait() { return program_->wait(); }
  ProgramResult end(int number = SIGTERM) {
    signal(number);
    return wait();
  }

 private:
  TestFolder folder_;
  std::unique_ptr<Program> program_;
};

const Arguments kSmallScene{"block", "--volume-size", "24x22x20"};

/// `url` with another value for `key` ("fp=" or "token=").
std::string withOther(std::string url, const std::string& key, const std::string& value) {
  return url.replace(url.find(key) + key.size(), value.size(), value);
}

/// Somebody else's server: accepts, reads a little, says `answer` and hangs up; an empty answer is silence.
class OtherServer {
 public:
  explicit OtherServer(std::string answer) : answer_(std::move(answer)) {
    socket_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(socket_, 16), 0);
    socklen_t size = sizeof address;
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { run(); });
  }
  ~OtherServer() {
    shutdown(socket_, SHUT_RDWR);
    thread_.join();
    for (const int client : silent_) close(client);
    close(socket_);
  }
  std::string where() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  void run() {
    for (int client; (client = accept(socket_, nullptr, nullptr)) >= 0;) {
      if (answer_.empty()) {
        silent_.push_back(client);
        continue;
      }
      char ignored[256];
      if (recv(client, ignored, sizeof ignored, 0) > 0) static_cast<void>(send(client, answer_.data(), answer_.size(), MSG_NOSIGNAL));
      close(client);
    }
  }

  const std::string answer_;
  int socket_ = -1;
  uint16_t port_ = 0;
  std::vector<int> silent_;
  std::thread thread_;
};

class Serving : public CommandLine {
 protected:
  Arguments shot(const std::string& url, const Arguments& more = {}) const {
    Arguments arguments{"shot", "--connect", url, "--size", "40x30", "-o", "a.png"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  /// As expectRefused, for several commands side by side: some take as long as the program tries again.
  void expectAllRefused(const std::vector<std::pair<Arguments, std::vector<std::string>>>& commands, int code) const {
    const std::vector<std::string> before = folder_.listing();
    std::vector<std::unique_ptr<Program>> running;
    for (const auto& [arguments, reasons] : commands) running.push_back(std::make_unique<Program>(arguments, folder_.path()));
    for (size_t i = 0; i < commands.size(); ++i) {
      SCOPED_TRACE(testing::PrintToString(commands[i].first));
      const ProgramResult result = running[i]->wait();
      EXPECT_EQ(result.code, code);
      EXPECT_EQ(result.out, "");
      EXPECT_THAT(result.err, testing::StartsWith("warpscope: "));
      EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
      for (const std::string& reason : commands[i].second) EXPECT_THAT(result.err, testing::HasSubstr(reason));
      EXPECT_THAT(result.err, testing::Not(testing::HasSubstr(kToken)));
      EXPECT_LT(result.seconds, 25.0);
    }
    EXPECT_EQ(folder_.listing(), before);
  }
};

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
  const auto secondsOf = [&](const Arguments& more) {
    Arguments arguments = shot(server.plainUrl(), more);
    return succeed(arguments).seconds;
  };
  const double plain = secondsOf({});
  for (const Arguments& link : {Arguments{"--link", "delay=300"}, {"--delay-ms", "600"}}) EXPECT_GT(secondsOf(link), plain + 0.5);
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
  EXPECT_THAT(result.err, testing::StartsWith("warpscope: "));
  EXPECT_THAT(result.err, testing::HasSubstr("127.0.0.1:" + server->port()));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_TRUE(folder_.listing().empty());
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

// --- what is refused

TEST_F(Serving, WrongTokensAndFingerprintsAreRefusedAtOnce) {
  RunningServer server({"block", "--volume-size", "24x22x20", "--secure"});
  const auto start = std::chrono::steady_clock::now();
  expectRefused(shot(withOther(server.url(), "token=", kToken)), kFailure, {"does not accept this token"});
  expectRefused(shot(withOther(server.url(), "fp=", kFingerprint)), kFailure, {"fingerprint", kFingerprint});
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(5));
  succeed(shot(server.url()));  // the server bears it
}

/// All of these are tried again for some seconds, in case the server is just being started.
TEST_F(Serving, WhereNoServerAnswersASentenceSaysSo) {
  RunningServer plain(kSmallScene), secure({"block", "--volume-size", "24x22x20", "--secure"});
  const OtherServer http("HTTP/1.1 400 Bad Request\r\nContent-Length: 0\r\n\r\n\r\n\r\n"), silence("");
  const std::string credentials = "/#fp=" + kFingerprint + "&token=" + kToken;
  expectAllRefused(
      {
          {shot("warp://127.0.0.1:1"), {"127.0.0.1:1", "refused"}},
          {shot("warps://127.0.0.1:1" + credentials), {"127.0.0.1:1", "refused"}},
          {shot("warp://localhost:1"), {"localhost:1"}},
          {shot("warp://no-such-host.invalid"), {"no-such-host.invalid"}},
          {shot("warp://127.0.0.1:" + secure.port()), {"127.0.0.1:" + secure.port(), "warps://"}},
          {shot("warps://127.0.0.1:" + plain.port() + credentials), {"127.0.0.1:" + plain.port(), "TLS"}},
          {shot("warp://" + http.where()), {http.where(), "does not speak warpscope's protocol"}},
          {shot("warps://" + http.where() + credentials), {http.where(), "TLS"}},
          {shot("warp://" + silence.where()), {silence.where()}},
          {shot("warps://" + silence.where() + credentials), {silence.where()}},
          {{"compare", "--connect", "warp://127.0.0.1:1", "--out", "out"}, {"127.0.0.1:1"}},
      },
      kFailure);
  succeed(shot(plain.plainUrl()));
}

TEST_F(Serving, AddressesThatAreNone) {
  const std::pair<std::string, std::string> wrong[] = {
      {"127.0.0.1:4711", "warp://HOST:PORT"},
      {"http://127.0.0.1:4711", "warp://HOST:PORT"},
      {"warp://", "the host is missing"},
      {"warp://host:port", "65535"},
      {"warp://host:0", "65535"},
      {"warp://host:65536", "65535"},
      {"warp://host/path", "between the / after the port and the #"},
      {"warp://::1:4711", "brackets"},
      {"warp://[::1", "]"},
      {"warp://256.1.1.1", "IPv4"},
      {"warp://ho st", "host"},
      {"warp://host#fp=1", "warps://"},
      {"warps://host:1", "fingerprint"},
      {"warps://host:1/#token=" + kToken, "fingerprint"},
      {"warps://host:1/#fp=" + kFingerprint, "token"},
      {"warps://host:1/#fp=12&token=" + kToken, "64 hexadecimal digits"},
      {"warps://host:1/#fp=" + kFingerprint + "&token=secret", "token"},
      {"warps://host:1/#fp=" + kFingerprint + "&token=" + kToken + "&more", "nothing else"},
  };
  for (const auto& [url, reason] : wrong) {
    expectRefused(shot(url), kUsage, {"--connect", reason});
    expectRefused({"compare", "--out", "out", "--connect", url}, kUsage, {"--connect", reason});
    expectRefused({"view", "--connect", url}, kUsage, {"--connect", reason});
    const ProgramResult result = run(shot(url));
    for (const std::string& secret : {kToken, std::string("secret")}) EXPECT_THAT(result.err, testing::Not(testing::HasSubstr(secret)));
  }
  expectRefused({"shot", "-o", "a.png", "--connect", ""}, kUsage, {"--connect needs a value"});
}

TEST_F(Serving, AServersSceneLeavesNoRoomForAnother) {
  folder_.write("tf.json", "{}");
  const std::string url = "warp://127.0.0.1:1";
  const std::pair<Arguments, std::string> wrong[] = {
      {{"block"}, "a scene"},
      {{"vessels"}, "a scene"},  // also the one that is the default
      {{"gone.json"}, "a scene"},
      {{"--volume", "gone.nii"}, "--volume"},
      {{"--volume-size", "9x9x9"}, "--volume-size"},
      {{"--seed", "2"}, "--seed"},
      {{"--tf", "tf.json"}, "--tf"},
  };
  for (const auto& [more, reason] : wrong) {
    expectRefused(shot(url, more), kUsage, {"--connect", reason});
    for (Arguments command : {Arguments{"view", "--connect", url}, Arguments{"compare", "--connect", url, "--out", "out"}}) {
      command.insert(command.end(), more.begin(), more.end());
      expectRefused(command, kUsage, {"--connect", reason});
    }
  }
}

TEST_F(Serving, HowFramesTravel) {
  const std::pair<Arguments, std::string> wrong[] = {
      {{"--link", "4h"}, "4g"},
      {{"--link", "4g,"}, ""},
      {{"--link", "delay"}, "KEY=VALUE"},
      {{"--link", "delay=soon"}, "milliseconds"},
      {{"--link", "delay=-1"}, "between 0 and 10000"},
      {{"--link", "delay=nan"}, "milliseconds"},
      {{"--link", "rate=fast"}, "bits per second"},
      {{"--link", "rate=1"}, "rate"},
      {{"--link", "loss=90%"}, "loss"},
      {{"--link", "outage=5"}, "LENGTH/INTERVAL"},
      {{"--link", "jitter=5"}, "jitter"},
      {{"--link", "trace=gone.txt"}, "gone.txt"},
      {{"--link", "colour=red"}, "colour"},
      {{"--link", "4g", "--delay-ms", "10"}, "--delay-ms and --link"},
      {{"--delay-ms", "-1"}, "--delay-ms must be between 0 and 10000"},
      {{"--delay-ms", "10001"}, "--delay-ms"},
      {{"--delay-ms", "nan"}, "--delay-ms"},
      {{"--codec", "zip"}, "codec"},
      {{"--codec", "pack"}, "packed"},
      {{"--color", "png"}, "colour coding"},
      {{"--color", "lossles"}, "lossless"},
      {{"--quality", "0"}, "--quality must be between 1 and 100"},
      {{"--quality", "101"}, "--quality"},
      {{"--quality", "best"}, "--quality"},
      {{"--depth", "0"}, "--depth must be between 1 and 16"},
      {{"--depth", "17"}, "--depth"},
      {{"--depth", "1.5"}, "--depth"},
  };
  const std::string url = "warp://127.0.0.1:1";
  for (const auto& [more, reason] : wrong) {
    if (more[1] == "4g,") continue;  // a comma at the end is borne
    expectRefused(shot(url, more), kUsage, {reason});
    Arguments view{"view"};
    view.insert(view.end(), more.begin(), more.end());
    expectRefused(view, kUsage, {reason});
  }
  // Where frames are made here, nothing travels.
  const Arguments travelling[] = {{"--link", "4g"}, {"--delay-ms", "5"}, {"--depth", "2"}};
  for (const Arguments& more : travelling) {
    Arguments command{"shot", "-o", "a.png"};
    command.insert(command.end(), more.begin(), more.end());
    expectRefused(command, kUsage, {more[0], "--connect"});
  }
}

TEST_F(Serving, PlacesThatCannotBeListenedOn) {
  const std::pair<std::string, std::string> wrong[] = {
      {"127.0.0.1:port", "65535"}, {"127.0.0.1:65536", "65535"}, {"127.0.0.1:-1", "65535"}, {":4711", "host is missing"},
      {"::1:4711", "brackets"},    {"[::1]4711", "port"},        {"999.0.0.1:0", "IPv4"},   {"a b:0", "host"},
  };
  for (const auto& [listen, reason] : wrong) expectRefused({"serve", "block", "--listen", listen}, kUsage, {"--listen", reason});
  expectRefused({"serve", "block", "--listen", ""}, kUsage, {"--listen needs a value"});

  RunningServer server(kSmallScene);
  const Arguments small{"serve", "block", "--volume-size", "9x9x9", "--listen"};
  const auto on = [&](const std::string& place) {
    Arguments arguments = small;
    arguments.push_back(place);
    return arguments;
  };
  expectRefused(on("127.0.0.1:" + server.port()), kFailure, {"127.0.0.1:" + server.port(), "in use"});
  // Others than loopback want an identity first: in a home of their own.
  const TestFolder home;
  for (const std::string place : {"192.0.2.1:0", "no-such-host.invalid:0"}) {
    const ProgramResult result = run(on(place), {"HOME=" + home.path().string(), "XDG_DATA_HOME="});
    EXPECT_EQ(result.code, kFailure);
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, testing::StartsWith("warpscope: cannot listen on " + place + ": "));
  }
  expectRefused({"serve", "--port-file", "missing/port"}, kFailure, {"missing/port", "cannot be written"});
  expectRefused({"serve", "blok", "--listen", "127.0.0.1:0"}, kUsage, {"blok", "block"});
  EXPECT_TRUE(folder_.listing().empty());
}

TEST_F(Serving, IdentitiesThatCannotBeKept) {
  const auto refuse = [&](const Arguments& environment, const std::vector<std::string>& reasons) {
    SCOPED_TRACE(testing::PrintToString(environment));
    const std::vector<std::string> before = folder_.listing();
    for (const Arguments& how : {Arguments{"--secure"}, Arguments{"--listen", "0.0.0.0:0"}}) {
      Arguments arguments{"serve", "block", "--volume-size", "9x9x9", "--port-file", "port"};
      arguments.insert(arguments.end(), how.begin(), how.end());
      const ProgramResult result = run(arguments, environment);
      EXPECT_EQ(result.code, kFailure);
      EXPECT_EQ(result.out, "");
      EXPECT_THAT(result.err, testing::StartsWith("warpscope: "));
      EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
      for (const std::string& reason : reasons) EXPECT_THAT(result.err, testing::HasSubstr(reason));
    }
    EXPECT_EQ(folder_.listing(), before);
  };
  refuse({"HOME=", "XDG_DATA_HOME="}, {"HOME"});
  refuse({"HOME=here", "XDG_DATA_HOME=here"}, {"HOME"});  // a folder that depends on where one stands
  refuse({"HOME=/proc", "XDG_DATA_HOME="}, {"/proc/.local/share/warpscope", "cannot be made"});
  folder_.write("file", "");
  refuse({"XDG_DATA_HOME=" + folder_.file("file")}, {folder_.file("file")});

  fs::create_directory(folder_.path() / "warpscope");
  const std::string identity = folder_.file("warpscope/identity.pem");
  net::loadOrMakeIdentity(folder_.path() / "warpscope");
  fs::permissions(identity, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  refuse({"XDG_DATA_HOME=" + folder_.path().string()}, {identity, "others can read"});
  fs::permissions(identity, fs::perms::owner_read | fs::perms::owner_write);
  std::ofstream(identity) << "no key";
  refuse({"XDG_DATA_HOME=" + folder_.path().string()}, {identity});
}

}  // namespace
}  // namespace warpscope
