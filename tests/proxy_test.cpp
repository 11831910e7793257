// The coarse copy of a volume: what its voxels hold, what is left out, and the fit that makes them.
// Mirrors render/volume/proxy.h and render/volume/linear_fit.h.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "marcher_cases.h"
#include "render/base/error.h"
#include "render/metrics/psnr.h"
#include "render/volume/linear_fit.h"
#include "render/volume/proxy.h"
#include "test_volumes.h"

namespace warpscope {
namespace {

const glm::uvec3 kBlobDims(48, 44, 40);
const Camera kBlobViewer = lookingFrom({30.0f, 25.0f, 75.0f}, glm::vec3(0.0f), 160, 120, 0.45f);

std::vector<double> unitNumbers(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<double> numbers(count);
  for (double& number : numbers) number = unit(random);
  return numbers;
}

/// The numbers of `count` cells that are 1 long together, interpolated at a place.
double interpolated(const std::vector<double>& numbers, double place) {
  const double at = std::clamp(place * static_cast<double>(numbers.size()) - 0.5, 0.0, static_cast<double>(numbers.size() - 1));
  const auto cell = static_cast<size_t>(at);
  return cell + 1 < numbers.size() ? std::lerp(numbers[cell], numbers[cell + 1], at - static_cast<double>(cell)) : numbers.back();
}

std::vector<double> fitted(const std::vector<double>& many, size_t few) {
  const LinearFit fit(static_cast<uint32_t>(many.size()), static_cast<uint32_t>(few));
  std::vector<double> numbers;
  for (size_t i = 0; i < few; ++i) {
    const CellMean& mean = fit.means()[i];
    numbers.push_back(std::inner_product(mean.weights.begin(), mean.weights.end(), many.begin() + mean.first, 0.0));
  }
  fit.solve(numbers);
  return numbers;
}

/// Nothing else of as many numbers is nearer: against what is left is, each number's part in what is interpolated adds up to nothing. By many small steps.
TEST(LinearFit, PropertyIsNearestOfAll) {
  for (const auto& [many, few] : std::vector<std::pair<size_t, size_t>>{{23, 9}, {16, 8}, {10, 9}, {40, 3}, {7, 1}, {5, 5}, {100, 97}}) {
    const std::vector<double> fine = unitNumbers(many, static_cast<uint32_t>(many)), coarse = fitted(fine, few);
    constexpr int kSteps = 40000;
    std::vector<double> sums(few), hat(few);
    for (int i = 0; i < kSteps; ++i) {
      const double place = (i + 0.5) / kSteps, left = interpolated(fine, place) - interpolated(coarse, place);
      const double at = std::clamp(place * static_cast<double>(few) - 0.5, 0.0, static_cast<double>(few - 1));
      const auto cell = static_cast<size_t>(at);
      const double ofNext = at - static_cast<double>(cell);
      sums[cell] += (1.0 - ofNext) * left;
      if (cell + 1 < few) sums[cell + 1] += ofNext * left;
    }
    for (size_t i = 0; i < few; ++i) EXPECT_NEAR(sums[i] * static_cast<double>(few) / kSteps, 0.0, 1e-5) << many << " to " << few << ", " << i;
  }
}

TEST(LinearFit, KeepsSumsAndWhatNeedsNoFit) {
  const std::vector<double> fine = unitNumbers(31, 3), coarse = fitted(fine, 12), same = fitted(fine, 31), constant = fitted(std::vector<double>(31, 7.0), 12);
  EXPECT_NEAR(std::accumulate(coarse.begin(), coarse.end(), 0.0) / 12, std::accumulate(fine.begin(), fine.end(), 0.0) / 31, 1e-12);
  for (size_t i = 0; i < fine.size(); ++i) EXPECT_NEAR(same[i], fine[i], 1e-12);
  for (const double number : constant) EXPECT_NEAR(number, 7.0, 1e-12);
}

/// Each run between missing ones is solved as if it went on as it ends: against all equations of it, by substitution.
TEST(LinearFit, BesideWhatIsMissingItIsAsIfThatHadTheSame) {
  const LinearFit fit(40, 10);
  const std::vector<double> means{2.0, 7.0, NAN, 5.0, -3.0, 4.0, NAN, NAN, 1.0, NAN};
  std::vector<double> numbers = means;
  fit.solve(numbers);
  // Within a row of equal cells a mean is two thirds its own number and a sixth each of its neighbours'; at the ends five sixths.
  for (size_t i = 0; i < means.size(); ++i) {
    if (std::isnan(means[i])) {
      EXPECT_TRUE(std::isnan(numbers[i])) << i;
      continue;
    }
    const auto beside = [&](size_t other) { return other < means.size() && !std::isnan(means[other]) ? numbers[other] : numbers[i]; };
    EXPECT_NEAR((4.0 * numbers[i] + beside(i - 1) + beside(i + 1)) / 6.0, means[i], 1e-12) << i;
  }
}

/// Of what is a product of lines along three axes it is the product of their fits.
TEST(LinearFit, AGridIsFittedAlongEachAxis) {
  const std::vector<std::pair<uint32_t, uint32_t>> sizes{{17, 6}, {12, 5}, {9, 4}};
  std::vector<LinearFit> axes;
  std::vector<std::vector<double>> means(3), fits(3);
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto& [fine, coarse] = sizes[axis];
    const std::vector<double> line = unitNumbers(fine, fine);
    axes.emplace_back(fine, coarse);
    for (const CellMean& mean : axes[axis].means()) means[axis].push_back(std::inner_product(mean.weights.begin(), mean.weights.end(), line.begin() + mean.first, 0.0));
    fits[axis] = fitted(line, coarse);
  }
  std::vector<float> numbers;
  for (const double z : means[2])
    for (const double y : means[1])
      for (const double x : means[0]) numbers.push_back(static_cast<float>(x * y * z));
  solveGrid(numbers, axes, {});
  size_t at = 0;
  for (const double z : fits[2])
    for (const double y : fits[1])
      for (const double x : fits[0]) EXPECT_NEAR(static_cast<double>(numbers[at++]), x * y * z, 1e-5);
}

TEST(LinearFit, CellsOwnWhatHasItsMiddleInThem) {
  const LinearFit fit(10, 4);  // of 2.5 each
  const std::vector<std::pair<uint32_t, uint32_t>> own{{0, 3}, {2, 5}, {5, 8}, {7, 10}};  // a middle on a border is in both
  for (size_t i = 0; i < own.size(); ++i) EXPECT_EQ(std::pair(fit.means()[i].ownFirst, fit.means()[i].ownEnd), own[i]) << i;
}

TEST(Proxy, OfTheLeastNumbersThereAreHasStepsToo) {
  const VolumePtr volume = makeTestVolume(VoxelType::float64, {8, 6, 4}, [](const glm::ivec3& p) { return p.x * 7e-323; });
  const Proxy proxy = makeProxy(*volume, everywhere(0.5f), 8, CopyFilter::leastSquares);
  EXPECT_GT(proxy.scale.perCode, 0.0);
  for (size_t i = 0; i < proxy.volume->voxelCount(); ++i) {
    const double value = proxy.scale.lowest + proxy.volume->voxelsAs<uint8_t>()[i] * proxy.scale.perCode;
    EXPECT_LE(value, volume->statistics().highest);
  }
}

/// What goes straight from voxel to voxel does so from one of the copy's to the next, but near the ends, where neither goes on.
TEST(Proxy, OfARampIsARamp) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint16, {48, 36, 32}, [](const glm::ivec3& p) { return p.x * 100.0 + p.y * 10.0 + p.z; });
  const Proxy proxy = makeProxy(*volume, everywhere(0.5f), 24, CopyFilter::leastSquares);
  ASSERT_EQ(proxy.volume->dims(), glm::uvec3(24, 18, 16));
  EXPECT_EQ(proxy.volume->bounds().upper, volume->bounds().upper);
  for (uint32_t z = 6; z < 10; ++z)
    for (uint32_t y = 6; y < 12; ++y)
      for (uint32_t x = 6; x < 18; ++x) {
        const double middle = (2.0 * x + 0.5) * 100.0 + (2.0 * y + 0.5) * 10.0 + 2.0 * z + 0.5;
        const double code = proxy.volume->voxelsAs<uint8_t>()[x + 24 * (y + 18 * z)];
        EXPECT_NEAR(proxy.scale.lowest + code * proxy.scale.perCode, middle, 0.51 * proxy.scale.perCode);
      }
}

