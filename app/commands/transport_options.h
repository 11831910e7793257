// Options about the network: where frames come from and how they travel.
// Shared by the commands that take frames from a server.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "app/commands/knob_options.h"
#include "app/frames/frame_source.h"
#include "app/frames/transport_json.h"
#include "net/address.h"

namespace warpscope {

/// As typed; checked by the functions below.
struct TransportOptions {
  std::string connect, urlFile;
  std::string urlFrom = "--connect";  ///< what `connect` came from: see completeConnect
  std::string link;
  std::optional<double> delayMs;
  KnobOptions knobs;            ///< of transportKnobs()
  TransportSettings otherwise;  ///< what holds where nothing is typed; set it before the options are added
  std::string givenOfLink;      ///< --link or --delay-ms, if one was typed
};

/// Colours without loss where nothing else is typed: pictures that are compared and kept show what warping does, not what compressing colours does.
TransportOptions transportOfKeptPictures();

/// Adds --connect, --url-file, --link, --delay-ms and an option for each of transportKnobs().
void addTransportOptions(CLI::App& command, TransportOptions& options);

/// Command lines are public on a machine that several people use, so that a URL with its token may come another way: sets `connect` from --url-file, from
/// standard input (-), or, where neither is given and `namesScene` is false, from WARPSCOPE_URL in the environment. Throws UsageError for two at once,
/// InputError for a file that cannot be read.
void completeConnect(TransportOptions& options, bool namesScene);

/// Throws UsageError.
TransportSettings transportOf(const TransportOptions& options);
/// As the program reports them.
nlohmann::json toJson(const FrameLatency& latency);

/// For commands that make their own frames without a server: throws UsageError if there is none, but an option about the way from it.
void requireServerFor(const TransportOptions& options);
/// The server to connect to, if one was named. Throws UsageError, or InputError if the URL was in a file. Comes after completeConnect.
std::optional<net::Address> serverOf(const TransportOptions& options);

}  // namespace warpscope
