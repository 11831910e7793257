// Which bins a table has, and the pieces of those that are too coarse.
// See transfer_table.h.
#include "render/core/transfer_table.h"

#include <algorithm>
#include <limits>

#include "render/core/counters.h"
#include "render/core/parallel.h"
#include "render/core/rounding.h"

namespace warpscope {
namespace {

/// What a table holds of one place.
struct Entry {
  glm::vec4 color{0.0f};  ///< premultiplied, of a step
  float unitAlpha = 0.0f;
};

bool isShown(const Entry& entry) { return entry.color.a > 0.0f; }

bool areNear(const Entry& a, const Entry& b) {
  const glm::vec4 difference = glm::abs(a.color - b.color);
  const float most = std::max({difference.r, difference.g, difference.b, difference.a, std::abs(a.unitAlpha - b.unitAlpha)});
  return most <= TransferTable::kMostVariation;
}

bool areAlike(const Entry& a, const Entry& b) { return areNear(a, b) && isShown(a) == isShown(b); }

/// For what is come to but not met: what comes to nothing is something before.
bool isAlikeBelow(const Entry& entry, const Entry& limit) { return areNear(entry, limit) && (isShown(entry) || !isShown(limit)); }

/// Borders of bins, in the function's units: bin 0 ends at the lower one, the last begins at the upper one. Without bins between them there is but one bin.
struct Bins {
  double lower = 0.0;
  double upper = 0.0;
  int inner = 0;     ///< those between the first and the last
  int perWhole = 0;  ///< bins for a whole number's width; 0: numbers are not whole

  int count() const { return inner == 0 ? 1 : inner + 2; }
  double border(int i) const { return lower + (upper - lower) * i / inner; }  ///< i in 0..inner
  double scale() const { return inner == 0 ? 0.0 : perWhole > 0 ? perWhole : inner / (upper - lower); }
  double offset() const { return inner == 0 ? 0.0 : 1.0 - lower * scale(); }
  /// By how much x * scale + offset in float may misplace x around a border.
  double slack(int i) const { return perWhole > 0 ? 0.0 : (i + 1.0 + std::abs(offset())) * 0x1p-22 / scale(); }
};

/// Bins where the function changes, as far as the domain goes: beyond, one is enough.
Bins binsFor(const TransferFunction& function, const TransferDomain& domain) {
  Bins bins;
  bins.perWhole = domain.isWhole ? 1 : 0;
  if (!function.points.empty()) {
    const auto [first, last] = function.changingValues();
    const double lowest = domain.lower, highest = domain.upper;
    bins.lower = std::clamp<double>(roundedUp(first), lowest, highest);
    bins.upper = std::clamp<double>(roundedUp(last), lowest, highest);
  }
  constexpr double kMostCountedOffset = 1 << 22;  // bins are told apart to a whole one up to there
  if (domain.isWhole) {
    // At least a whole number between the first and the last bin; as many bins for each as fit, and as leave the offset exact.
    bins.lower = std::floor(bins.lower);
    bins.upper = std::max(std::ceil(bins.upper), bins.lower + 1.0);
    const double values = bins.upper - bins.lower;
    while (2.0 * bins.perWhole * values <= TransferTable::kBins && 2.0 * bins.perWhole * std::abs(bins.lower) < kMostCountedOffset) bins.perWhole *= 2;
    bins.inner = static_cast<int>(values) * bins.perWhole;
    return bins;
  }
  // One bin more on each side, so that a step at an end does not lie at the border of all that is beyond it; around a single step narrow ones. Where float
  // cannot count bins, all is told apart by pieces.
  const bool isOnePlace = !(bins.lower < bins.upper);
  bins.inner = isOnePlace ? 2 : TransferTable::kBins;
  const double width = isOnePlace ? std::max(std::abs(bins.lower), static_cast<double>(domain.upper) - static_cast<double>(domain.lower)) / TransferTable::kBins
                                  : (bins.upper - bins.lower) / (TransferTable::kBins - 2);
  bins.lower -= width;
  bins.upper += width;
  const bool canCount = width > 0.0 && bins.scale() <= std::numeric_limits<float>::max() && std::abs(bins.offset()) < kMostCountedOffset;
  if (!canCount) bins.inner = 0;
  return bins;
}

class TableBaking {
 public:
  TableBaking(const TransferFunction& function, const TransferDomain& domain, float step)
      : function_(function), bins_(binsFor(function, domain)) {
    // Of those that may be met; interpolation may overshoot a domain's ends by its rounding.
    const double margin = 1e-5 * std::max(std::abs(static_cast<double>(domain.lower)), std::abs(static_cast<double>(domain.upper)));
    const auto addCorner = [&](float place, double value) {
      if (!corners_.empty() && !(corners_.back() < place)) return;
      corners_.push_back(place);
      cornerValues_.push_back(value);
    };
    addCorner(domain.lower, static_cast<double>(domain.lower));  // pieces begin there, as at a corner
    for (const TransferPoint& point : function.points) {
      const float place = roundedUp(point.value);
      if (place > domain.upper + margin) break;
      addCorner(place, point.value);
    }
    addCorner(domain.upper, static_cast<double>(domain.upper));
    table_.step = step;
    table_.scale = static_cast<float>(bins_.scale());
    table_.offset = static_cast<float>(bins_.offset());
    table_.bins = bins_.count();
  }

