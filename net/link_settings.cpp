// The table of presets, the ranges, reading and writing.
// See link_settings.h.
#include "net/link_settings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <optional>

#include "render/base/error.h"
#include "render/base/input_file.h"
#include "render/base/nearest_name.h"
#include "render/base/range.h"

namespace warpscope::net {
namespace {

struct Bounds {
  double lowest, highest;
};

constexpr Bounds kDelayMs{0, 10'000}, kJitterMs{0, 10'000}, kTraceMs{0, 60'000}, kLoss{0, 0.5};
constexpr Bounds kRateBitPerS{1e3, 10e9}, kBurstBytes{0, 64e6}, kBufferBytes{1500, 64e6};
constexpr Bounds kOutageMs{1, 60'000}, kOutageIntervalMs{1, 3'600'000};
constexpr double kLongestOutages = 100.0;  // in mean times between them: a link that is down for more than that is none
constexpr size_t kMostDelays = 10'000'000;

[[noreturn]] void refuse(const std::string& sentence) { throw LinkSettingsError(sentence); }

/// The shortest text that reads back as the same number, without an exponent if people would write it without.
std::string numberText(double value) {
  std::array<char, 32> text;
  const double size = std::abs(value);
  const auto format = size == 0 || (size >= 1e-6 && size < 1e15) ? std::chars_format::fixed : std::chars_format::general;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value, format).ptr};
}

std::string inQuotes(std::string_view text) { return "'" + std::string(text.substr(0, 80)) + "'"; }

void requireWithin(double value, const Bounds& bounds, const std::string& name, const std::string& unit) {
  if (value >= bounds.lowest && value <= bounds.highest) return;
  refuse("a link's " + name + " must be between " + numberText(bounds.lowest) + " and " + numberText(bounds.highest) + unit + ", not " +
         numberText(value));
}

std::optional<double> finiteNumber(std::string_view text) {
  const std::optional<double> value = parseNumber(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

double parseMs(std::string_view text, std::string_view key) {
  if (text.ends_with("ms")) text.remove_suffix(2);
  if (const std::optional<double> value = finiteNumber(text)) return *value;
  refuse(std::string(key) + " must be a number of milliseconds, not " + inQuotes(text));
}

/// A number with k, M or G.
double parseAmount(std::string_view text, std::string_view key, std::string_view unit) {
  constexpr std::string_view kPrefixes = "kMG";
  std::string_view digits = text;
  double factor = 1;
  if (!digits.empty()) {
    const size_t prefix = kPrefixes.find(digits.back() == 'K' ? 'k' : digits.back());
    if (prefix != std::string_view::npos) {
      factor = std::pow(1000.0, static_cast<double>(prefix + 1));
      digits.remove_suffix(1);
    }
  }
  if (const std::optional<double> value = finiteNumber(digits)) return *value * factor;
  refuse(std::string(key) + " must be a number of " + std::string(unit) + ", as 20M, not " + inQuotes(text));
}

std::string amountText(double value) {
  const std::string plain = numberText(value);
  for (const auto& [factor, prefix] : {std::pair(1e9, "G"), std::pair(1e6, "M"), std::pair(1e3, "k")}) {
    const std::string text = numberText(value / factor);
    if (value >= factor && finiteNumber(text).value_or(0) * factor == value && text.size() + 1 < plain.size()) return text + prefix;
  }
  return plain;
}

// --- Keys. Each is read by one function and written by another, empty where it says nothing.

void readDelay(LinkSettings& settings, std::string_view value) { settings.delayMs = parseMs(value, "delay"); }
std::string writeDelay(const LinkSettings& settings) { return settings.delayMs == 0 ? "" : numberText(settings.delayMs); }

void readJitter(LinkSettings& settings, std::string_view value) {
  constexpr std::string_view kNormal = "normal:", kUniform = "uniform:";
  settings.jitter = value.starts_with(kNormal) ? Jitter::normal : Jitter::uniform;
  if (value.starts_with(kNormal)) value.remove_prefix(kNormal.size());
  if (value.starts_with(kUniform)) value.remove_prefix(kUniform.size());
  settings.jitterMs = parseMs(value, "jitter");
  if (settings.jitterMs == 0) settings.jitter = Jitter::none;
}
std::string writeJitter(const LinkSettings& settings) {
  if (settings.jitter == Jitter::none) return "";
  return (settings.jitter == Jitter::normal ? "normal:" : "") + numberText(settings.jitterMs);
}

void readTraceKey(LinkSettings& settings, std::string_view value) { settings.trace = readTrace(std::string(value)); }
std::string writeTrace(const LinkSettings& settings) { return settings.trace ? settings.trace->file : ""; }

void readRate(LinkSettings& settings, std::string_view value) { settings.rateBitPerS = parseAmount(value, "rate", "bits per second"); }
std::string writeRate(const LinkSettings& settings) { return settings.rateBitPerS == 0 ? "" : amountText(settings.rateBitPerS); }

void readBurst(LinkSettings& settings, std::string_view value) { settings.burstBytes = parseAmount(value, "burst", "bytes"); }
std::string writeBurst(const LinkSettings& settings) { return settings.burstBytes == 0 ? "" : amountText(settings.burstBytes); }

void readBuffer(LinkSettings& settings, std::string_view value) { settings.bufferBytes = parseAmount(value, "buffer", "bytes"); }
std::string writeBuffer(const LinkSettings& settings) { return settings.bufferBytes == 0 ? "" : amountText(settings.bufferBytes); }

void readLoss(LinkSettings& settings, std::string_view value) {
  const bool isPercent = value.ends_with('%');
  const std::optional<double> number = finiteNumber(isPercent ? value.substr(0, value.size() - 1) : value);
  if (!number) refuse("loss must be a percentage, as 1%, or a fraction, as 0.01, not " + inQuotes(value));
  settings.loss = isPercent ? *number / 100 : *number;
}
std::string writeLoss(const LinkSettings& settings) {
  if (settings.loss == 0) return "";
  const std::string percent = numberText(settings.loss * 100);
  return finiteNumber(percent).value_or(0) / 100 == settings.loss ? percent + "%" : numberText(settings.loss);
}

void readOutage(LinkSettings& settings, std::string_view value) {
  const size_t slash = value.find('/');
  if (value == "none" || value == "0") {
    settings.outageMs = settings.outageIntervalMs = 0;
    settings.outagesAreRandom = false;
    return;
  }
  if (slash == std::string_view::npos)
    refuse("outage must be LENGTH/INTERVAL in milliseconds, as 500/10000, or 500/~10000 for a mean interval, not " + inQuotes(value));
  std::string_view interval = value.substr(slash + 1);
  settings.outagesAreRandom = interval.starts_with('~');
  if (settings.outagesAreRandom) interval.remove_prefix(1);
  settings.outageMs = parseMs(value.substr(0, slash), "outage's length");
  settings.outageIntervalMs = parseMs(interval, "outage's interval");
}
std::string writeOutage(const LinkSettings& settings) {
  if (settings.outageIntervalMs == 0) return "";
  return numberText(settings.outageMs) + "/" + (settings.outagesAreRandom ? "~" : "") + numberText(settings.outageIntervalMs);
}

void readSeed(LinkSettings& settings, std::string_view value) {
  const char* const end = value.data() + value.size();
  const auto [stop, error] = std::from_chars(value.data(), end, settings.seed);
  if (error != std::errc{} || stop != end) refuse("seed must be a whole number from 0 to 18446744073709551615, not " + inQuotes(value));
}
std::string writeSeed(const LinkSettings& settings) { return settings.seed == LinkSettings().seed ? "" : std::to_string(settings.seed); }

struct Key {
  LinkKey text;
  void (*read)(LinkSettings&, std::string_view);
  std::string (*write)(const LinkSettings&);
  std::string_view nothing;  ///< the value that stands for `write` being empty
};

constexpr std::array<Key, 9> kKeys{{
    {{"delay", "MS", "milliseconds that every byte takes one way"}, readDelay, writeDelay, "0"},
    {{"jitter", "MS or normal:MS", "milliseconds by which the delay varies, evenly or with that standard deviation; at most the delay"},
     readJitter, writeJitter, "0"},
    {{"trace", "FILE", "recorded delays in milliseconds, one a line, played again and again on top of the delay"}, readTraceKey, writeTrace, ""},
    {{"rate", "BIT/S", "bits a second that pass, with k, M or G for thousands, as 20M; 0 is unlimited"}, readRate, writeRate, "0"},
    {{"burst", "BYTES", "bytes that may pass at once after a pause, as in a token bucket"}, readBurst, writeBurst, "0"},
    {{"buffer", "BYTES", "bytes that wait before the rate's bottleneck; 0 is 100 ms at the rate, at least 64 KiB"}, readBuffer, writeBuffer, "0"},
    {{"loss", "P%", "share of the segments that is lost, to 50 %; they come later, as TCP sends them again"}, readLoss, writeLoss, "0"},
    {{"outage", "MS/MS or MS/~MS", "length of times without anything / from one's begin to the next one's, or the mean time between them"},
     readOutage, writeOutage, "none"},
    {{"seed", "N", "number that the dice of jitter, loss and outages begin with"}, readSeed, writeSeed, "1"},
}};

void readItem(DuplexLinkSettings& settings, std::string_view item) {
  constexpr std::string_view kUp = "up.", kDown = "down.";
  const size_t equals = item.find('=');
  if (equals == std::string_view::npos) {
    std::vector<std::string_view> names;
    for (const LinkPreset& preset : linkPresets()) names.push_back(preset.name);
    if (std::find(names.begin(), names.end(), item) != names.end()) refuse("the link " + inQuotes(item) + " stands behind something else; a link's name comes first, and there is one");
    const std::optional<std::string_view> nearest = nearestName(item, names);
    refuse(inQuotes(item) + " is no KEY=VALUE, nor a link's name at the beginning" +
           (nearest ? "; did you mean '" + std::string(*nearest) + "'? Names: " : "; names: ") + listOf(linkPresets()) + "; keys: " + listOf(linkKeys()));
  }
  std::string_view name = item.substr(0, equals);
  const std::string_view value = item.substr(equals + 1);
  const bool isUp = name.starts_with(kUp), isDown = name.starts_with(kDown);
  if (isUp) name.remove_prefix(kUp.size());
  if (isDown) name.remove_prefix(kDown.size());
  const auto key = std::find_if(kKeys.begin(), kKeys.end(), [&](const Key& entry) { return entry.text.name == name; });
  if (key == kKeys.end()) refuse("a link has no " + inQuotes(name) + "; known: " + listOf(linkKeys()));
  if (!isDown) key->read(settings.up, value);
  if (isUp) return;
  if (!isDown && name == "trace")
    settings.down.trace = settings.up.trace;  // read once
  else
    key->read(settings.down, value);
}

constexpr double kMbit = 1e6;

LinkSettings direction(double delayMs, double normalJitterMs, double rateMbit, double loss) {
  LinkSettings settings;
  settings.delayMs = delayMs;
  settings.jitter = normalJitterMs > 0 ? Jitter::normal : Jitter::none;
  settings.jitterMs = normalJitterMs;
  settings.rateBitPerS = rateMbit * kMbit;
  settings.loss = loss;
  return settings;
}

DuplexLinkSettings conferenceWifi() {
  DuplexLinkSettings settings{direction(12, 4, 5, 0.02), direction(12, 4, 8, 0.02)};
  for (LinkSettings* const one : {&settings.up, &settings.down}) {
    one->outageMs = 300;
    one->outageIntervalMs = 8000;
    one->outagesAreRandom = true;
  }
  return settings;
}

}  // namespace

double DelayTrace::meanMs() const {
  return delaysMs.empty() ? 0 : std::accumulate(delaysMs.begin(), delaysMs.end(), 0.0) / static_cast<double>(delaysMs.size());
}

bool LinkSettings::isTransparent() const {
  return delayMs == 0 && jitter == Jitter::none && !trace && rateBitPerS == 0 && loss == 0 && outageIntervalMs == 0;
}

bool LinkSettings::operator==(const LinkSettings& other) const {
  const auto sameTrace = [&] {
    if (!trace || !other.trace) return !trace && !other.trace;
    return trace->file == other.trace->file && trace->delaysMs == other.trace->delaysMs;
  };
  return delayMs == other.delayMs && jitter == other.jitter && jitterMs == other.jitterMs && sameTrace() &&
         rateBitPerS == other.rateBitPerS && burstBytes == other.burstBytes && bufferBytes == other.bufferBytes && loss == other.loss &&
         outageMs == other.outageMs && outageIntervalMs == other.outageIntervalMs && outagesAreRandom == other.outagesAreRandom &&
         seed == other.seed;
}

std::span<const LinkPreset> linkPresets() {
  static const std::array<LinkPreset, 7> kPresets{{
      {"none", "no simulated link", {}},
      {"lan", "the same building by cable: 0.4 ms round trip, 1 Gbit/s", {direction(0.2, 0, 1000, 0), direction(0.2, 0, 1000, 0)}},
      {"home-fibre",
       "the same country from home: 12 ms round trip, 250 Mbit/s down, 50 up",
       {direction(6, 0.5, 50, 0), direction(6, 0.5, 250, 0)}},
      {"4g",
       "a telephone's network: 50 ms round trip with jitter, 30 Mbit/s down, 10 up, 0.1 % loss",
       {direction(25, 5, 10, 0.001), direction(25, 5, 30, 0.001)}},
      {"transatlantic",
       "Europe to North America between universities: 90 ms round trip, 200 Mbit/s, 0.01 % loss",
       {direction(45, 0.5, 200, 0.0001), direction(45, 0.5, 200, 0.0001)}},
      {"satellite",
       "a geostationary satellite: 600 ms round trip, 40 Mbit/s down, 5 up, 0.5 % loss",
       {direction(300, 5, 5, 0.005), direction(300, 5, 40, 0.005)}},
      {"conference-wifi",
       "a hall full of people: 24 ms round trip with jitter, 8 Mbit/s down, 5 up, 2 % loss, 0.3 s without anything now and then",
       conferenceWifi()},
  }};
  return kPresets;
}

std::span<const LinkKey> linkKeys() {
  static const auto kTexts = [] {
    std::array<LinkKey, kKeys.size()> texts;
    std::ranges::transform(kKeys, texts.begin(), &Key::text);
    return texts;
  }();
  return kTexts;
}

std::string lossText(double loss) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.4g %%", loss * 100);
  return text.data();
}

void requireValid(const LinkSettings& settings) {
  requireWithin(settings.delayMs, kDelayMs, "delay", " ms");
  requireWithin(settings.jitterMs, kJitterMs, "jitter", " ms");
  const double typicalMs = settings.delayMs + (settings.trace ? settings.trace->meanMs() : 0);
  if (settings.jitter != Jitter::none && settings.jitterMs > typicalMs)
    refuse("a link's jitter must not exceed its delay (" + numberText(typicalMs) + " ms), but is " + numberText(settings.jitterMs) + " ms");
  if (settings.trace && settings.trace->delaysMs.empty()) refuse("a link's trace has no delays");
  if (settings.rateBitPerS != 0) requireWithin(settings.rateBitPerS, kRateBitPerS, "rate", " bit/s");
  requireWithin(settings.burstBytes, kBurstBytes, "burst", " bytes");
  if (settings.bufferBytes != 0) requireWithin(settings.bufferBytes, kBufferBytes, "buffer", " bytes");
  requireWithin(settings.loss, kLoss, "loss", "");
  if (settings.outageIntervalMs == 0) return;
  requireWithin(settings.outageMs, kOutageMs, "outage", " ms");
  requireWithin(settings.outageIntervalMs, kOutageIntervalMs, "outage's interval", " ms");
  if (settings.outagesAreRandom && settings.outageMs > kLongestOutages * settings.outageIntervalMs)
    refuse("a link's outages must not be longer than " + numberText(kLongestOutages) + " times the mean time between them (" +
           numberText(settings.outageIntervalMs) + " ms), but are " + numberText(settings.outageMs) + " ms");
  if (!settings.outagesAreRandom && settings.outageMs >= settings.outageIntervalMs)
    refuse("a link's outage must be shorter than its interval (" + numberText(settings.outageIntervalMs) + " ms), but is " +
           numberText(settings.outageMs) + " ms");
}

void requireValid(const DuplexLinkSettings& settings) {
  requireValid(settings.up);
  requireValid(settings.down);
}

DuplexLinkSettings parseLinkSettings(std::string_view text) {
  DuplexLinkSettings settings;
  if (text.empty()) refuse("a link must have a name or KEY=VALUE; names: " + listOf(linkPresets()) + "; keys: " + listOf(linkKeys()));
  for (bool isFirst = true; !text.empty(); isFirst = false) {
    const size_t comma = std::min(text.find(','), text.size());
    const std::string_view item = text.substr(0, comma);
    text.remove_prefix(std::min(comma + 1, text.size()));
    const auto presets = linkPresets();
    const auto preset = std::find_if(presets.begin(), presets.end(), [&](const LinkPreset& entry) { return entry.name == item; });
    if (isFirst && preset != presets.end())
      settings = preset->settings;
    else
      readItem(settings, item);
  }
  requireValid(settings);
  return settings;
}

std::string toString(const DuplexLinkSettings& settings) {
  for (const LinkPreset& preset : linkPresets())
    if (preset.settings == settings) return std::string(preset.name);
  std::string text;
  const auto add = [&](std::string_view direction, const Key& key, const std::string& value) {
    if (!text.empty()) text += ',';
    text += std::string(direction) + std::string(key.text.name) + "=" + value;
  };
  for (const Key& key : kKeys) {
    const std::string up = key.write(settings.up), down = key.write(settings.down);
    if (up == down && !up.empty()) add("", key, up);
    if (up != down && !up.empty()) add("up.", key, up);
    if (up != down && !down.empty()) add("down.", key, down);
  }
  return text.empty() ? "none" : text;
}

std::string inWords(const DuplexLinkSettings& settings) {
  const LinkSettings &up = settings.up, &down = settings.down;  // no structured binding: Clang 14 captures none
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() || part.empty() ? "" : ", ") + part; };
  const auto addEach = [&](const auto& wordsOf) {
    const std::string ofDown = wordsOf(down), ofUp = wordsOf(up);
    if (ofUp == ofDown) return add(ofDown);
    if (!ofDown.empty()) add(ofDown + " down");
    if (!ofUp.empty()) add(ofUp + " up");
  };
  const double roundTripMs = up.delayMs + down.delayMs;
  if (roundTripMs > 0) add(numberText(roundTripMs) + " ms round trip");
  addEach([](const LinkSettings& way) { return way.trace ? "delays of " + way.trace->file : ""; });
  addEach([](const LinkSettings& way) { return way.jitter != Jitter::none ? "± " + numberText(way.jitterMs) + " ms" : ""; });
  addEach([](const LinkSettings& way) { return way.rateBitPerS > 0 ? numberText(way.rateBitPerS / 1e6) + " Mbit/s" : ""; });
  addEach([](const LinkSettings& way) { return way.loss > 0 ? lossText(way.loss) + " lost" : ""; });
  addEach([](const LinkSettings& way) {
    return way.outageIntervalMs > 0 ? "outages of " + numberText(way.outageMs) + " ms every " + numberText(way.outageIntervalMs) + " ms" : "";
  });
  return text.empty() ? "nothing" : text;
}

