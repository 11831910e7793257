// `serve` as tests run it: a server on a free port with a folder of its own, and commands that connect to it.
// Ready when the port file is there; ends with a signal.
#pragma once

#include "tests/cli.h"

namespace warpscope {

using std::chrono::milliseconds;
using std::chrono::seconds;

inline const std::string kToken(32, 'b');

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

inline const Arguments kSmallScene{"block", "--volume-size", "24x22x20"};

/// `url` with another value for `key` ("fp=" or "token=").
inline std::string withOther(std::string url, const std::string& key, const std::string& value) {
  return url.replace(url.find(key) + key.size(), value.size(), value);
}

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

}  // namespace warpscope
