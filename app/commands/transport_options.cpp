// Checking what was typed about the network.
// See transport_options.h.
#include "app/commands/transport_options.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/commands/choose.h"
#include "app/frames/transport_json.h"
#include "app/frames/transport_knobs.h"
#include "app/scene/knob_json.h"
#include "app/shell/log.h"
#include "render/base/error.h"
#include "render/base/input_file.h"
#include "render/base/range.h"
#include "render/base/shell_word.h"

namespace warpscope {
namespace {

constexpr Range kDelayMsRange{0.0, 10000.0};

/// What --link takes, from the tables that it is read by.
std::string linkHelp() {
  std::string keys;
  for (const net::LinkKey& key : net::linkKeys())
    keys += (keys.empty() ? "" : "; ") + std::string(key.name) + "=" + std::string(key.form) + ": " + std::string(key.help);
  return "Link to simulate: " + listOf(net::linkPresets()) + "; or KEY=VALUE joined by commas; or a name and then those. With up. or down. before a key " +
         "it is for one direction. " + keys;
}

constexpr const char* kUrlVariable = "WARPSCOPE_URL";
constexpr size_t kLongestUrl = 4096;

std::string trimmed(const std::string& text) {
  constexpr const char* kBlanks = " \t\r\n";
  const size_t first = text.find_first_not_of(kBlanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

std::string firstLineOfInput() {
  std::string line;
  for (int c; line.size() <= kLongestUrl && (c = std::getchar()) != EOF && c != '\n';) line += static_cast<char>(c);
  if (line.size() > kLongestUrl) throw InputError("standard input: its first line is too long for the URL of a server");
  return trimmed(line);
}

void warnOfOthers(const std::filesystem::path& file) {
  std::error_code error;
  const auto others = std::filesystem::perms::group_all | std::filesystem::perms::others_all;
  if (const auto status = std::filesystem::status(file, error); !error && (status.permissions() & others) != std::filesystem::perms::none)
    logWarning(file.string() + " is open to others, who can see the server's pictures with what it holds; close it with: chmod 600 " + shellWord(file.string()));
}

}  // namespace

TransportOptions transportOfKeptPictures() {
  TransportOptions options;
  options.otherwise.codec.color = ColorCoding::lossless;
  return options;
}

void addTransportOptions(CLI::App& command, TransportOptions& options) {
  const HelpSection section(command, "The way from the server");
  command.add_option("--connect", options.connect, "URL of a server, as `warpscope serve` prints it: frames come from there; - reads it from standard input");
  command.add_option("--url-file", options.urlFile,
                     "File that holds such a URL, which then stands on no command line; without either and without a scene: WARPSCOPE_URL in the environment");
  const auto add = [&](const std::string& name, auto& value, const std::string& description) {
    return command.add_option(name, value, description)->each([&options, name](const std::string&) { options.givenOfLink = name; });
  };
  add("--link", options.link, linkHelp());
  add("--delay-ms", options.delayMs, "Round trip to the server in milliseconds, in place of --link");
  for (const auto& row : transportKnobs()) options.knobs.add(command, *row.knob, textOf(*row.knob, row.get(options.otherwise)));
}

void completeConnect(TransportOptions& options, bool namesScene) {
  if (!options.connect.empty() && !options.urlFile.empty()) throw UsageError("--connect and --url-file say the same: give one of them");
  const char* const given = std::getenv(kUrlVariable);
  if (options.connect == "-" || options.urlFile == "-") {
    options.urlFrom = "standard input";
    options.connect = firstLineOfInput();
  } else if (!options.urlFile.empty()) {
    options.urlFrom = options.urlFile;
    options.connect = trimmed(readInputFile(options.urlFile, kLongestUrl, "the URL of a server"));
  } else if (options.connect.empty() && !namesScene && given != nullptr) {
    options.urlFrom = kUrlVariable;
    options.connect = given;
    return;
  } else {
    return;
  }
  if (options.connect.empty()) throw InputError(options.urlFrom + ": holds no URL of a server, as `warpscope serve` prints it");
  if (options.urlFrom == options.urlFile) warnOfOthers(options.urlFile);
}

TransportSettings transportOf(const TransportOptions& options) {
  TransportSettings transport = options.otherwise;
  if (options.delayMs && !options.link.empty()) throw UsageError("--delay-ms and --link say the same: give one of them");
  if (options.delayMs) {
    requireRange(*options.delayMs, kDelayMsRange, "--delay-ms");
    transport.link.up.delayMs = transport.link.down.delayMs = 0.5 * *options.delayMs;
  }
  try {
    if (!options.link.empty()) transport.link = net::parseLinkSettings(options.link);
  } catch (const net::LinkSettingsError& error) {
    throw UsageError("--link " + options.link.substr(0, 80) + ": " + error.what());
  }
  const GivenKnobs given = options.knobs.check();
  for (const auto& row : transportKnobs())
    if (const auto value = given.find(*row.knob)) row.set(transport, *value);
  return transport;
}

nlohmann::json toJson(const FrameLatency& latency) {
  return {{"waitMs", latency.waitMs},       {"wireMs", latency.wireMs},     {"queueMs", latency.queueMs},
          {"marchMs", latency.marchMs},     {"compactMs", latency.compactMs}, {"copyMs", latency.copyMs},
          {"encodeMs", latency.encodeMs},   {"decodeMs", latency.decodeMs}, {"totalMs", latency.totalMs()}};
}

void requireServerFor(const TransportOptions& options) {
  std::string given = options.givenOfLink;
  for (const TransportKnob& row : transportKnobs())
    if ((row.isOfServer || row.knob == &kDepthKnob) && options.knobs.has(*row.knob)) given = row.knob->option;
  if (!given.empty() && options.connect.empty())
    throw UsageError(given + " is about the way from a server, and frames are made here: add --connect URL, or leave it out");
}

std::optional<net::Address> serverOf(const TransportOptions& options) {
  if (options.connect.empty()) return std::nullopt;
  try {
    return net::parseAddress(options.connect);
  } catch (const net::AddressError& error) {
    const std::string reason = options.urlFrom + ": " + error.what();
    if (options.urlFrom == kUrlVariable || options.urlFrom == "--connect") throw UsageError(reason);
    throw InputError(reason);
  }
}

}  // namespace warpscope