LinkWords wordsOf(const DuplexLinkSettings& settings) {
  const double roundTripMs = settings.up.delayMs + settings.down.delayMs;
  const std::string brief = roundTripMs > 0 ? numberText(roundTripMs) + " ms round trip" : inWords(settings);
  for (const LinkPreset& preset : linkPresets())
    if (preset.settings == settings) return {std::string(preset.summary), std::string(preset.name) + ", " + brief};
  return {inWords(settings), brief};
}

std::shared_ptr<const DelayTrace> parseTrace(std::string_view text, const std::string& file) {
  auto trace = std::make_shared<DelayTrace>();
  trace->file = file;
  for (size_t number = 1; !text.empty(); ++number) {
    const size_t length = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, length);
    text.remove_prefix(std::min(length + 1, text.size()));
    line = line.substr(0, line.find('#'));
    constexpr std::string_view kBlank = " \t\r";
    line.remove_prefix(std::min(line.find_first_not_of(kBlank), line.size()));
    line = line.substr(0, line.find_last_not_of(kBlank) + 1);
    if (line.empty()) continue;
    const std::optional<double> delayMs = finiteNumber(line);
    if (!delayMs || *delayMs < kTraceMs.lowest || *delayMs > kTraceMs.highest) {
      refuse(file + ":" + std::to_string(number) + ": a line must be one delay from " + numberText(kTraceMs.lowest) + " to " +
             numberText(kTraceMs.highest) + " ms, not " + inQuotes(line));
    }
    if (trace->delaysMs.size() == kMostDelays) refuse(file + ": has more than " + std::to_string(kMostDelays) + " delays");
    trace->delaysMs.push_back(*delayMs);
  }
  if (trace->delaysMs.empty()) refuse(file + ": has no delays; it must have one, in milliseconds, a line");
  return trace;
}

std::shared_ptr<const DelayTrace> readTrace(const std::string& file) {
  constexpr uint64_t kLargest = 256 << 20;
  try {
    return parseTrace(readInputFile(file, kLargest, "a trace of delays"), file);
  } catch (const InputError& error) {
    refuse(error.what());
  }
}

}  // namespace warpscope::net
