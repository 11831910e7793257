// Settings of links: presets, what is read and printed, ranges, and the sentences about what is wrong.
// Mirrors net/link_settings.h.
#include "net/link_settings.h"

#include <gmock/gmock.h>

#include <set>

#include "tests/complaint.h"
#include "tests/test_folder.h"

namespace warpscope::net {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

template <class Action>
std::string complaintOf(const Action& action) {
  return warpscope::complaintOf<LinkSettingsError>(action);
}

TEST(LinkSettings, EveryKeyIsExplained) {
  ASSERT_FALSE(linkKeys().empty());
  for (const LinkKey& key : linkKeys()) EXPECT_FALSE(key.form.empty() || key.help.empty()) << key.name;
  // And those that are read are those that are explained.
  const std::string known = complaintOf([] { parseLinkSettings("nonsense=1"); });
  std::string names;
  for (const LinkKey& key : linkKeys()) names += " " + std::string(key.name);
  EXPECT_THAT(known, testing::EndsWith("; known:" + names));
}

TEST(LinkSettings, WhatALinkDoesIsSaidWithUnits) {
  EXPECT_EQ(inWords({}), "nothing");
  EXPECT_EQ(inWords(parseLinkSettings("delay=300")), "600 ms round trip");
  EXPECT_EQ(inWords(parseLinkSettings("delay=20,jitter=5,down.rate=20M,up.rate=5M,loss=1%")), "40 ms round trip, ± 5 ms, 20 Mbit/s down, 5 Mbit/s up, 1 % lost");
  EXPECT_EQ(inWords(parseLinkSettings("down.rate=2500k")), "2.5 Mbit/s down");
  for (const LinkPreset& preset : linkPresets())
    if (preset.name != "none") EXPECT_NE(inWords(preset.settings), "nothing") << preset.name;
}

TEST(LinkSettings, ACommaAtTheEndIsBorne) { EXPECT_EQ(parseLinkSettings("4g,"), parseLinkSettings("4g")); }

TEST(LinkSettings, LossIsWrittenAsItIs) {
  EXPECT_EQ(lossText(0.0), "0 %");
  EXPECT_EQ(lossText(0.0001), "0.01 %");
  EXPECT_EQ(lossText(0.00002), "0.002 %");
  EXPECT_EQ(lossText(0.01234), "1.234 %");
  EXPECT_EQ(lossText(0.5), "50 %");
}

TEST(LinkSettings, PresetsAreValidAndReadByName) {
  std::set<std::string_view> names;
  for (const LinkPreset& preset : linkPresets()) {
    SCOPED_TRACE(preset.name);
    EXPECT_NO_THROW(requireValid(preset.settings));
    EXPECT_EQ(parseLinkSettings(preset.name), preset.settings);
    EXPECT_EQ(toString(preset.settings), preset.name);
    EXPECT_FALSE(preset.summary.empty());
    EXPECT_EQ(preset.settings.up.isTransparent(), preset.name == "none");
    names.insert(preset.name);
  }
  EXPECT_EQ(names.size(), linkPresets().size());
  EXPECT_EQ(linkPresets()[0].name, "none");
}

TEST(LinkSettings, ReadsEveryKey) {
  const DuplexLinkSettings settings =
      parseLinkSettings("delay=100,jitter=10,rate=20M,burst=32k,buffer=1M,loss=1%,outage=500/~10000,seed=7");
  const LinkSettings& up = settings.up;
  EXPECT_EQ(settings.up, settings.down);
  EXPECT_EQ(up.delayMs, 100);
  EXPECT_EQ(up.jitter, Jitter::uniform);
  EXPECT_EQ(up.jitterMs, 10);
  EXPECT_EQ(up.rateBitPerS, 20e6);
  EXPECT_EQ(up.burstBytes, 32e3);
  EXPECT_EQ(up.bufferBytes, 1e6);
  EXPECT_EQ(up.loss, 0.01);
  EXPECT_EQ(up.outageMs, 500);
  EXPECT_EQ(up.outageIntervalMs, 10000);
  EXPECT_TRUE(up.outagesAreRandom);
  EXPECT_EQ(up.seed, 7u);
}

TEST(LinkSettings, DirectionsAndPresetsWithChanges) {
  const DuplexLinkSettings settings = parseLinkSettings("satellite,up.rate=2M,down.jitter=normal:4,loss=0");
  DuplexLinkSettings expected = parseLinkSettings("satellite");
  expected.up.rateBitPerS = 2e6;
  expected.down.jitterMs = 4;
  expected.up.loss = expected.down.loss = 0;
  EXPECT_EQ(settings, expected);
}

TEST(LinkSettings, PrintsWhatItReads) {
  for (const char* const text : {"delay=100,jitter=10,rate=20M,loss=1%", "delay=0.25", "rate=1500", "up.delay=3,down.delay=4,jitter=normal:2",
                                 "rate=2.5G,burst=1500,seed=18446744073709551615", "outage=250/1000", "down.loss=0.123456789%",
                                 "delay=20,outage=500/~10000"}) {
    const DuplexLinkSettings settings = parseLinkSettings(text);
    EXPECT_EQ(toString(settings), text);
    EXPECT_EQ(parseLinkSettings(toString(settings)), settings);
  }
  EXPECT_EQ(toString(parseLinkSettings("delay=0")), "none");
  EXPECT_EQ(toString(parseLinkSettings("delay=5ms,jitter=uniform:1ms,rate=1000k")), "delay=5,jitter=1,rate=1M");
}

TEST(LinkSettings, SaysWhatIsWrong) {
  struct Case {
    const char* text;
    const char* complaint;
  };
  for (const auto& [text, complaint] : {
           Case{"", "a link must have a name or KEY=VALUE; names: none lan home-fibre"},
           Case{"5g", "'5g' is no KEY=VALUE, nor a link's name at the beginning; did you mean '4g'? Names: none lan"},
           Case{"carrier-pigeon", "nor a link's name at the beginning; names: none lan"},
           Case{"delay=1,lan", "the link 'lan' stands behind something else; a link's name comes first"},
           Case{"lan,4g", "the link '4g' stands behind something else"},
           Case{"delya=1", "a link has no 'delya'; known: delay jitter trace"},
           Case{"up.=1", "a link has no ''"},
           Case{"delay=x", "delay must be a number of milliseconds, not 'x'"},
           Case{"delay=-1", "a link's delay must be between 0 and 10000 ms, not -1"},
           Case{"delay=10001", "not 10001"},
           Case{"delay=nan", "delay must be a number of milliseconds, not 'nan'"},
           Case{"delay=1e999", "delay must be a number"},
           Case{"jitter=5", "a link's jitter must not exceed its delay (0 ms), but is 5 ms"},
           Case{"delay=9,jitter=-5", "a link's jitter must be between 0 and 10000 ms, not -5"},
           Case{"rate=20X", "rate must be a number of bits per second, as 20M, not '20X'"},
           Case{"rate=M", "not 'M'"},
           Case{"rate=1", "a link's rate must be between 1000 and 10000000000 bit/s, not 1"},
           Case{"burst=1G", "a link's burst must be between 0 and 64000000 bytes"},
           Case{"buffer=10", "a link's buffer must be between 1500"},
           Case{"loss=60%", "a link's loss must be between 0 and 0.5, not 0.6"},
           Case{"loss=much", "loss must be a percentage, as 1%, or a fraction, as 0.01, not 'much'"},
           Case{"outage=5", "outage must be LENGTH/INTERVAL"},
           Case{"outage=5/x", "outage's interval must be a number of milliseconds, not 'x'"},
           Case{"outage=50/50", "a link's outage must be shorter than its interval (50 ms)"},
           Case{"outage=0/50", "a link's outage must be between 1"},
           Case{"seed=-1", "seed must be a whole number"},
           Case{"trace=/no/such/file", "/no/such/file: there is no such file"},
       })
    EXPECT_THAT(complaintOf([&] { parseLinkSettings(text); }), HasSubstr(complaint)) << text;
}

TEST(LinkSettings, Traces) {
  const auto trace = parseTrace("# recorded at night\n12.5\n\n  7\t\r\n0 # nothing\n1e2", "t");
  EXPECT_THAT(trace->delaysMs, ElementsAre(12.5, 7, 0, 100));
  EXPECT_DOUBLE_EQ(trace->meanMs(), 119.5 / 4);
  EXPECT_EQ(complaintOf([] { parseTrace("1\n2\nthree\n", "night.txt"); }),
            "night.txt:3: a line must be one delay from 0 to 60000 ms, not 'three'");
  EXPECT_THAT(complaintOf([] { parseTrace("1\n-2\n", "t"); }), HasSubstr("t:2: "));
  EXPECT_THAT(complaintOf([] { parseTrace("1 2\n", "t"); }), HasSubstr("t:1: "));
  EXPECT_THAT(complaintOf([] { parseTrace("60001", "t"); }), HasSubstr("t:1: "));
  EXPECT_THAT(complaintOf([] { parseTrace("# nothing\n\n", "t"); }), HasSubstr("t: has no delays"));
}

TEST(LinkSettings, TracesFromFiles) {
  const TestFolder folder;
  const DuplexLinkSettings settings = parseLinkSettings("trace=" + folder.write("trace", "10\n30\n") + ",delay=5");
  EXPECT_THAT(settings.down.trace->delaysMs, ElementsAre(10, 30));
  EXPECT_EQ(parseLinkSettings(toString(settings)), settings);
}

/// A model of such a link would go through outages without end.
TEST(LinkSettings, ALinkThatIsHardlyEverUpIsRefused) {
  EXPECT_THROW(parseLinkSettings("outage=60000/~1"), LinkSettingsError);
  EXPECT_THROW(parseLinkSettings("outage=60000/~599"), LinkSettingsError);
  EXPECT_NO_THROW(parseLinkSettings("outage=60000/~600"));
}

}  // namespace
}  // namespace warpscope::net
