// Errors of pictures: cases 56 to 58. Truth: the formulas in long double, by brute force over every pixel and window;
// other implementations' figures. Mirrors render/metrics/{psnr,ssim,flip}.h and picture_judge_cuda.h. Against those
// implementations themselves: metrics_oracles_test.py.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "render/base/error.h"
#include "render/core/color.h"
#include "render/metrics/flip.h"
#include "render/metrics/picture_errors.h"
#include "render/metrics/picture_judge_cuda.h"
#include "render/metrics/psnr.h"
#include "render/metrics/ssim.h"
#include "tests/metric_pictures.h"
#include "tests/ssim_truth.h"
#include "tests/stability/backends.h"
#include "tests/stability/magnitudes.h"
#include "tests/stability/record.h"

namespace warpscope {
namespace {

const glm::vec3 kBlack(0.0f);
constexpr uint32_t kSide = 24;

/// All three errors of a picture against a reference.
struct Errors {
  double psnrDb, ssim, flip;
};

Errors errorsOn(Backend backend, const Image<glm::vec4>& image, const Image<glm::vec4>& reference,
                const glm::vec3& background = kBlack) {
  if (backend == Backend::cuda) {
    const auto judge = makeCudaPictureJudge(background);
    judge->setReference(reference);
    const DeviceErrors errors = judge->errorsOf(image);
    return {errors.psnrDb, errors.ssim, errors.flip};
  }
  const WarpedImage warped{image, Image<uint32_t>(image.width(), image.height(), 0)};
  const PictureErrors errors = PictureJudge(reference, background).errorsOf(warped);
  // In one go or each for itself.
  EXPECT_EQ(errors.psnrDb, psnrSrgb(image, reference, background));
  EXPECT_NEAR(errors.ssim, ssimSrgb(image, reference, background), 1e-9);
  EXPECT_NEAR(errors.flip, flip(image, reference, background).mean, 1e-9);
  return {errors.psnrDb, errors.ssim, errors.flip};
}

/// Grey, opaque; and what it shows, which is not quite what was asked for.
Image<glm::vec4> pictureOf(Levels& levels) {
  Image<glm::vec4> image(kSide, kSide);
  for (size_t i = 0; i < levels.size(); ++i) {
    const float linear = linearFromSrgb(static_cast<float>(levels[i]));
    image[i] = glm::vec4(glm::vec3(linear), 1.0f);
  }
  const ColorPlanes shown = srgbPlanes(image, kBlack, "a test");
  for (size_t i = 0; i < levels.size(); ++i) levels[i] = static_cast<long double>(shown[0][i]);
  return image;
}

TEST(Case56, SsimOfFlatAndNearlyFlatPicturesIsTheTruth) {
  std::mt19937 random(56);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  long double worst = 0.0L, worstOfAlike = 0.0L;
  for (int round = 0; round < 300; ++round) {
    const double level = 0.5 + 0.5 * unit(random), other = round % 3 == 0 ? level : 0.5 + 0.5 * unit(random);
    const double noise = round % 2 == 0 ? 0.0 : std::pow(10.0, -6.0 + 5.0 * std::abs(unit(random)));
    Levels a(kSide * kSide), b(kSide * kSide);
    for (size_t i = 0; i < a.size(); ++i) {
      const double common = noise * unit(random);
      a[i] = std::clamp(level + common, 0.0, 1.0);
      b[i] = std::clamp(
          other + (round % 5 == 0 ? -1.0 : 1.0) * common + (round % 4 == 0 ? 0.0 : 0.3 * noise * unit(random)), 0.0,
          1.0);
    }
    const Image<glm::vec4> imageA = pictureOf(a), imageB = pictureOf(b);
    const double ssim = ssimSrgb(imageA, imageB, kBlack);
    ASSERT_LE(ssim, 1.0) << "seed 56, round " << round;
    ASSERT_GE(ssim, -1.0) << "seed 56, round " << round;
    const long double error = std::abs(static_cast<long double>(ssim) - ssimTruth(a, b, kSide));
    worst = std::max(worst, error);
    if (std::abs(level - other) < 0.1) worstOfAlike = std::max(worstOfAlike, error);
    ASSERT_EQ(ssimSrgb(imageA, imageA, kBlack), 1.0) << "seed 56, round " << round;
  }
  record({"ssimSrgb, flat and nearly flat pictures", "long double", "", static_cast<double>(worst), kSsimError});
  record({"ssimSrgb, of levels less than 0.1 apart", "long double", "", static_cast<double>(worstOfAlike),
          kSsimErrorOfAlike});
}

TEST_P(Case56, IdenticalPicturesHaveNoErrors) {
  for (const auto& [width, height] : {std::pair<uint32_t, uint32_t>{1, 1}, {17, 3}, {11, 64}, {301, 203}}) {
    const Image<glm::vec4> image = noise(width, height, 56);
    const Errors errors = errorsOn(GetParam(), image, image, {0.1f, 0.2f, 0.3f});
    EXPECT_EQ(errors.psnrDb, std::numeric_limits<double>::infinity());
    EXPECT_EQ(errors.flip, 0.0);
    if (GetParam() == Backend::cpu)
      EXPECT_EQ(errors.ssim, 1.0);
    else
      EXPECT_NEAR(errors.ssim, 1.0, 1e-6);  // sums of a device's tiles
    for (const float value : flip(image, image, kBlack).map) ASSERT_EQ(value, 0.0f);
  }
  recordExact("PSNR infinite, SSIM 1, FLIP 0 of identical pictures", "definition", GetParam());
}

TEST_P(Case57, OtherImplementationsSayTheSame) {
  const Errors errors = errorsOn(GetParam(), somePicture(0.35, true), somePicture(0.0, false));
  record({"flip", "flip-evaluator", "", std::abs(errors.flip - kOracleFlip), kFlipError, GetParam()});
  record({"ssimSrgb, a picture that is not flat", "scikit-image", "", std::abs(errors.ssim - kOracleSsim), 1e-5,
          GetParam()});
  record({"psnrSrgb", "scikit-image", "dB", std::abs(errors.psnrDb - kOraclePsnrDb), 1e-4, GetParam()});
}

/// What is shown of a channel, in long double.
long double shownOf(const glm::vec4& p, int c, const glm::vec3& background) {
  const long double linear = std::clamp(p[c] + (1.0L - p.a) * background[c], 0.0L, 1.0L);
  return linear <= 0.0031308L ? 12.92L * linear : 1.055L * std::pow(linear, 1.0L / 2.4L) - 0.055L;
}

TEST_P(Case57, PropertyPsnrIsWithinItsBound) {
  Worst worst;
  checkProperty([&] {
    const uint32_t width = *rc::gen::inRange(1u, 60u), height = *rc::gen::inRange(1u, 60u);
    const Image<glm::vec4> reference = noise(width, height, *rc::gen::arbitrary<uint32_t>()),
                           other = noise(width, height, *rc::gen::arbitrary<uint32_t>());
    // From quite another picture to one that differs in its last bits.
    const float share = std::min(1.0f, *anyPositive(-22, 0));
    Image<glm::vec4> image = reference;
    for (size_t i = 0; i < image.size(); ++i) image[i] += share * (other[i] - reference[i]);
    const glm::vec3 background(0.1f, 0.2f, 0.3f);
    long double sum = 0.0L;
    for (size_t i = 0; i < image.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const long double difference = shownOf(image[i], c, background) - shownOf(reference[i], c, background);
        sum += difference * difference;
      }
    const long double truth = std::sqrt(sum / (3.0L * static_cast<long double>(image.size())));
    const double psnr = GetParam() == Backend::cpu ? psnrSrgb(image, reference, background)
                                                   : errorsOn(GetParam(), image, reference, background).psnrDb;
    const long double rms = std::pow(10.0L, -0.05L * static_cast<long double>(psnr));
    const long double beyond = std::abs(rms - truth) - static_cast<long double>(kRmsRelativeError) * truth;
    RC_ASSERT(beyond <= static_cast<long double>(kRmsError));
    worst.see(static_cast<double>(std::max(0.0L, beyond)));
    if (GetParam() == Backend::cpu) RC_ASSERT(psnr == psnrSrgb(reference, image, background));
  });
  record({"psnrSrgb, from pictures that have nothing in common to 2^-22 apart", "long double",
          "of the root of the mean square", worst.value(), kRmsError, GetParam()});
}

TEST_P(Case57, PropertySsimIsWithinItsBoundAndRange) {
  Worst worst;
  checkProperty([&] {
    const double level = static_cast<double>(*anyFraction()),
                 other = *rc::gen::arbitrary<bool>() ? level : static_cast<double>(*anyFraction());
    const auto strength = static_cast<double>(std::min(0.3f, *anyPositive(-24, -2)));
    std::mt19937 random(*rc::gen::arbitrary<uint32_t>());
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const double shared = *rc::gen::element(1.0, -1.0, 0.0);
    Levels a(kSide * kSide), b(kSide * kSide);
    for (size_t i = 0; i < a.size(); ++i) {
      const double common = strength * unit(random);
      a[i] = std::clamp(level + common, 0.0, 1.0);
      b[i] = std::clamp(other + shared * common + 0.3 * strength * unit(random), 0.0, 1.0);
    }
    const Image<glm::vec4> imageA = pictureOf(a), imageB = pictureOf(b);
    const double ssim =
        GetParam() == Backend::cpu ? ssimSrgb(imageA, imageB, kBlack) : errorsOn(GetParam(), imageA, imageB).ssim;
    RC_ASSERT(ssim <= 1.0 + (GetParam() == Backend::cpu ? 0.0 : 1e-6));
    RC_ASSERT(ssim >= -1.0);
    const auto error = static_cast<double>(std::abs(static_cast<long double>(ssim) - ssimTruth(a, b, kSide)));
    RC_ASSERT(error <= kSsimError);
    worst.see(error);
  });
  record(
      {"ssimSrgb, noise from 1e-7 to 0.3 around any levels", "long double", "", worst.value(), kSsimError, GetParam()});
}

/// FLIP of two pictures of one colour each, where filters do nothing: the paper's section 4.1.2 and 4.3, in double.
double flipOfColors(const glm::dvec3& p, const glm::dvec3& q) {
  const auto lab = [](const glm::dvec3& rgb) {
    const glm::dvec3 row[3] = {{10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
                               {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
                               {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};
    double f[3];
    for (int i = 0; i < 3; ++i) {
      const double t = glm::dot(row[i], rgb) / (row[i].x + row[i].y + row[i].z);
      f[i] = t > 216.0 / 24389.0 ? std::cbrt(t) : 841.0 / 108.0 * t + 4.0 / 29.0;
    }
    const double lightness = 116.0 * f[1] - 16.0;
    return glm::dvec3(lightness, 0.01 * lightness * 500.0 * (f[0] - f[1]), 0.01 * lightness * 200.0 * (f[1] - f[2]));
  };
  const auto hyab = [&](const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 off = lab(a) - lab(b);
    return std::pow(std::abs(off.x) + std::hypot(off.y, off.z), 0.7);
  };
  const double largest = hyab({0, 1, 0}, {0, 0, 1}), knee = 0.4 * largest, distance = hyab(p, q);
  return distance < knee ? 0.95 * distance / knee : 0.95 + 0.05 * (distance - knee) / (largest - knee);
}

TEST_P(Case57, PropertyFlipOfUniformPicturesIsTheFormula) {
  Worst worst;
  checkProperty([&] {
    const auto color = [] { return glm::vec3(*anyFraction(), *anyFraction(), *anyFraction()); };
    const glm::vec3 p = color(), q = *rc::gen::arbitrary<bool>()
                                         ? color()
                                         : glm::clamp(p + *anyPositive(-12, -3) * color(), 0.0f, 1.0f);
    const Image<glm::vec4> a(20, 14, glm::vec4(p, 1.0f)), b(20, 14, glm::vec4(q, 1.0f));
    const auto flipOn = [&](const Image<glm::vec4>& x, const Image<glm::vec4>& y) {
      return GetParam() == Backend::cpu ? flip(x, y, kBlack).mean : errorsOn(GetParam(), x, y).flip;
    };
    const double found = flipOn(a, b);
    RC_ASSERT(found >= 0.0);
    RC_ASSERT(found <= 1.0);
    // The power is infinitely steep at 0: what rounding makes of a distance there is to the power of 0.7, too.
    const double error = std::abs(found - flipOfColors(glm::dvec3(p), glm::dvec3(q)));
    RC_ASSERT(error <= kFlipErrorOfUniform);
    worst.see(error);
    RC_ASSERT(std::abs(found - flipOn(b, a)) <= 1e-6);
  });
  record({"flip of uniform pictures", "closed form in double", "", worst.value(), kFlipErrorOfUniform, GetParam()});
}

TEST_P(Case58, PixelsThatAreNoNumbersAreAnErrorAndNotANumber) {
  const Image<glm::vec4> good = noise(64, 64, 58);
  for (const float wrong :
       {std::nanf(""), std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()})
    for (int channel = 0; channel < 4; ++channel) {
      SCOPED_TRACE(testing::Message() << wrong << " in channel " << channel);
      Image<glm::vec4> bad = good;
      bad(31, 7)[channel] = wrong;
      EXPECT_THROW(errorsOn(GetParam(), bad, good), InputError);
      EXPECT_THROW(errorsOn(GetParam(), good, bad), InputError);
      EXPECT_THROW(errorsOn(GetParam(), bad, bad), InputError);
      if (GetParam() == Backend::cuda) continue;
      EXPECT_THROW(psnrSrgb(bad, good, kBlack), InputError);
      EXPECT_THROW(ssimSrgb(bad, good, kBlack), InputError);
      EXPECT_THROW(flip(good, bad, kBlack), InputError);
    }
  EXPECT_NO_THROW(errorsOn(GetParam(), good, noise(64, 64, 59)));
  recordExact("PSNR, SSIM, FLIP of NaN and infinite pixels", "refused", GetParam());
}

}  // namespace
}  // namespace warpscope
