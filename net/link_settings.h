// What a simulated link does to bytes: delay, jitter, rate, loss, outages; presets, and a text form for the command line.
// The meaning of each number is in link_model.h. The presets' figures are typical ones, rounded; none is a measurement of one network.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace warpscope::net {

/// Settings that do not exist or make no sense. The sentence says what would be right.
class LinkSettingsError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class Jitter {
  none,
  uniform,  ///< even between -jitterMs and +jitterMs
  normal,   ///< normal with the deviation jitterMs; a delay that would be negative is 0
};

/// Delays that were recorded, in milliseconds, to be played again and again.
struct DelayTrace {
  std::string file;
  std::vector<double> delaysMs;

  double meanMs() const;
};

/// One direction of a link. All zero: bytes pass as if there were none.
struct LinkSettings {
  double delayMs = 0;  ///< one way
  Jitter jitter = Jitter::none;
  double jitterMs = 0;
  std::shared_ptr<const DelayTrace> trace;  ///< added to delayMs
  double rateBitPerS = 0;                   ///< 0: unlimited
  double burstBytes = 0;                    ///< what may pass at once after a pause
  double bufferBytes = 0;                   ///< of the router before the bottleneck; 0: 100 ms at the rate, but at least 64 KiB
  double loss = 0;                          ///< probability that a segment is lost
  double outageMs = 0;                      ///< how long each outage is
  double outageIntervalMs = 0;              ///< from one outage's begin to the next one's; 0: no outages
  bool outagesAreRandom = false;            ///< outageIntervalMs is the mean of exponential times between an end and the next begin
  uint64_t seed = 1;

  /// Nothing is delayed, held or lost.
  bool isTransparent() const;
  bool operator==(const LinkSettings&) const;
};

/// Both directions, as seen from the client: `up` to the server, `down` from it.
struct DuplexLinkSettings {
  LinkSettings up, down;

  /// Bytes pass as if there were no link.
  bool isTransparent() const { return up.isTransparent() && down.isTransparent(); }

  bool operator==(const DuplexLinkSettings&) const = default;
};

struct LinkPreset {
  std::string_view name;
  std::string_view summary;
  DuplexLinkSettings settings;
};

/// In the order in which they are shown; the first is `none`.
std::span<const LinkPreset> linkPresets();

/// Throws LinkSettingsError unless every number lies in its range.
void requireValid(const LinkSettings& settings);
void requireValid(const DuplexLinkSettings& settings);

/// A key of parseLinkSettings(), for help and documents.
struct LinkKey {
  std::string_view name;
  std::string_view form;  ///< of its value: "MS"
  std::string_view help;  ///< one sentence, with its unit
};

/// All of them, in the order in which they are written.
std::span<const LinkKey> linkKeys();

/// Reads PRESET, or KEY=VALUE joined by commas, or both: "4g", "delay=100,jitter=10,rate=20M,loss=1%", "satellite,up.rate=2M".
/// The keys are linkKeys(). Rates and bytes take k, M and G (powers of 1000). A key with `up.` or `down.` before it is for that direction
/// alone. Throws LinkSettingsError.
DuplexLinkSettings parseLinkSettings(std::string_view text);

/// What parseLinkSettings() reads back: a preset's name, or keys and values.
std::string toString(const DuplexLinkSettings& settings);

/// What it does to bytes, as people read it, with units: "600 ms round trip, 20 Mbit/s down, 5 Mbit/s up, 1 % lost"; "nothing" where it does nothing.
std::string inWords(const DuplexLinkSettings& settings);

/// In full, and where room is scarce: a preset's summary or inWords(), and "satellite, 600 ms round trip".
struct LinkWords {
  std::string full, brief;
};
LinkWords wordsOf(const DuplexLinkSettings& settings);

/// As people read it, to four digits: "0.01 %".
std::string lossText(double loss);

/// One delay in milliseconds a line; empty lines and what follows a # are passed over. Throws LinkSettingsError naming file and line.
std::shared_ptr<const DelayTrace> parseTrace(std::string_view text, const std::string& file);
std::shared_ptr<const DelayTrace> readTrace(const std::string& file);

}  // namespace warpscope::net
