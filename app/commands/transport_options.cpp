// Checking what was typed about the network.
// See transport_options.h.
#include "app/commands/transport_options.h"

#include "app/commands/choose.h"
#include "render/base/error.h"
#include "render/base/range.h"

namespace warpscope {
namespace {

constexpr Range kDelayMsRange{0.0, 10000.0};

}  // namespace

void addTransportOptions(CLI::App& command, TransportOptions& options) {
  command.add_option("--connect", options.connect, "URL of a server, as `warpscope serve` prints it: frames come from there");
  const auto add = [&](const std::string& name, auto& value, const std::string& description) {
    return command.add_option(name, value, description)->each([&options, name](const std::string&) { options.given = name; });
  };
  add("--link", options.link,
      "Link to simulate: " + listOf(net::linkPresets()) +
          ", or delay=MS,jitter=MS,rate=BIT/S,loss=P%,outage=MS/MS,seed=N; with up. or down. before a key for one direction");
  add("--delay-ms", options.delayMs, "Round trip to the server in milliseconds, in place of --link");
  command.add_option("--codec", options.codec, "How samples travel: " + listOf(kPayloadFormats))->capture_default_str();
  command.add_option("--color", options.color, "How their colours travel: " + listOf(kColorCodings))->capture_default_str();
  command.add_option("--quality", options.quality, "Of jpeg, " + rangeText(kJpegQualityRange))->capture_default_str();
  add("--depth", options.depth, "Requests under way at a time, " + rangeText(kDepthRange))->capture_default_str();
}

TransportSettings transportOf(const TransportOptions& options) {
  TransportSettings transport;
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
  transport.codec.format = choose("codec", options.codec, kPayloadFormats);
  transport.codec.color = choose("colour coding", options.color, kColorCodings);
  transport.codec.jpegQuality = options.quality;
  requireRange(static_cast<double>(options.quality), kJpegQualityRange, "--quality");
  requireRange(static_cast<double>(options.depth), kDepthRange, "--depth");
  transport.depth = options.depth;
  return transport;
}

nlohmann::json toJson(const TransportSettings& transport) {
  return {{"link", net::toString(transport.link)},
          {"codec", nameOf(transport.codec.format)},
          {"color", nameOf(transport.codec.color)},
          {"quality", transport.codec.jpegQuality},
          {"depth", transport.depth}};
}

nlohmann::json toJson(const FrameLatency& latency) {
  return {{"waitMs", latency.waitMs},       {"wireMs", latency.wireMs},     {"queueMs", latency.queueMs},
          {"marchMs", latency.marchMs},     {"compactMs", latency.compactMs}, {"copyMs", latency.copyMs},
          {"encodeMs", latency.encodeMs},   {"decodeMs", latency.decodeMs}, {"totalMs", latency.totalMs()}};
}

void requireServerFor(const TransportOptions& options) {
  if (!options.given.empty() && options.connect.empty())
    throw UsageError(options.given + " is about the way from a server, and frames are made here: add --connect URL, or leave it out");
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