/// Interpolated, it is nearer to the volume than means of what lies in each of its voxels are.
TEST(Proxy, IsNearerThanMeans) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kBlobDims, [](const glm::ivec3& p) {  // a thin shell
    const double beyond = glm::length(glm::dvec3(p) - 20.0) - 12.0;
    return 200.0 * std::exp(-0.5 * beyond * beyond);
  });
  const Proxy proxy = makeProxy(*volume, everywhere(0.5f), 24, CopyFilter::leastSquares);
  const glm::uvec3 dims = proxy.volume->dims();
  ASSERT_EQ(dims, kBlobDims / 2u);
  const auto fine = [&](const glm::uvec3& p) { return static_cast<double>(volume->voxelsAs<uint8_t>()[p.x + kBlobDims.x * (p.y + kBlobDims.y * p.z)]); };
  const auto forAll = [](const glm::uvec3& size, const auto& body) {
    for (glm::uvec3 p(0); p.z < size.z; ++p.z)
      for (p.y = 0; p.y < size.y; ++p.y)
        for (p.x = 0; p.x < size.x; ++p.x) body(p);
  };
  std::vector<double> means(size_t{dims.x} * dims.y * dims.z), fits(means.size());
  forAll(dims, [&](const glm::uvec3& p) {
    const size_t at = p.x + dims.x * (p.y + size_t{dims.y} * p.z);
    forAll(glm::uvec3(2), [&](const glm::uvec3& q) { means[at] += fine(2u * p + q) / 8; });
    fits[at] = proxy.scale.lowest + proxy.volume->voxelsAs<uint8_t>()[at] * proxy.scale.perCode;
  });
  const auto squaredError = [&](const std::vector<double>& copy) {
    double sum = 0.0;
    forAll(kBlobDims, [&](const glm::uvec3& p) {
      const glm::dvec3 at = glm::clamp(0.5 * glm::dvec3(p) - 0.25, glm::dvec3(0.0), glm::dvec3(dims) - 1.0), share = at - glm::floor(at);
      double value = 0.0;
      forAll(glm::uvec3(2), [&](const glm::uvec3& q) {
        const glm::uvec3 cell = glm::min(glm::uvec3(at) + q, dims - 1u);
        const glm::dvec3 weight = glm::mix(1.0 - share, share, glm::dvec3(q));
        value += weight.x * weight.y * weight.z * copy[cell.x + dims.x * (cell.y + size_t{dims.y} * cell.z)];
      });
      sum += (value - fine(p)) * (value - fine(p));
    });
    return sum;
  };
  EXPECT_LT(squaredError(fits), 0.7 * squaredError(means));
}