  TransferTable bake() {
    const auto count = static_cast<size_t>(bins_.count());
    table_.entries.resize(count);
    table_.alphas.resize(count);
    table_.unitAlphas.resize(count);
    std::vector<uint8_t> isAlike(count);
    // Bins one by one take what a table takes: of 16-bit numbers there are as many as of these.
    constexpr size_t kBinsAtOnce = 1024;
    parallelForRanges(count, kBinsAtOnce, [&](size_t begin, size_t end) {
      Recent recent(*this);
      for (size_t i = begin; i < end; ++i) {
        Entry entry;
        isAlike[i] = lookAtBin(static_cast<int>(i), recent, entry);
        table_.entries[i] = entry.color;
        table_.alphas[i] = entry.color.a;
        table_.unitAlphas[i] = entry.unitAlpha;
      }
    });
    table_.visibleBefore.resize(count + 1);
    for (size_t i = 0; i < count; ++i) {
      const bool shows = isAlike[i] ? table_.alphas[i] > 0.0f : refineBin(static_cast<int>(i));
      table_.visibleBefore[i + 1] = table_.visibleBefore[i] + (shows ? 1 : 0);
    }
    for (const Entry& piece : pieces_) {
      table_.entries.push_back(piece.color);
      table_.alphas.push_back(piece.color.a);
      table_.unitAlphas.push_back(piece.unitAlpha);
    }
    return std::move(table_);
  }

 private:
  Entry entryOf(const glm::vec4& straight) const {
    const float unitAlpha = std::clamp(straight.a, 0.0f, 1.0f);
    // Nothing stays nothing, and is most of many functions; over a unit, opacity is what it is.
    const bool isCorrected = unitAlpha != 0.0f && table_.step != 1.0f;
    if (isCorrected) WARPSCOPE_COUNT(corrections, 1);
    const float alpha = isCorrected ? correctOpacity(unitAlpha, table_.step) : unitAlpha;
    return {{glm::vec3(straight) * alpha, alpha}, unitAlpha};
  }
  Entry from(double x) const { return entryOf(function_.at(x)); }
  /// What floats below x come to. No float lies between a corner and its place.
  Entry before(double x) const {
    const auto corner = std::lower_bound(corners_.begin(), corners_.end(), x);
    const bool isCorner = corner != corners_.end() && static_cast<double>(*corner) == x;
    return entryOf(function_.below(isCorner ? cornerValues_[static_cast<size_t>(corner - corners_.begin())] : x));
  }

  /// from() and before(), which remembers the last places: where bins meet, and at whole numbers, the next bin asks for
  /// what this one was told.
  class Recent {
   public:
    explicit Recent(const TableBaking& baking) : baking_(baking) {}
    Entry from(double x) {
      if (x == places_[0]) return entries_[0];
      if (x == places_[1]) return entries_[1];
      places_[oldest_] = x;
      entries_[oldest_] = baking_.from(x);
      oldest_ ^= 1;
      return entries_[oldest_ ^ 1];
    }
    Entry before(double x) {
      // The same, but where something begins: at a corner's place, and at its value.
      const auto& points = baking_.function_.points;
      const auto point = std::lower_bound(points.begin(), points.end(), x,
                                          [](const TransferPoint& p, double v) { return p.value < v; });
      const bool isValue = point != points.end() && point->value == x;
      const auto corner = std::lower_bound(baking_.corners_.begin(), baking_.corners_.end(), x);
      const bool isPlace = corner != baking_.corners_.end() && static_cast<double>(*corner) == x;
      return isValue || isPlace ? baking_.before(x) : from(x);
    }

