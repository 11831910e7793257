// Linked into test programs of the preset `traps`: an operation on floating-point numbers that is invalid, overflows or divides by zero ends them,
// and says where. glibc's feenableexcept and backtrace; threads begin with what the thread has that starts them, oneTBB's with what the first
// loop's has.
#include <execinfo.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cfenv>
#include <csignal>
#include <string>
#include <string_view>

namespace {

/// Tests that hand numbers to the program which make such operations what is meant, and see what becomes of them.
struct Expected {
  std::string_view test;  ///< what its full name begins with
  std::string_view why;
};
constexpr std::string_view kNan = "comparisons with NaN say what is to be refused or left out";
constexpr std::string_view kInfinite = "infinite voxels are blended with the others before the whole is left out";
constexpr std::string_view kFar = "numbers at the ends of float or double overflow into the last bin, pixel or code";
constexpr std::string_view kParallel = "rays parallel to slabs divide by zero: box.h";
constexpr Expected kExpected[] = {
    {"Case42.DoublesFromTheLeastToTheGreatest", kFar},
    {"Case42.NumbersThatAreNoneAreTheFirstBins", kNan},
    {"Case59.OutliersInDataOfZeroToOne", kFar},
    {"Case07.RefusesWhatCannotBeTraced", kNan},
    {"Case49.", kNan},
    {"Case47.PropertyNoVisibleSampleIsLeaptOver", kParallel},
    {"On/Case01.PropertyNeverNotANumber", kFar},
    {"On/Case06.NoRadiusNoHit", kNan},
    {"On/Case10.NoDirectionNoHit", kNan},
    {"On/Case13.", kParallel},
    {"On/Case14.", kParallel},
    {"On/Case15.", kParallel},
    {"On/Case17.", kParallel},
    {"On/Case26.EndsAreExactWhatIsOutsideIsClampedAndNanIsNothing", kNan},
    {"On/Case27.NeverZeroForASampleWhateverItsRadius", kNan},
    {"On/Case28.NeverOutsideTheBoundsWhateverTheBits", kNan},
    {"On/Case32.NoLengthNoOpacity", kParallel},
    {"On/Case40.NonFiniteVoxels", kInfinite},
    {"On/Case47.VolumesWithHoles", kInfinite},
    {"On/Case49.MarchersRefuseUnusableCamerasAndGoOn", kNan},
    {"On/Case58.PixelsThatAreNoNumbers", kNan},
    {"On/Case50.PointsAtOrBehindTheEyeAreNotInFront", "what is projected in the eye's plane is not looked at"},
    {"Case52.PointsShowEveryPixelItsOwnSample", "Mesa's rasteriser, which is not ours"},
    {"Codec.UnusableCamerasDoNotMatter", kNan},
    {"CpuMarcher.RefusesUnusableCamerasAndSettings", kNan},
    {"Flicker.WhatCannotBeComparedIsRefusedAndDoesNotCount", kNan},
    {"Macrocells.NonFiniteVoxelsAreLeftOut", kInfinite},
    {"MulAdd.", kFar},
    {"PictureErrors.WhatCannotBeComparedIsRefused", kNan},
    {"PictureMetrics.WhatCannotBeComparedIsRefused", kNan},
    {"Psnr.RefusesWhatHasNoAnswer", kNan},
    {"RangeTest", kNan},
    {"SampleQuantization.WhatIsNoneIsNotUsable", kNan},
    {"SampleRadius.UnitLeavesRoomForTheLargest", kNan},
    {"SphereFootprint.AtTheEdgesOfFloat", kFar},
    {"SphereFootprint.WhatNothingHitsIsEmpty", kNan},
    {"SplatTracer.RefusesWhatCannotBeTraced", kNan},
    {"TransferFunction.InterpolatesBetweenTheWidestDoubles", kFar},
    {"Validate.RefusesWhatMakesNoSense", kNan},
    {"Volume.CountsNonFiniteVoxelsAndLeavesThemOut", kInfinite},
    {"VolumeSource.BatchesWithHoles", kInfinite},
    {"All/VolumeSourceOf.BatchesAreTheScalarFormulaBitForBit", kParallel},
};

constexpr int kTrapped = FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW;

void report(int, siginfo_t* info, void*) {
  const std::string_view what = info->si_code == FPE_FLTDIV   ? "division by zero"
                                : info->si_code == FPE_FLTOVF ? "overflow"
                                : info->si_code == FPE_FLTINV ? "invalid operation"
                                                              : "floating-point exception";
  const auto say = [](std::string_view text) { [[maybe_unused]] const auto written = write(STDERR_FILENO, text.data(), text.size()); };
  say("trapped: ");
  say(what);
  say("; addresses for addr2line:\n");
  void* frames[24];
  backtrace_symbols_fd(frames, backtrace(frames, 24), STDERR_FILENO);
  _exit(EXIT_FAILURE);
}

/// Traps from before main on, and thus in all threads; not in the tests above.
class Traps : public testing::EmptyTestEventListener {
 public:
  Traps() {
    struct sigaction action {};
    action.sa_sigaction = report;
    action.sa_flags = SA_SIGINFO;
    sigaction(SIGFPE, &action, nullptr);
    feenableexcept(kTrapped);
  }
  void OnTestStart(const testing::TestInfo& test) override {
    const std::string name = std::string(test.test_suite_name()) + "." + test.name();
    const bool isExpected =
        std::any_of(std::begin(kExpected), std::end(kExpected), [&](const Expected& one) { return name.starts_with(one.test); });
    std::feclearexcept(FE_ALL_EXCEPT);
    isExpected ? fedisableexcept(kTrapped) : feenableexcept(kTrapped);
  }
};

[[maybe_unused]] const bool kIsListening = [] {
  testing::UnitTest::GetInstance()->listeners().Append(new Traps);  // which it then owns
  return true;
}();

}  // namespace