TEST(Proxy, ForLightHoldsMeansOfWhatLiesInEachVoxel) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint16, {8, 6, 4}, [](const glm::ivec3& p) { return p.x * 100.0 + p.y * 10.0 + p.z; });
  const Proxy proxy = makeProxy(*volume, everywhere(0.5f), 4, CopyFilter::means);
  ASSERT_EQ(proxy.volume->dims(), glm::uvec3(4, 3, 2));
  for (uint32_t z = 0; z < 2; ++z)
    for (uint32_t y = 0; y < 3; ++y)
      for (uint32_t x = 0; x < 4; ++x) {
        const double mean = (2.0 * x + 0.5) * 100.0 + (2.0 * y + 0.5) * 10.0 + 2.0 * z + 0.5;
        const double code = proxy.volume->voxelsAs<uint8_t>()[x + 4 * (y + 3 * z)];
        EXPECT_NEAR(proxy.scale.lowest + code * proxy.scale.perCode, mean, 0.5 * proxy.scale.perCode + 1e-9);
      }
}

TEST(Proxy, OfUnevenSizesKeepsTheSumOfValues) {
  const glm::uvec3 dims(31, 17, 23);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, dims, blobs(dims, 4));
  const Proxy proxy = makeProxy(*volume, everywhere(0.5f), 9, CopyFilter::means);
  double fine = 0.0, coarse = 0.0;
  for (size_t i = 0; i < volume->voxelCount(); ++i) fine += volume->voxelsAs<uint8_t>()[i];
  for (size_t i = 0; i < proxy.volume->voxelCount(); ++i) coarse += proxy.volume->voxelsAs<uint8_t>()[i];
  EXPECT_NEAR(coarse / static_cast<double>(proxy.volume->voxelCount()), fine / static_cast<double>(volume->voxelCount()), 0.3);
}