   private:
    const TableBaking& baking_;
    double places_[2] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
    Entry entries_[2];
    int oldest_ = 0;
  };

  /// What may be looked up in a bin: [begin, end).
  struct Extents {
    double begin, end;
  };
  Extents extentsOf(int bin) const {
    constexpr double kNoEnd = std::numeric_limits<double>::infinity();
    return {bin == 0 ? -kNoEnd : bins_.border(bin - 1) - bins_.slack(bin - 1),
            bin == bins_.count() - 1 ? kNoEnd : bins_.border(bin) + bins_.slack(bin)};
  }

  /// Whether `entry`, a bin's, stands for all of it.
  bool lookAtBin(int bin, Recent& recent, Entry& entry) const {
    const bool isFirst = bin == 0, isLast = bin == bins_.count() - 1;
    const auto [begin, end] = extentsOf(bin);
    entry = isFirst  ? recent.before(bins_.lower)
            : isLast ? recent.from(bins_.upper)
                     : recent.from(middleOf(bins_.border(bin - 1), bins_.border(bin)));
    bool isAlike =
        (isFirst || areAlike(entry, recent.from(begin))) && (isLast || isAlikeBelow(entry, recent.before(end)));
    if (isAlike) {
      const auto inside = std::upper_bound(corners_.begin(), corners_.end(), begin);  // strictly
      for (auto corner = inside; isAlike && corner != corners_.end() && *corner < end; ++corner)
        isAlike = areAlike(entry, from(*corner)) && isAlikeBelow(entry, before(*corner));
    }
    if (isAlike || isFirst || isLast || !isFoot(bin, begin, end)) return isAlike;
    entry = {};
    return true;
  }

  /// Tells a bin apart further; true if it shows something.
  bool refineBin(int bin) {
    const auto [begin, end] = extentsOf(bin);
    const size_t first = pieces_.size();
    double left = begin;
    for (auto corner = std::upper_bound(corners_.begin(), corners_.end(), begin);
         corner != corners_.end() && *corner < end; ++corner) {
      if (left < *corner) addPieces(left, *corner);
      left = *corner;
    }
    addPieces(left, end);
    table_.refinements.push_back({static_cast<int32_t>(first), static_cast<int32_t>(pieces_.size() - first)});
    table_.alphas[static_cast<size_t>(bin)] = -static_cast<float>(table_.refinements.size());
    return std::any_of(pieces_.begin() + static_cast<std::ptrdiff_t>(first), pieces_.end(), isShown);
  }

  /// The most and the least opacity of a unit in [left, right), what is come to from below included, and whether it has steps there.
  struct Extent {
    float least = 1.0f, most = 0.0f;
    float mostOfStep = 0.0f;  ///< opacity of the table's step
    bool hasStep = false;
  };
  Extent extentOf(double left, double right) const {
    Extent extent;
    const auto include = [&](const Entry& entry) {
      extent.least = std::min(extent.least, entry.unitAlpha);
      extent.most = std::max(extent.most, entry.unitAlpha);
      extent.mostOfStep = std::max(extent.mostOfStep, entry.color.a);
    };
    include(from(left));
    include(before(right));
    for (auto corner = std::upper_bound(corners_.begin(), corners_.end(), left); corner != corners_.end() && *corner < right; ++corner) {
      const Entry above = from(*corner), below = before(*corner);
      include(above);
      include(below);
      extent.hasStep = extent.hasStep || above.unitAlpha != below.unitAlpha;
    }
    return extent;
  }

