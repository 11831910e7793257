// Connecting and listening that cannot be, through the built program: a sentence each, in time, and nothing left behind.
// The contract is in README; clean connections are in cli_serve_test.cpp.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include "net/certificate.h"
#include "tests/running_server.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const std::string kFingerprint(64, 'a');

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

/// A resolver that hangs, as one without a network does: nobody who interrupts has to wait for it.
TEST_F(Serving, ALookupIsInterruptedAtOnce) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers want to be loaded first";
#endif
  for (const Arguments& command : {Arguments{"shot", "-o", "a.png"}, {"compare", "--out", "out"}}) {
    Arguments arguments = command;
    arguments.insert(arguments.end(), {"--connect", "warp://slow.name:1"});
    Program program(arguments, folder_.path(), {std::string("LD_PRELOAD=") + WARPSCOPE_SLOW_LOOKUP});
    const auto deadline = std::chrono::steady_clock::now() + seconds(20);
    while (program.errSoFar().find("looking up slow.name") == std::string::npos && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(milliseconds(5));
    const auto start = std::chrono::steady_clock::now();
    program.signal(SIGINT);
    const ProgramResult result = program.wait();
    EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(2));
    EXPECT_EQ(result.code, kFailure);
    EXPECT_THAT(result.err, testing::HasSubstr("looking up slow.name"));
    EXPECT_TRUE(folder_.listing().empty());
  }
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
  refuse({"XDG_DATA_HOME=" + folder_.path().string()}, {folder_.file("warpscope"), "others can look into", "chmod 700"});
  fs::permissions(folder_.path() / "warpscope", fs::perms::owner_all);
  net::loadOrMakeIdentity(folder_.path() / "warpscope");
  fs::permissions(identity, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  refuse({"XDG_DATA_HOME=" + folder_.path().string()}, {identity, "others can read"});
  fs::permissions(identity, fs::perms::owner_read | fs::perms::owner_write);
  std::ofstream(identity) << "no key";
  refuse({"XDG_DATA_HOME=" + folder_.path().string()}, {identity});
}