TEST(Proxy, OfValuesFartherApartThanTheLargestNumber) {
  const glm::uvec3 dims(8, 8, 8);
  for (const double most : {1.7e308, 1e308, 8e307}) {
    const Proxy copy = makeProxy(*makeTestVolume(VoxelType::float64, dims, [&](const glm::ivec3& p) { return p.x < 4 ? -most : most; }), everywhere(0.5f), 8, CopyFilter::leastSquares);
    EXPECT_TRUE(std::isfinite(copy.scale.perCode) && copy.scale.perCode > 0.0);
    EXPECT_NEAR(copy.scale.codeOf(0.0), 127.5, 1e-9);
    const uint8_t* const voxels = copy.volume->voxelsAs<uint8_t>();
    for (size_t i = 0; i < copy.volume->voxelCount(); ++i) ASSERT_EQ(voxels[i], i % 8 < 4 ? 0 : 255);
    const Proxy coarse = makeProxy(*makeTestVolume(VoxelType::float64, dims, [&](const glm::ivec3& p) { return p.x % 2 == 0 ? -most : most; }), everywhere(0.5f), 2, CopyFilter::leastSquares);
    const uint8_t* const ofBoth = coarse.volume->voxelsAs<uint8_t>();
    std::vector<double> line(8);
    for (size_t i = 0; i < line.size(); ++i) line[i] = i % 2 == 0 ? 0.0 : 255.0;
    const std::vector<double> expected = fitted(line, 2);
    for (size_t i = 0; i < coarse.volume->voxelCount(); ++i) ASSERT_NEAR(ofBoth[i], expected[i % 2], 0.51);
  }
}

TEST(Proxy, OfOneValueAloneIsThatValue) {
  for (const double value : {0.0, 1e300, -std::numeric_limits<double>::max()})
    for (const bool isMissing : {false, true})
      for (const CopyFilter filter : {CopyFilter::leastSquares, CopyFilter::means}) {
        const VolumePtr volume = makeTestVolume(VoxelType::float64, {9, 9, 9}, [&](const glm::ivec3& p) { return isMissing && p == glm::ivec3(4) ? NAN : value; });
        const Proxy copy = makeProxy(*volume, everywhere(0.5f), 4, filter);
        for (size_t i = 0; i < copy.volume->voxelCount(); ++i) ASSERT_EQ(copy.volume->voxelsAs<uint8_t>()[i], isMissing ? 1 : 0) << value;
      }
}

