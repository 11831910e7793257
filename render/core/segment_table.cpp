// Integrals between nodes, and steps composited of them.
// See segment_table.h.
#include "render/core/segment_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/core/counters.h"
#include "render/core/parallel.h"

namespace warpscope {
namespace {

/// Extinction of a unit whose opacity is 1: nothing is left behind a thousandth of it.
constexpr double kOpaque = 1e6;
constexpr double kMostOffset = 1 << 18;  ///< bins up to there can be told apart

double extinctionOf(double alpha) { return alpha >= 1.0 ? kOpaque : std::min(kOpaque, -std::log1p(-std::max(alpha, 0.0))); }

/// Extinction, and light that is emitted, of a unit.
struct Medium {
  double extinction = 0.0;
  glm::dvec3 emission{0.0};

  Medium& operator+=(const Medium& other) {
    extinction += other.extinction;
    emission += other.emission;
    return *this;
  }
};
Medium operator*(double factor, const Medium& medium) { return {factor * medium.extinction, factor * medium.emission}; }

Medium mediumOf(const glm::dvec4& straight) {
  const double extinction = extinctionOf(straight.a);
  return {extinction, extinction * glm::dvec3(straight)};
}

/// What a piece of it sends that holds back `alpha`.
glm::dvec3 lightOf(const Medium& medium, double alpha) { return medium.extinction > 0.0 ? medium.emission * (alpha / medium.extinction) : glm::dvec3(0.0); }

/// Integral over values from `a` to `b`, between which the function is linear: Gauss and Legendre's rule of four points.
Medium integralOf(const glm::dvec4& atA, const glm::dvec4& atB, double width) {
  constexpr double kPlaces[4] = {0.06943184420297371, 0.33000947820757187, 0.66999052179242813, 0.93056815579702629};
  constexpr double kWeights[4] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307, 0.17392742256872693};
  Medium sum;
  for (int i = 0; i < 4; ++i) sum += kWeights[i] * width * mediumOf(glm::mix(atA, atB, kPlaces[i]));
  return sum;
}

class SegmentTableBaking {
 public:
  SegmentTableBaking(const TransferFunction& function, const TransferDomain& domain, float step) : function_(function), step_(step) {
    layNodes(domain);
    before_.resize(places_.size());
    for (size_t i = 1; i < places_.size(); ++i) {
      before_[i] = before_[i - 1];
      before_[i] += integralBetween(places_[i - 1], places_[i]);
    }
  }

  SegmentTable bake() {
    const size_t nodes = places_.size();
    table_.nodes = static_cast<int32_t>(nodes);
    table_.entries.resize(nodes * nodes);
    table_.alphas.resize(nodes * nodes);
    table_.unitAlphas.resize(nodes * nodes);
    if (step_ != 1.0f) WARPSCOPE_COUNT(corrections, nodes * nodes);
    parallelForRanges(nodes, 4, [&](size_t begin, size_t end) {
      for (size_t a = begin; a < end; ++a) {
        set(a, a, entryOf(mediumAt(a)));
        for (size_t b = a + 1; b < nodes; ++b) setBoth(a, b);
      }
    });
    for (const float alpha : table_.alphas) table_.mostOpacity = std::max(table_.mostOpacity, alpha);
    return std::move(table_);
  }

 private:
  struct Entry {
    glm::vec4 color{0.0f};
    float unitAlpha = 0.0f;
  };
  void set(size_t front, size_t back, const Entry& entry) {
    const size_t place = front * places_.size() + back;
    table_.entries[place] = entry.color;
    table_.alphas[place] = entry.color.a;
    table_.unitAlphas[place] = entry.unitAlpha;
  }

  void layNodes(const TransferDomain& domain) {
    double lower = static_cast<double>(domain.lower), upper = static_cast<double>(domain.upper);
    if (!(lower < upper)) upper = lower + std::max(1.0, std::abs(lower)) * 1e-3;  // a volume of one value
    const double lowest = lower, highest = upper;
    if (!function_.points.empty()) {
      const auto [first, last] = function_.changingValues();
      lower = std::clamp(first, lowest, highest);
      upper = std::clamp(last, lowest, highest);
    }
    // A node more on each side, so that a step at an end is not blended with all that is beyond.
    int inner = SegmentTable::kInner;
    if (domain.isWhole && std::ceil(upper) - std::floor(lower) + 2.0 <= inner) {
      lower = std::max(std::floor(lower) - 1.0, std::floor(lowest));
      upper = std::max(std::min(std::ceil(upper) + 1.0, std::ceil(highest)), lower + 1.0);
      inner = static_cast<int>(upper - lower);
    } else {
      const double around = lower < upper ? (upper - lower) / (inner - 2) : (highest - lowest) / (2 * inner);
      lower = std::max(lower - around, lowest);
      upper = std::min(upper + around, highest);
    }
    // Stretches that float cannot tell apart from their neighbours are not worth a node.
    const double least = 1e-6 * std::max({std::abs(lowest), std::abs(highest), upper - lower}) + static_cast<double>(std::numeric_limits<float>::min());
    const bool hasBelow = lower - lowest > least, hasAbove = highest - upper > least;
    addStretch(0, lowest, lower, hasBelow ? SegmentTable::kOuter : 0);
    addStretch(1, lower, upper, inner);
    addStretch(2, upper, highest, hasAbove ? SegmentTable::kOuter : 0);
    places_.push_back(hasAbove ? highest : upper);
  }
  void addStretch(int which, double begin, double end, int count) {
    if (count == 0) return;
    SegmentLookup::Stretch& stretch = table_.stretches[which];
    stretch.begin = static_cast<float>(begin);
    stretch.scale = static_cast<float>(std::min(count / (end - begin), static_cast<double>(std::numeric_limits<float>::max())));
    stretch.count = static_cast<float>(count);
    for (int i = 0; i < count; ++i) places_.push_back(begin + (end - begin) * i / count);
  }

