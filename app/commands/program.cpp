// Finding the command, running it, and turning failures into one sentence and an exit code.
// See program.h.
#include "app/commands/program.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

#if defined(SIGBUS)
#include <unistd.h>
#endif

#include "app/commands/options.h"
#include "app/frames/process_ranks.h"
#include "app/shell/log.h"
#include "app/shell/output_files.h"
#include "app/shell/progress.h"
#include "app/ui/run_window.h"
#include "render/base/abandonable.h"
#include "render/base/error.h"
#include "render/base/mapped_files.h"
#include "render/base/nearest_name.h"

namespace warpscope {
namespace {

constexpr int kFailure = 1;
constexpr int kUsage = 2;

/// Commands that several processes run together.
constexpr std::string_view kShared[] = {"serve", "shot", "compare", "sweep", "bench", "plan", "export"};

/// One of several processes that is not the first: what is wrong for all of them, the first one says.
bool isFollower() { return processRanks() && !processRanks()->isFirst(); }

/// What a sentence about this process begins with: of several processes, with which it is.
std::string selfNamed() {
  std::string self = "warpscope: ";
  if (processRanks()) self += "process " + std::to_string(processRanks()->rank()) + " of " + std::to_string(processRanks()->size()) + ": ";
  return self;
}

/// The same for a signal's handler: set before files are read.
std::string selfForHandler = "warpscope: ";

/// One line, whatever a file's name brings with it; of several processes that fail alike, one's.
int complain(const std::string& text, int code, bool isToldToEnd = false) {
  // As long as the first one may be behind the others, on a machine with more to do than this; and until all are ended once somebody has said it.
  constexpr std::chrono::milliseconds kPatience(2000), kEnd(5000);
  constexpr std::chrono::milliseconds kShortly(100);  // what has been said is on its way, and signals end all soon
  if (processRanks() && !processRanks()->claimLastWord(isToldToEnd && processRanks()->isFirst() ? kShortly : kPatience, isToldToEnd)) {
    std::this_thread::sleep_for(isToldToEnd ? kShortly : kEnd);
    return code;
  }
  printLine((isFollower() ? selfNamed() : "warpscope: ") + text);
  return code;
}

/// What is wrong with the command line, and whose help would tell.
std::string sentenceOf(const CLI::ParseError& error, const CLI::App& program) {
  const std::vector<CLI::App*> parsed = program.get_subcommands();
  const CLI::App& command = parsed.empty() ? program : *parsed.front();
  const std::string help = " (see warpscope " + (parsed.empty() ? "" : command.get_name() + " ") + "--help)";

  // A word that nobody understood comes first: it may be why something else is missing.
  const std::vector<std::string> extras = program.remaining(true);
  const auto isOption = [](const std::string& word) { return word.starts_with('-'); };
  auto extra = parsed.empty() ? extras.begin() : std::find_if(extras.begin(), extras.end(), isOption);
  if (extra == extras.end()) extra = extras.begin();
  std::vector<std::string> names;
  if (extra != extras.end() && isOption(*extra)) {
    for (const CLI::Option* option : command.get_options())
      if (!option->get_lnames().empty()) names.push_back(option->get_lnames().front());
    const std::string name = extra->substr(0, std::min<size_t>(extra->find('='), 80));
    const std::string_view bare = std::string_view(name).substr(std::min(name.size(), name.find_first_not_of('-')));
    const auto nearest = nearestName(bare, std::vector<std::string_view>(names.begin(), names.end()));
    return "unknown option '" + name + "'" + (nearest ? "; did you mean '--" + std::string(*nearest) + "'?" : "") + help;
  }
  if (extra != extras.end() && parsed.empty()) {
    if (*extra == "help") return "there is no command 'help': ask for warpscope --help, or COMMAND --help";
    for (const CLI::App* known : program.get_subcommands([](const CLI::App*) { return true; })) names.push_back(known->get_name());
    return unknownName("command", *extra, std::vector<std::string_view>(names.begin(), names.end())) + help;
  }
  if (extra != extras.end()) return "unexpected '" + extra->substr(0, 80) + "'" + help;

  const std::string text = error.what();
  // The library says "--out: 1 required TEXT missing" and "--out: At Most 1 required but received 2".
  if (const size_t at = text.find(": 1 required "); at != std::string::npos) return text.substr(0, at) + " needs a value" + help;
  if (const size_t at = text.find(": At Most 1 "); at != std::string::npos) return text.substr(0, at) + " is given more than once" + help;
  // And "Could not convert: --seed = -1".
  if (constexpr std::string_view kUnread = "Could not convert: "; text.starts_with(kUnread))
    if (const size_t equals = text.find(" = "); equals != std::string::npos) {
      const std::string name = text.substr(kUnread.size(), equals - kUnread.size());
      const CLI::Option* const option = command.get_option_no_throw(name);
      const std::string type = option != nullptr ? option->get_type_name() : "";
      const std::string wanted = type.starts_with("UINT") ? "a whole number from 0 on" : type.starts_with("INT") ? "a whole number" : type.starts_with("FLOAT") ? "a number" : "what it takes";
      return name + " " + text.substr(equals + 3, 80) + ": give " + wanted + help;
    }
  return text + help;
}

/// A pipe that nobody reads any more and a file that may not grow make writing fail, which is reported and cleaned up after, instead of
/// ending the process where it is.
void failInsteadOfDying() {
#if defined(SIGPIPE)
  std::signal(SIGPIPE, SIG_IGN);
#endif
#if defined(SIGXFSZ)
  std::signal(SIGXFSZ, SIG_IGN);
#endif
#if defined(SIGBUS)
  // Of raw volumes, which are mapped.
  struct sigaction action {};
  action.sa_flags = SA_SIGINFO;
  action.sa_sigaction = [](int, siginfo_t* info, void*) {
    constexpr std::string_view kUnknown = "a file that is mapped into memory", kWhy = " cannot be read: it has become shorter while it was read, or its disk fails\n";
    std::array<char, 1024> line;
    char* at = std::ranges::copy(selfForHandler, line.data()).out;
    const size_t room = static_cast<size_t>(line.end() - at) - kWhy.size();
    if (const size_t length = nameMappedPage(info->si_addr, at, room); length > 0)
      at += length;
    else
      at = std::ranges::copy(kUnknown, at).out;
    at = std::ranges::copy(kWhy, at).out;
    [[maybe_unused]] const auto ignored = ::write(STDERR_FILENO, line.data(), static_cast<size_t>(at - line.data()));
    std::_Exit(kFailure);
  };
  sigaction(SIGBUS, &action, nullptr);
#endif
}

/// The window's OpenGL comes through GLX, that of its panels through EGL, each in threads of its own. GLVND, which sits between, lets the first
/// driver that it hands a thread to write into its entry points, after which another cannot be current anywhere: NVIDIA's GLX locks NVIDIA's EGL
/// out. This forbids it (libglvnd, README, "__GLVND_DISALLOW_PATCHING"); what the user has set stays. Before any thread.
void shareOpenGlDispatch() {
#if !defined(_WIN32)
  setenv("__GLVND_DISALLOW_PATCHING", "1", 0);
#endif
}

/// What was printed.
void requireWritten() {
  if (!std::cout.flush()) throw InputError("standard output cannot be written to");
}

int run(int argc, char** argv) {
  CLI::App program("warpscope shows what different ways of warping a remote volume rendering do to the picture, and what each costs.",
                   "warpscope");
  program.require_subcommand(0, 1);
  program.set_version_flag("--version", WARPSCOPE_VERSION);
  std::function<void()> chosen;
  addViewCommand(program, chosen);
  addServeCommand(program, chosen);
  addShotCommand(program, chosen);
  addCompareCommand(program, chosen);
  addCheckCommand(program, chosen);
  addReplayCommand(program, chosen);
  addBenchCommand(program, chosen);
  addPlanCommand(program, chosen);
  addSweepCommand(program, chosen);
  addStabilityCommand(program, chosen);
  addExportCommand(program, chosen);
  addInfoCommand(program, chosen);
  for (CLI::App* command : program.get_subcommands([](CLI::App*) { return true; })) requireValues(*command);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) return complain(sentenceOf(error, program), kUsage);
    if (!isFollower()) program.exit(error);  // --help, --version
    requireWritten();
    return 0;
  }
  if (processRanks()) {
    const std::vector<CLI::App*> commands = program.get_subcommands();
    const std::string name = commands.empty() ? "view" : commands.front()->get_name();
    if (std::ranges::find(kShared, name) == std::end(kShared)) throw UsageError("'" + name + "' is for one process; start it without mpirun");
  }
  if (chosen) {
    chosen();
    requireWritten();
    return 0;
  }
  try {
    viewDefaultScene();
  } catch (const NoDisplay&) {
    printLine("warpscope: no display here, so compare runs on the default scene into ./out");
    compareDefaultScene("out");
  }
  return 0;
}

