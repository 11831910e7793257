// `serve`: a scene's frames for clients elsewhere, without a window.
// Loopback alone unless there are a certificate and a token; what is printed holds both, and is all that a client needs.
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/commands/options.h"
#include "app/frames/backend.h"
#include "app/frames/frame_server.h"
#include "app/frames/process_ranks.h"
#include "app/scene/json_document.h"
#include "app/shell/interrupt.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "net/certificate.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

namespace fs = std::filesystem;

struct ServeOptions {
  CommonOptions common;
  std::string listen = "127.0.0.1:4711";
  std::string portFile;
  bool isSecure = false;
  double workSeconds = std::chrono::duration<double>(ServeLimits{}.work).count();
  int clients = static_cast<int>(net::ServerSettings{}.clients.most);
  double memoryMiB = static_cast<double>(ServeLimits{}.memoryBytes >> 20);
};

/// Where the server's identity is kept. XDG Base Directory Specification.
fs::path identityFolder() {
  const char* data = std::getenv("XDG_DATA_HOME");
  if (data != nullptr && fs::path(data).is_absolute()) return fs::path(data) / "warpscope";
  const char* home = std::getenv("HOME");
  if (home == nullptr || !fs::path(home).is_absolute())
    throw InputError("neither XDG_DATA_HOME nor HOME says where to keep the server's certificate");
  return fs::path(home) / ".local" / "share" / "warpscope";
}

/// What clients call a server that listens on all of a machine's addresses.
std::string hostFor(const std::string& listened) {
  if (listened != "0.0.0.0" && listened != "::") return listened;
  char name[256] = "";
  if (gethostname(name, sizeof name - 1) != 0 || *name == '\0') return "localhost";
  return name;
}

/// As many connections as there may be need descriptors; systems begin with a limit that is far below what they allow.
void raiseFileLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= limit.rlim_max) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);  // without it, the server waits for descriptors where they are short
}

ServeLimits limitsFrom(const ServeOptions& options) {
  requireRange(options.workSeconds, Range{0.01, 1e6}, "--work-limit");
  requireRange(options.memoryMiB, Range{64.0, 1e7}, "--memory-limit");
  ServeLimits limits;
  limits.work = std::chrono::nanoseconds(std::llround(options.workSeconds * 1e9));
  limits.memoryBytes = static_cast<size_t>(options.memoryMiB * (1 << 20));
  return limits;
}

void waitForEnd(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any ended;
  std::unique_lock lock(mutex);
  ended.wait(lock, stop, [] { return false; });
}

net::ServerSettings settingsFor(const ServeOptions& options, const net::HostPort& listen) {
  requireRange(static_cast<double>(options.clients), Range{1.0, 4096.0}, "--clients");
  net::ServerSettings settings;
  settings.listen = listen;
  settings.clients.most = static_cast<size_t>(options.clients);
  settings.clients.mostOfAnAddress = settings.clients.most - settings.clients.most / 4;  // nobody takes all places alone
  settings.onNote = logDetail;
  settings.onWrongToken = logWarning;
  if (options.isSecure || !net::isLoopback(listen.host)) {
    settings.identity = net::loadOrMakeIdentity(identityFolder());
    settings.token = net::Token::random();
  }
  return settings;
}

void serve(const ServeOptions& options) {
  net::HostPort listen;
  try {
    listen = net::parseListenAddress(options.listen);
  } catch (const net::AddressError& error) {
    throw UsageError(std::string("--listen: ") + error.what());
  }
  const ServeLimits limits = limitsFrom(options);
  const Interrupt interrupt;
  if (!options.portFile.empty()) requireWritable(options.portFile);
  net::ServerSettings settings = settingsFor(options, listen);
  const CommandContext work = prepare(options.common, interrupt.token());
  requireUnread(options.portFile, options.common, work.scene);
  raiseFileLimit();
  const auto io = std::make_shared<net::IoThread>();
  auto progress = std::make_unique<Progress>("preparing", 1, !options.common.showsProgress());
  progress->step(work.scene.name);
  const MarcherPtr marcher = work.marcher();
  progress.reset();
  FrameServer::Processes processes;
  if (const BrickLeaderPtr leader = leaderOf(work.scene.volume)) processes = [leader] { return knownWork(leader); };
  FrameServer server(io, work.scene, marcher, std::move(settings), limits, std::move(processes));

  net::Address address = server.address();
  address.where.host = hostFor(address.where.host);
  const std::string url = net::toString(address);
  if (options.common.json)
    std::cout << textOf({{"url", url}, {"port", server.port()}, {"scene", work.scene.name}});
  else
    std::cout << url << '\n';
  if (!std::cout.flush()) throw InputError("standard output cannot be written to");
  if (!options.portFile.empty()) writeFileWhole(options.portFile, std::to_string(server.port()) + "\n");
  logDetail("serving " + work.scene.name + " at " + net::toStringWithoutToken(address));
  waitForEnd(interrupt.token());
  logDetail("serving has ended");
}

}  // namespace

void addServeCommand(CLI::App& program, std::function<void()>& chosen) {
  auto options = std::make_shared<ServeOptions>();
  CLI::App* command = program.add_subcommand("serve", "A server of one scene, for view, shot and compare elsewhere");
  addSceneOptions(*command, options->common);
  command->add_option("--listen", options->listen, "ADDR:PORT; beyond this machine only with TLS and a token; port 0 takes a free one")
      ->capture_default_str();
  command->add_option("--port-file", options->portFile, "File to write the port to once clients can connect");
  command->add_flag("--secure", options->isSecure, "TLS and a token also on loopback");
  command->add_option("--clients", options->clients, "Clients at a time, three quarters of them from one address; one more takes the place of one that does nothing, or is turned away")->capture_default_str();
  command->add_option("--work-limit", options->workSeconds, "Seconds of marching that a request may take")
      ->capture_default_str();
  command->add_option("--memory-limit", options->memoryMiB, "MiB of memory for all frames that are made or sent; one gets at most a 16th of it. By itself half of the machine's, at most 8192");
  command->callback([options, &chosen] { chosen = [options] { serve(*options); }; });
}

}  // namespace warpscope
