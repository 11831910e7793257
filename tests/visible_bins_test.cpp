// Whether an interval shows something, against the table's own answer, for functions with steps, spikes and feet in
// bins of their own. Mirrors render/core/visible_bins.h.
#include "render/core/visible_bins.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "render/core/textbook_table.h"

namespace warpscope {
namespace {

/// A function of few corners, many of them steps or spikes, most of it hidden.
TransferFunction someFunction(std::mt19937& random, double lower, double upper, bool isWhole) {
  std::uniform_real_distribution<double> place(lower - 0.1 * (upper - lower), upper + 0.1 * (upper - lower));
  std::vector<double> places(random() % 12);
  for (double& x : places) x = isWhole && random() % 2 ? std::floor(place(random)) : place(random);
  if (!places.empty() && random() % 2) places.push_back(places.front());
  if (!places.empty() && random() % 2) places.push_back(places.front() + 1e-4 * (upper - lower));
  std::sort(places.begin(), places.end());
  TransferFunction function;
  for (const double x : places) {
    const float alphas[] = {0.0f, 0.0f, 0.0f, 1e-5f, 0.02f, 0.7f, 1.0f};
    function.points.push_back(
        {x, glm::vec3(0.25f * static_cast<float>(random() % 5)), alphas[random() % std::size(alphas)]});
  }
  if (function.points.empty()) function.points.push_back({0.0, glm::vec3(1.0f), random() % 2 ? 0.5f : 0.0f});
  return function;
}

/// Ends where answers may change: around borders of bins and pieces, and anywhere.
float someEnd(std::mt19937& random, const TransferTable& table, const TransferDomain& domain) {
  float x = domain.lower + (domain.upper - domain.lower) * static_cast<float>(random() % 1001) / 1000.0f;
  if (random() % 2 && !table.begins.empty()) x = table.begins[random() % table.begins.size()];
  if (random() % 8 == 0 && table.scale > 0.0f)
    x = (static_cast<float>(random() % table.bins) - table.offset) / table.scale;
  const int away = static_cast<int>(random() % 5) - 2;
  for (int i = 0; i < std::abs(away); ++i) x = std::nextafter(x, away < 0 ? -INFINITY : INFINITY);
  return x;
}

void expectPlain(const TransferTable& table, const TransferDomain& domain, std::mt19937& random) {
  const std::vector<int32_t> next = nextVisibleBins(table);
  const VisibleBins bins{table.lookup(), next.data()};
  for (int i = 0; i < 400; ++i) {
    const float a = someEnd(random, table, domain), b = random() % 3 ? someEnd(random, table, domain) : a;
    ASSERT_EQ(bins.any(a, b), table.anyVisible(a, b)) << a << " to " << b;
    ASSERT_EQ(bins.any(b, a), table.anyVisible(b, a)) << b << " to " << a;
  }
  for (const float end : {-INFINITY, domain.lower, domain.upper, INFINITY})
    for (const float other : {-INFINITY, domain.lower, domain.upper, INFINITY})
      ASSERT_EQ(bins.any(end, other), table.anyVisible(end, other));
  ASSERT_FALSE(bins.any(NAN, domain.upper));
  ASSERT_FALSE(bins.any(domain.lower, NAN));
}

RC_GTEST_PROP(VisibleBins, AnswerAsTheTableDoes, (uint32_t seed)) {
  std::mt19937 random(seed);
  const TransferDomain domains[] = {{0.0f, 255.0f, true},
                                    {-32768.0f, 32767.0f, true},
                                    {0.0f, 1.0f, false},
                                    {-3e5f, 7e8f, false},
                                    {5.0f, 5.0f, false}};
  const TransferDomain domain = domains[random() % std::size(domains)];
  const TransferFunction function = someFunction(random, domain.lower, domain.upper, domain.isWhole);
  const float step = random() % 2 ? 0.5f : 3.0f;
  expectPlain(bakeTransferTable(function, domain, step), domain, random);
  expectPlain(bakeTextbookTable(function, domain, step), domain, random);
  RC_ASSERT(!testing::Test::HasFailure());
}

TEST(VisibleBins, KnowBinsThatShowSomethingInPlaces) {
  // Two spikes within a bin of thousands, and nothing else.
  const TransferDomain domain{0.0f, 1.0f, false};
  TransferFunction function;
  const auto add = [&](double x, float alpha) { function.points.push_back({x, glm::vec3(1.0f), alpha}); };
  add(0.0, 0.0f);
  for (const double x : {0.50001, 0.50003}) {
    add(x, 0.0f);
    add(x, 0.5f);
    add(x + 1e-6, 0.5f);
    add(x + 1e-6, 0.0f);
  }
  add(1.0, 0.0f);
  const TransferTable table = bakeTransferTable(function, domain, 0.5f);
  const std::vector<int32_t> next = nextVisibleBins(table);
  const VisibleBins bins{table.lookup(), next.data()};
  EXPECT_FALSE(bins.any(0.1f, 0.50000f));
  EXPECT_TRUE(bins.any(0.1f, 0.500015f));
  EXPECT_FALSE(bins.any(0.500015f, 0.50002f));
  EXPECT_TRUE(bins.any(0.500015f, 0.50004f));
  EXPECT_FALSE(bins.any(0.50004f, 0.9f));
  EXPECT_TRUE(bins.any(0.50002f, 0.9f));
  EXPECT_TRUE(bins.any(0.0f, 1.0f));
}

}  // namespace
}  // namespace warpscope
