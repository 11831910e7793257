// What FLIP does with one pixel, or a vector of them, on host and device: colour spaces, differences of colours and of features.
// Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astroem, Fairchild 2020, "FLIP: A difference evaluator for alternating images", sections 4.1.2 to
// 4.3; see flip.h. The paper's YCxCz is kept without its factors and offset, which the filters between pass through: (Y/Yn, X/Xn - Y/Yn,
// Y/Yn - Z/Zn).
#pragma once

#include "render/core/numeric.h"

namespace warpscope {

template <class Real>
struct Triple {
  Real x, y, z;
};

struct FlipMatrix {
  float row[3][3];
};

struct FlipMatrices {
  FlipMatrix relativeFromRgb;  ///< linear RGB of the sRGB primaries to XYZ relative to that of RGB (1, 1, 1)
  FlipMatrix rgbFromRelative;
};

WARPSCOPE_HD constexpr FlipMatrices flipMatrices() {
  double m[3][3] = {{10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0},
                    {2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0},
                    {1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0}};
  for (auto& row : m) {
    const double white = row[0] + row[1] + row[2];
    for (double& value : row) value /= white;
  }
  const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  FlipMatrices matrices{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      matrices.relativeFromRgb.row[i][j] = static_cast<float>(m[i][j]);
      // Cofactors with cyclic indices carry their signs themselves.
      const double cofactor = m[(j + 1) % 3][(i + 1) % 3] * m[(j + 2) % 3][(i + 2) % 3] - m[(j + 1) % 3][(i + 2) % 3] * m[(j + 2) % 3][(i + 1) % 3];
      matrices.rgbFromRelative.row[i][j] = static_cast<float>(cofactor / determinant);
    }
  return matrices;
}

template <class Real>
WARPSCOPE_HD inline Triple<Real> transformed(const FlipMatrix& m, const Triple<Real>& v) {
  return {Real(m.row[0][0]) * v.x + Real(m.row[0][1]) * v.y + Real(m.row[0][2]) * v.z,
          Real(m.row[1][0]) * v.x + Real(m.row[1][1]) * v.y + Real(m.row[1][2]) * v.z,
          Real(m.row[2][0]) * v.x + Real(m.row[2][1]) * v.y + Real(m.row[2][2]) * v.z};
}

/// Linear RGB to opponent colours: lightness, red-green, blue-yellow.
template <class Real>
WARPSCOPE_HD inline Triple<Real> opponentOf(const Triple<Real>& rgb) {
  constexpr FlipMatrices kMatrices = flipMatrices();
  const Triple<Real> v = transformed(kMatrices.relativeFromRgb, rgb);
  return {v.y, v.x - v.y, v.y - v.z};
}

template <class Real>
WARPSCOPE_HD inline Real labCurve(const Real& t) {
  constexpr float kDelta = 6.0f / 29.0f;
  return selected(t > Real(kDelta * kDelta * kDelta), cbrtOf(t), t * Real(1.0f / (3.0f * kDelta * kDelta)) + Real(4.0f / 29.0f));
}

/// CIELAB with the Hunt effect of linear RGB 0..1: lightness, a, b.
template <class Real>
WARPSCOPE_HD inline Triple<Real> huntLabOfRgb(const Triple<Real>& rgb) {
  constexpr FlipMatrices kMatrices = flipMatrices();
  const Triple<Real> v = transformed(kMatrices.relativeFromRgb, rgb);
  const Real fx = labCurve(v.x), fy = labCurve(v.y), fz = labCurve(v.z);
  const Real lightness = Real(116.0f) * fy - Real(16.0f);
  return {lightness, Real(5.0f) * lightness * (fx - fy), Real(2.0f) * lightness * (fy - fz)};
}

/// Of opponent colours, brought into the range of RGB.
template <class Real>
WARPSCOPE_HD inline Triple<Real> huntLabOf(const Triple<Real>& opponent) {
  constexpr FlipMatrices kMatrices = flipMatrices();
  const Triple<Real> rgb =
      transformed(kMatrices.rgbFromRelative, Triple<Real>{opponent.x + opponent.y, opponent.x, opponent.x - opponent.z});
  return huntLabOfRgb(Triple<Real>{saturated(rgb.x), saturated(rgb.y), saturated(rgb.z)});
}

/// HyAB: distance of lightness and distance of colour, to the power of the paper.
template <class Real>
WARPSCOPE_HD inline Real colorDistance(const Triple<Real>& p, const Triple<Real>& q) {
  const Real a = p.y - q.y, b = p.z - q.z;
  return powOf(absOf(p.x - q.x) + sqrtOf(a * a + b * b), Real(0.7f));
}

/// How distances of colours become differences of 0..1: those up to 0.4 of the largest take 0.95 of the range.
struct ColorRange {
  float knee;            ///< distance
  float below, above;    ///< slopes
};

inline ColorRange flipColorRange() {
  // The largest distance that two colours have is that of green and blue.
  const float largest = colorDistance(huntLabOfRgb(Triple<float>{0.0f, 1.0f, 0.0f}), huntLabOfRgb(Triple<float>{0.0f, 0.0f, 1.0f}));
  const float knee = 0.4f * largest;
  return {knee, 0.95f / knee, 0.05f / (largest - knee)};
}

template <class Real>
WARPSCOPE_HD inline Real colorDifference(const ColorRange& range, const Triple<Real>& p, const Triple<Real>& q) {
  const Real distance = colorDistance(p, q);
  return selected(distance < Real(range.knee), distance * Real(range.below), Real(0.95f) + (distance - Real(range.knee)) * Real(range.above));
}

/// Of strengths of edges and of points.
template <class Real>
WARPSCOPE_HD inline Real featureDifference(const Real& edgeA, const Real& pointA, const Real& edgeB, const Real& pointB) {
  return sqrtOf(maxOf(absOf(edgeA - edgeB), absOf(pointA - pointB)) * Real(0.70710678f));
}

/// FLIP of a pixel, 0..1.
template <class Real>
WARPSCOPE_HD inline Real flipOf(const Real& color, const Real& feature) {
  return selected(color > Real(0.0f), saturated(powOf(color, Real(1.0f) - feature)), Real(0.0f));
}

}  // namespace warpscope
