// What a sweep measured: one row for each configuration and angle, or link.
// Rows are what sweep.csv and sweep.json hold, what a sweep that was interrupted goes on from, and what `auto` chooses by.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "app/experiment/configuration.h"
#include "app/experiment/measured.h"
#include "render/metrics/picture_errors.h"

namespace warpscope {

/// What a configuration takes, however often it is drawn. Work that several share is charged to each. Zeroes for what needs no frame.
struct SweepCost {
  size_t samples = 0;
  size_t bytes = 0;  ///< of the frame on the wire; for `hold` those of its picture alone
  Measured march, compact, copy, encode;  ///< at the server
  Measured decode, build, upload;         ///< at the client, once a frame; see measuring.h

  double serverMs() const { return march.medianMs + compact.medianMs + copy.medianMs + encode.medianMs; }
  double arrivalMs() const { return decode.medianMs + upload.medianMs + build.medianMs; }
};

/// One configuration, either with the camera turned by an angle or with a camera that moves behind a link.
struct SweepRow {
  Configuration configuration;
  std::string link;              ///< empty where the camera stands still
  double angleDeg = 0.0;         ///< between the frame's camera and the view; behind a link the mean of it
  double ageMs = 0.0;            ///< behind a link: how old the frame's camera is when its picture is shown, the mean
  double framesPerSecond = 0.0;  ///< behind a link: frames that arrive
  std::optional<double> flicker; ///< behind a link: between two pictures of a display that shows 60 a second (metrics/flicker.h), the mean
  PictureErrors errors;          ///< behind a link: means
  std::optional<double> disoccludedFraction;  ///< of what the view shows, what the frame's camera could not see; not behind a link
  SweepCost cost;
  Measured draw;
  int draws = 0;

  /// From bytes at the client to the first picture of a frame: what one picture costs if every frame is new.
  double frameMs() const { return cost.arrivalMs() + draw.medianMs; }
};

/// How far marching itself is from the truth: the ground truth against one of half its step.
struct SweepFloor {
  double angleDeg = 0.0;
  PictureErrors errors;
};

/// What warps of one frame could reach at an angle: oracle.h.
struct SweepBound {
  enum class Kind { bestDot, perfectWarp };
  Kind kind = Kind::bestDot;
  double angleDeg = 0.0;
  PictureErrors errors;
};
/// "best-dot", and as a person reads it.
std::string_view nameOf(SweepBound::Kind kind);
std::string_view labelOf(SweepBound::Kind kind);

nlohmann::json toJson(const SweepRow& row);
nlohmann::json toJson(const SweepBound& bound);
nlohmann::json toJson(const SweepFloor& floor);
nlohmann::json toJson(const PictureErrors& errors);
/// Back; see configurationFrom. Throws InputError.
SweepRow sweepRowFrom(const Node& node, const MarchSettings& base);
/// Of an array of rows, which must not be empty.
std::vector<SweepRow> sweepRowsFrom(const Node& rows, const MarchSettings& base);

/// A table with a head line (RFC 4180); empty where a value does not exist.
std::string csvOf(const std::vector<SweepRow>& rows);

}  // namespace warpscope