/// Where others see the command lines of all, an address with its token comes another way.
TEST_F(Serving, AddressesNeedNotStandOnTheCommandLine) {
  RunningServer server({"block", "--volume-size", "24x22x20", "--secure"});
  const std::string url = server.url();
  const Arguments shot{"shot", "--size", "40x30", "-o", "a.png"};
  const auto with = [&](const Arguments& more) {
    Arguments arguments = shot;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  const auto expectDrawn = [&](const ProgramResult& result) {
    EXPECT_EQ(result.code, kSuccess) << result.err;
    EXPECT_TRUE(fs::remove(folder_.path() / "a.png"));
  };
  succeed(with({"block", "--volume-size", "24x22x20"}));
  const std::string local = folder_.read("a.png");

  fs::permissions(folder_.write("url", "\n  " + url + "\r\n"), fs::perms::owner_read | fs::perms::owner_write);
  const ProgramResult fromFile = run(with({"--url-file", "url"}));
  EXPECT_THAT(fromFile.err, testing::Not(testing::HasSubstr("open to others")));
  EXPECT_EQ(folder_.read("a.png"), local);
  expectDrawn(fromFile);
  expectDrawn(run(shot, {"WARPSCOPE_URL=" + url}));
  const std::string line = "shot --size 40x30 -o a.png ";
  folder_.write("input", url + "\nmore\n");
  for (const std::string how : {"--connect -", "--url-file -"}) expectDrawn(runShell("\"$W\" " + line + how + " < input", folder_.path()));
  expectDrawn(runShell("\"$W\" compare --size 40x30 --out out --connect - < input && mv out/montage.png a.png && rm -r out", folder_.path()));

  // What is nearer to the command wins; two at once are none.
  expectDrawn(run(with({"--connect", url}), {"WARPSCOPE_URL=warp://127.0.0.1:1"}));
  expectDrawn(run(with({"--url-file", "url"}), {"WARPSCOPE_URL=warp://127.0.0.1:1"}));
  expectDrawn(run(with({"block", "--volume-size", "24x22x20"}), {"WARPSCOPE_URL=warp://127.0.0.1:1"}));
  expectRefused(with({"--connect", url, "--url-file", "url"}), kUsage, {"--connect and --url-file"});
  expectRefused(with({"block", "--url-file", "url"}), kUsage, {"leave out a scene"});

  fs::permissions(folder_.path() / "url", fs::perms::others_read, fs::perm_options::add);
  const ProgramResult open = run(with({"--url-file", "url"}));
  EXPECT_THAT(open.err, testing::HasSubstr("warning: url is open to others"));
  EXPECT_THAT(open.err, testing::HasSubstr("chmod 600 url"));
  expectDrawn(open);
}

TEST_F(Serving, FilesThatHoldNoAddress) {
  folder_.write("empty", "\n");
  folder_.write("wrong", "warps://host:1/#fp=" + kFingerprint + "&token=secret");
  folder_.write("large", std::string(5000, 'x'));
  ASSERT_EQ(mkfifo(folder_.file("pipe").c_str(), 0600), 0);
  const std::pair<std::string, std::string> wrong[] = {
      {"empty", "empty: holds no URL"}, {"wrong", "wrong: "},          {"large", "large: is too large"}, {"pipe", "pipe: is no regular file"},
      {".", "is a directory"},            {"gone", "gone: there is no"}, {"-", "standard input: holds no URL"}};
  for (const auto& [name, reason] : wrong) {
    for (Arguments command : {Arguments{"shot", "-o", "a.png"}, {"compare", "--out", "out"}, {"view"}}) {
      command.insert(command.end(), {"--url-file", name});
      if (name != "wrong") expectRefused(command, kFailure, {reason});
    }
  }
  fs::permissions(folder_.path() / "wrong", fs::perms::owner_read);
  expectRefused({"shot", "-o", "a.png", "--url-file", "wrong"}, kFailure, {"wrong: ", "the token"});
  const ProgramResult result = run({"shot", "-o", "a.png"}, {"WARPSCOPE_URL=http://host"});
  EXPECT_EQ(result.code, kUsage);
  EXPECT_THAT(result.err, testing::StartsWith("warpscope: WARPSCOPE_URL: "));
}

/// Silence, and a link so slow that nothing of what is asked comes in time: at any stage the time ends the command, and nothing is left.
TEST_F(Serving, AShotWaitsNoLongerThanItIsTold) {
  RunningServer plain(kSmallScene);
  const OtherServer silence("");
  const std::string slow = "delay=2000";
  for (const auto& [url, more] : std::vector<std::pair<std::string, Arguments>>{
           {"warp://" + silence.where(), {}},                              // no greeting
           {plain.plainUrl(), {"--link", slow}},                            // a scene that is late
           {plain.plainUrl(), {"--delay-ms", "1500"}},                                                         // a frame that is
           {plain.plainUrl(), {"--technique", "reference", "--size", "2048x2048", "--step", "0.001"}}}) {  // a picture that takes long
    Arguments arguments{"shot", "--connect", url, "-o", "a.png", "--timeout", "2.5"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto start = std::chrono::steady_clock::now();
    expectRefused(arguments, kFailure, {url.substr(7), "within 2.5 s (--timeout)"});
    const auto took = std::chrono::steady_clock::now() - start;
    EXPECT_GE(took, milliseconds(2500));
    EXPECT_LT(took, seconds(6));
  }
  succeed(shot(plain.plainUrl(), {"--timeout", "60"}));
  for (const std::string timeout : {"0.9", "0", "-1", "nan", "inf", "1e9"}) expectRefused(shot(plain.plainUrl(), {"--timeout", timeout}), kUsage, {"--timeout"});
  expectRefused({"shot", "-o", "b.png", "--timeout", "5"}, kUsage, {"--timeout", "--connect"});
  expectRefused({"shot", "--connect", "warp://127.0.0.1:1", "-o", "b.png", "--timeout", "1"}, kFailure, {"within 1 s (--timeout)", "refused"});  // why it was never reached
}

}  // namespace
}  // namespace warpscope