int runToExitCode(int argc, char** argv) {
  try {
    joinProcesses();
    if (processRanks() && processRanks()->isFirst()) showProgressAtControllingTerminal();
    if (isFollower()) muteLog();
    selfForHandler = selfNamed();
    return run(argc, argv);
  } catch (const FollowedToTheEnd&) {
    return 0;
  } catch (const UsageError& error) {
    return complain(error.what(), kUsage);
  } catch (const OperationCancelled&) {
    return complain("stopped; nothing was written", kFailure, true);
  } catch (const std::bad_alloc&) {
    return complain("not enough memory", kFailure);
  } catch (const std::exception& error) {
    return complain(error.what(), kFailure);
  }
}

}  // namespace

int runProgram(int argc, char** argv) {
  if (const std::optional<int> code = goOnWatched()) return *code;
  noteInheritedFiles();
  failInsteadOfDying();
  shareOpenGlDispatch();
  const int code = runToExitCode(argc, argv);
  if (processRanks()) {
    std::cout.flush();
    if (code != 0) endProcesses(code);  // others may wait for this one
    leaveProcesses(code);
  }
  if (!isAnythingAbandoned()) return code;
  // A reader that was left alone still uses what would be torn down now.
  std::cout.flush();
  std::fflush(nullptr);
  std::_Exit(code);
}

}  // namespace warpscope