  Medium integralBetween(double a, double b) const {
    Medium sum;
    const auto& points = function_.points;
    double left = a;
    const auto until = [&](double right) {
      if (left < right) sum += integralOf(glm::dvec4(function_.at(left)), glm::dvec4(function_.below(right)), right - left);
      left = right;
    };
    for (auto point = std::upper_bound(points.begin(), points.end(), a, [](double value, const TransferPoint& p) { return value < p.value; });
         point != points.end() && point->value < b; ++point)
      until(point->value);
    until(b);
    return sum;
  }
  /// Of a step along which the value does not change.
  Medium mediumAt(size_t node) const { return mediumOf(glm::dvec4(function_.at(places_[node]))); }

  Entry entryOf(const Medium& medium) const {
    const double alpha = -std::expm1(-medium.extinction * static_cast<double>(step_));
    return {glm::vec4(glm::dvec4(lightOf(medium, alpha), alpha)), static_cast<float>(-std::expm1(-medium.extinction))};
  }

  /// A step from node a to a greater one, and the way back.
  void setBoth(size_t a, size_t b) {
    const double width = places_[b] - places_[a];
    const Medium all = difference(a, b);
    if (!(all.extinction > 0.0)) return;  // as it is
    const size_t pieces = std::min<size_t>(b - a, SegmentTable::kPieces);
    glm::dvec3 forth(0.0), back(0.0);
    double through = 1.0;
    size_t begin = a;
    for (size_t k = 1; k <= pieces; ++k) {
      const size_t end = a + (b - a) * k / pieces;
      const Medium piece = difference(begin, end);
      const double left = std::exp(-piece.extinction / width * static_cast<double>(step_));
      const glm::dvec3 color = lightOf(piece, 1.0 - left);
      forth += through * color;   // behind what is before it
      back = color + left * back;  // before it
      through *= left;
      begin = end;
    }
    const float alpha = static_cast<float>(-std::expm1(-all.extinction / width * static_cast<double>(step_)));
    const float unitAlpha = static_cast<float>(-std::expm1(-all.extinction / width));
    set(a, b, {glm::vec4(glm::vec3(forth), alpha), unitAlpha});
    set(b, a, {glm::vec4(glm::vec3(back), alpha), unitAlpha});
  }
  Medium difference(size_t a, size_t b) const { return {before_[b].extinction - before_[a].extinction, before_[b].emission - before_[a].emission}; }

  const TransferFunction& function_;
  const float step_;
  SegmentTable table_;
  std::vector<double> places_;  // of the nodes
  std::vector<Medium> before_;  // integrals from the first node on
};

}  // namespace

SegmentLookup SegmentTable::lookup() const {
  SegmentLookup lookup;
  lookup.entries = entries.data();
  lookup.alphas = alphas.data();
  lookup.unitAlphas = unitAlphas.data();
  std::copy(std::begin(stretches), std::end(stretches), lookup.stretches);
  lookup.nodes = nodes;
  return lookup;
}

SegmentTable bakeSegmentTable(const TransferFunction& function, const TransferDomain& domain, float step) {
  return SegmentTableBaking(function, domain, step).bake();
}

TransferTable visibleBySegments(const SegmentTable& segments) {
  // Whether steps between a node and the next show anything, forth as well as back.
  const auto shows = [&](int node) {
    const auto at = [&](int front, int back) { return segments.alphas[static_cast<size_t>(front * segments.nodes + back)] > 0.0f; };
    return at(node, node) || at(node, node + 1) || at(node + 1, node + 1);
  };
  const auto showsBetween = [&](int begin, int end) {
    for (int node = std::max(begin, 0); node < std::min(end, segments.nodes - 1); ++node)
      if (shows(node)) return true;
    return false;
  };
  // As many bins as there are steps inside, moved down by what rounding may misplace a value; one more above them, and one on each side for all beyond.
  const SegmentLookup::Stretch& inside = segments.stretches[1];
  const int first = static_cast<int>(segments.stretches[0].count), inner = static_cast<int>(inside.count);
  const double unmoved = 1.0 - static_cast<double>(inside.begin) * static_cast<double>(inside.scale);
  const double offset = unmoved + 0x1p-21 * (std::abs(unmoved) + inner + 2.0);
  TransferTable table;
  if (std::abs(offset) < kMostOffset) {
    table.bins = inner + 3;
    table.scale = inside.scale;
    table.offset = static_cast<float>(offset);
    table.alphas.push_back(showsBetween(0, std::max(first, 1)) ? 1.0f : 0.0f);
    for (int bin = 1; bin <= inner + 1; ++bin) table.alphas.push_back(showsBetween(first + bin - 2, first + bin + 1) ? 1.0f : 0.0f);
    table.alphas.push_back(showsBetween(std::min(first + inner, segments.nodes - 2), segments.nodes) ? 1.0f : 0.0f);
  } else {
    table.alphas.push_back(showsBetween(0, segments.nodes) ? 1.0f : 0.0f);
  }
  table.entries.assign(table.alphas.size(), glm::vec4(0.0f));
  table.unitAlphas = table.alphas;
  table.countVisible();
  return table;
}

}  // namespace warpscope
