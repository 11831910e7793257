// Checking what was typed about the network.
// See transport_options.h.
#include "app/commands/transport_options.h"

#include "app/commands/choose.h"
#include "app/frames/transport_knobs.h"
#include "app/scene/knob_json.h"
#include "render/base/error.h"
#include "render/base/range.h"

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

}  // namespace

TransportOptions transportOfKeptPictures() {
  TransportOptions options;
  options.otherwise.codec.color = ColorCoding::lossless;
  return options;
}

void addTransportOptions(CLI::App& command, TransportOptions& options) {
  command.add_option("--connect", options.connect, "URL of a server, as `warpscope serve` prints it: frames come from there");
  const auto add = [&](const std::string& name, auto& value, const std::string& description) {
    return command.add_option(name, value, description)->each([&options, name](const std::string&) { options.givenOfLink = name; });
  };
  add("--link", options.link, linkHelp());
  add("--delay-ms", options.delayMs, "Round trip to the server in milliseconds, in place of --link");
  for (const auto& row : transportKnobs()) options.knobs.add(command, *row.knob, textOf(*row.knob, row.get(options.otherwise)));
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

nlohmann::json toJson(const TransportSettings& transport) {
  nlohmann::json json{{"link", net::toString(transport.link)}};
  for (const auto& row : transportKnobs()) json[std::string(row.knob->key)] = jsonOf(*row.knob, row.get(transport));
  return json;
}

nlohmann::json toJson(const FrameLatency& latency) {
  return {{"waitMs", latency.waitMs},       {"wireMs", latency.wireMs},     {"queueMs", latency.queueMs},
          {"marchMs", latency.marchMs},     {"compactMs", latency.compactMs}, {"copyMs", latency.copyMs},
          {"encodeMs", latency.encodeMs},   {"decodeMs", latency.decodeMs}, {"totalMs", latency.totalMs()}};
}

void requireServerFor(const TransportOptions& options) {
  const std::string given = options.knobs.has(kDepthKnob) ? std::string(kDepthKnob.option) : options.givenOfLink;
  if (!given.empty() && options.connect.empty())
    throw UsageError(given + " is about the way from a server, and frames are made here: add --connect URL, or leave it out");
}

std::optional<net::Address> serverOf(const TransportOptions& options) {
  if (options.connect.empty()) return std::nullopt;
  try {
    return net::parseAddress(options.connect);
  } catch (const net::AddressError& error) {
    throw UsageError(std::string("--connect: ") + error.what());
  }
}

}  // namespace warpscope
