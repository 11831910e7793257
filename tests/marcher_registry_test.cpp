// Which marcher is made: the named one, the fastest that can be used, and what comes after one that fails; what each
// can do. Mirrors render/march/marcher_registry.h and the capabilities of marcher.h.
#include "render/march/marcher_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

using ::testing::HasSubstr;

VolumePtr smallVolume() {
  return makeTestVolume(VoxelType::uint8, glm::uvec3(6), [](const glm::ivec3&) { return 50.0; });
}

std::string usable() { return {}; }
std::string notHere() { return "it is not plugged in"; }

// Under any name.
MarcherPtr sound(VolumePtr volume, TransferFunction function) {
  return makeCpuMarcher(std::move(volume), std::move(function));
}
MarcherPtr cannotBeMade(VolumePtr, TransferFunction) { throw DeviceError("out of memory"); }

std::vector<std::string_view> namesFor(Backend backend, MarcherTable table) {
  std::vector<std::string_view> names;
  for (const MarcherDescriptor* marcher : marchersFor(backend, table)) names.push_back(marcher->name);
  return names;
}

TEST(MarcherRegistry, NamesAreTheBackends) {
  ASSERT_GE(marcherRegistry().size(), 2u);
  for (const MarcherDescriptor& marcher : marcherRegistry()) {
    EXPECT_EQ(marcher.name, nameOf(marcher.backend));
    EXPECT_EQ(&findMarcher(marcher.name), &marcher);
    EXPECT_FALSE(marcher.label.empty());
    EXPECT_FALSE(marcher.summary.empty());
  }
  EXPECT_EQ(marcherRegistry().front().backend, Backend::cpu);  // every machine has it
  EXPECT_EQ(marcherRegistry().front().whyUnavailable(), "");
  EXPECT_THROW(
      {
        try {
          findMarcher("cuda1");
        } catch (const UsageError& error) {
          EXPECT_THAT(error.what(), HasSubstr("did you mean 'cuda'"));
          throw;
        }
      },
      UsageError);
}

TEST(MarcherRegistry, AutomaticTakesTheFastestThatCanBeUsed) {
  const MarcherDescriptor table[] = {{"cpu", "CPU", "slow", Backend::cpu, usable, sound},
                                     {"cuda", "CUDA", "fast", Backend::cuda, usable, sound}};
  EXPECT_EQ(namesFor(Backend::automatic, table), (std::vector<std::string_view>{"cuda", "cpu"}));
  EXPECT_EQ(namesFor(Backend::cpu, table), std::vector<std::string_view>{"cpu"});
  EXPECT_EQ(namesFor(Backend::cuda, table), std::vector<std::string_view>{"cuda"});
  const MarcherDescriptor without[] = {{"cpu", "CPU", "slow", Backend::cpu, usable, sound},
                                       {"cuda", "CUDA", "fast", Backend::cuda, notHere, cannotBeMade}};
  EXPECT_EQ(namesFor(Backend::automatic, without), std::vector<std::string_view>{"cpu"});
}

TEST(MarcherRegistry, ANamedOneThatCannotBeUsedIsRefusedWithTheReason) {
  const MarcherDescriptor table[] = {{"cpu", "CPU", "slow", Backend::cpu, usable, sound},
                                     {"cuda", "CUDA", "fast", Backend::cuda, notHere, cannotBeMade}};
  try {
    makeMarcher(Backend::cuda, smallVolume(), everywhere(0.5f), {}, table);
    FAIL() << "it was made";
  } catch (const DeviceError& error) {
    EXPECT_STREQ(error.what(), "the backend cuda cannot be used: it is not plugged in");
  }
}

TEST(MarcherRegistry, OneThatFailsIsLeftForTheNextUnlessItWasNamed) {
  // Three, of which two fail: the way goes on to the last.
  const MarcherDescriptor table[] = {{"cpu", "CPU", "slow", Backend::cpu, usable, sound},
                                     {"cuda", "CUDA", "fast", Backend::cuda, usable, cannotBeMade},
                                     {"cuda", "Newer CUDA", "faster", Backend::cuda, usable, cannotBeMade}};
  std::vector<std::string> reasons;
  const auto note = [&](const std::string& reason) { reasons.push_back(reason); };
  const MarcherPtr marcher = makeMarcher(Backend::automatic, smallVolume(), everywhere(0.5f), note, table);
  EXPECT_EQ(reasons, (std::vector<std::string>{"out of memory", "out of memory"}));
  EXPECT_EQ(marcher->backend(), Backend::cpu);
  EXPECT_GT(marcher->march(lookingFrom({20.0f, 5.0f, 9.0f}, {}, 32, 32), {}).size(), 10u);
  EXPECT_THROW(makeMarcher(Backend::cuda, smallVolume(), everywhere(0.5f), note, MarcherTable(table).first(2)),
               DeviceError);
  EXPECT_EQ(reasons.size(), 2u);
}

TEST(MarcherCapabilities, OfTheCpusMarcher) {
  const MarcherPtr marcher = makeMarcher(Backend::cpu, smallVolume(), everywhere(0.5f), {});
  EXPECT_EQ(marcher->capabilities(),
            (MarcherCapabilities{MarchPace::afterRest, VolumePlace::here, JudgePlace::host, FunctionChange::followed}));
  EXPECT_NE(marcher->volume(), nullptr);
  EXPECT_EQ(marcher->twin()->capabilities(), marcher->capabilities());
}

}  // namespace
}  // namespace warpscope