TEST(Proxy, IsCancelled) {
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kBlobDims, blobs(kBlobDims, 12));
  std::stop_source stop;
  stop.request_stop();
  for (const CopyFilter filter : {CopyFilter::leastSquares, CopyFilter::means}) EXPECT_THROW(makeProxy(*volume, everywhere(0.5f), 16, filter, stop.get_token()), OperationCancelled);
  std::vector<float> numbers(8);
  const std::vector<LinearFit> axes(3, LinearFit(4, 2));
  EXPECT_THROW(solveGrid(numbers, axes, stop.get_token()), OperationCancelled);
}

TEST(Proxy, LeavesOutWhatIsMissing) {
  const VolumePtr volume = makeTestVolume(VoxelType::float32, {4, 4, 4}, [](const glm::ivec3& p) { return p.x < 2 ? std::nan("") : p.y < 2 ? 10.0 : 20.0; });
  for (const CopyFilter filter : {CopyFilter::leastSquares, CopyFilter::means}) {
    const Proxy proxy = makeProxy(*volume, everywhere(0.5f), 2, filter);
    ASSERT_TRUE(proxy.scale.hasMissing);
    EXPECT_EQ(proxy.volume->voxelsAs<uint8_t>()[0], 0);
    EXPECT_EQ(proxy.volume->voxelsAs<uint8_t>()[1], 1);
    EXPECT_EQ(proxy.volume->voxelsAs<uint8_t>()[3], 255);
    const TransferFunction codes = functionOfCodes(proxy);
    EXPECT_EQ(codes.at(0.0).a, 0.0f);
    EXPECT_EQ(codes.at(1.0).a, 0.5f);
  }
}

TEST(Proxy, KnowsWhetherItIsTheVolume) {
  const FieldFunction blob = blobs(kBlobDims, 3);
  const auto copyOf = [&](VoxelType type, int longest, double factor = 1.0, double offset = 0.0) {
    return makeProxy(*makeTestVolume(type, kBlobDims, [&](const glm::ivec3& p) { return offset + factor * std::floor(blob(p)); }), everywhere(0.5f), longest, CopyFilter::leastSquares);
  };
  for (const auto& [type, offset] : {std::pair(VoxelType::uint8, 0.0), {VoxelType::int8, -60.0}, {VoxelType::int16, -20000.0}, {VoxelType::uint32, 4e9}}) {
    const Proxy whole = copyOf(type, 48, 1.0, offset);
    EXPECT_TRUE(whole.isExact);
    EXPECT_EQ(whole.scale.perCode, 1.0);
    size_t i = 0;
    for (glm::ivec3 p(0); p.z < 40; ++p.z)
      for (p.y = 0; p.y < 44; ++p.y)
        for (p.x = 0; p.x < 48; ++p.x) ASSERT_EQ(whole.scale.lowest + whole.volume->voxelsAs<uint8_t>()[i++], offset + std::floor(blob(p)));
  }
  EXPECT_FALSE(copyOf(VoxelType::uint8, 47).isExact);
  EXPECT_FALSE(copyOf(VoxelType::uint16, 48, 37.0).isExact);  // more values than codes
  EXPECT_FALSE(copyOf(VoxelType::float32, 48).isExact);
}

/// Filtered as finely as the volume is, it is the volume.
TEST(Proxy, OfAllVoxelsGivesTheVolumesPicture) {
  const TransferFunction function = band(15, 80, 0.5f);
  const VolumePtr volume = makeTestVolume(VoxelType::uint8, kBlobDims, blobs(kBlobDims, 11));
  const Proxy proxy = makeProxy(*volume, function, 48, CopyFilter::leastSquares);
  ASSERT_EQ(proxy.volume->dims(), kBlobDims);
  const MarcherPtr ofVolume = makeCpuMarcher(volume, function), ofCopy = makeCpuMarcher(proxy.volume, functionOfCodes(proxy));
  EXPECT_TRUE(rendered(*ofCopy, kBlobViewer) == rendered(*ofVolume, kBlobViewer));
}

}  // namespace
}  // namespace warpscope