  /// The foot of a ramp, in a bin that is neither the first nor the last: it rises out of nothing, by hardly anything, and goes on in the next bin.
  bool isFoot(int bin, double begin, double end) const {
    if (from(begin).unitAlpha > 0.0f) return false;
    const Extent foot = extentOf(begin, end);
    if (foot.hasStep || foot.most > TransferTable::kLeastShown || foot.mostOfStep > TransferTable::kMostVariation) return false;
    if (!(before(end).unitAlpha > 0.0f)) return false;
    const bool isLastNext = bin + 1 == bins_.count() - 1;
    const Extent next = isLastNext ? Extent{from(bins_.upper).unitAlpha} : extentOf(end, bins_.border(bin + 1));
    return next.least > 0.0f && from(end).unitAlpha > 0.0f;
  }

  /// Pieces of [left, right), where the function is linear.
  void addPieces(double left, double right) {
    const Entry first = from(left), last = before(right);
    // Beyond the ends the function is constant.
    const double middle = std::isfinite(left) && std::isfinite(right) ? left + (right - left) / 2 : std::numeric_limits<double>::infinity();
    const auto cut = static_cast<double>(static_cast<float>(middle));
    const bool isDivisible = std::isfinite(middle) && cut > static_cast<double>(roundedUp(left)) && cut < right;
    if (isDivisible && !areAlike(first, last)) {
      addPieces(left, cut);
      addPieces(cut, right);
      return;
    }
    // A piece that is no further divisible holds but one float, beyond the ends the function is constant.
    if (!std::isfinite(left))
      pieces_.push_back(last);
    else if (std::isfinite(right) && isDivisible)
      pieces_.push_back(from(middleOf(left, right)));
    else
      pieces_.push_back(from(roundedUp(left)));
    table_.begins.push_back(std::isfinite(left) ? roundedUp(left) : -std::numeric_limits<float>::infinity());
  }

  /// Where a bin or piece is looked at: at a whole number if it holds one that may be looked up, else in its middle.
  double middleOf(double left, double right) const {
    const double whole = std::ceil(left);
    return bins_.perWhole > 0 && whole < right ? whole : left + (right - left) / 2;
  }

  const TransferFunction& function_;
  const Bins bins_;
  std::vector<float> corners_;         // the function's, as floats, each once
  std::vector<double> cornerValues_;  // as they were written
  std::vector<Entry> pieces_;
  TransferTable table_;
};

}  // namespace

TransferLookup TransferTable::lookup() const {
  TransferLookup lookup;
  lookup.entries = entries.data();
  lookup.alphas = alphas.data();
  lookup.unitAlphas = unitAlphas.data();
  lookup.refinements = refinements.data();
  lookup.isRefined = !refinements.empty();
  lookup.begins = begins.data();
  lookup.scale = scale;
  lookup.offset = offset;
  lookup.bins = bins;
  return lookup;
}

void TransferTable::countVisible() {
  visibleBefore.assign(1, 0);
  for (const float alpha : alphas) visibleBefore.push_back(visibleBefore.back() + (alpha > 0.0f ? 1 : 0));
}

bool TransferTable::anyVisible(float lowest, float highest) const {
  if (!(lowest <= highest)) return false;
  const TransferLookup table = lookup();
  const int first = table.binOf(lowest), last = table.binOf(highest);
  const auto at = [](int i) { return static_cast<size_t>(i); };
  if (last - first > 1 && visibleBefore[at(last)] > visibleBefore[at(first) + 1]) return true;
  // Of the bins at the ends those pieces that are within.
  for (const int bin : {first, last}) {
    if (visibleBefore[at(bin) + 1] == visibleBefore[at(bin)]) continue;
    if (!(alphas[at(bin)] < 0.0f)) return true;
    const TransferRefinement& all = refinements[at(static_cast<int>(-alphas[at(bin)]) - 1)];
    const int begin = bin == first ? table.refined(alphas[at(bin)], lowest) : bins + all.first;
    const int end = bin == last ? table.refined(alphas[at(bin)], highest) + 1 : bins + all.first + all.count;
    for (int entry = begin; entry < end; ++entry)
      if (alphas[at(entry)] > 0.0f) return true;
  }
  return false;
}

TransferTable bakeTransferTable(const TransferFunction& function, const TransferDomain& domain, float step) {
  return TableBaking(function, domain, step).bake();
}

}  // namespace warpscope
