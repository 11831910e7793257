// Angles, distance, pan.
// See view_json.h.
#include "app/scene/view_json.h"

#include <vector>

#include "app/scene/json_document.h"

namespace warpscope {

View readView(const Node& node) {
  constexpr std::string_view kKeys[] = {"angleDeg", "elevationDeg", "distance", "pan"};
  node.requireObject(kKeys);
  View view;
  if (const auto angle = node.find("angleDeg")) view.angleDeg = angle->number(-360.0, 360.0);
  if (const auto elevation = node.find("elevationDeg")) view.elevationDeg = elevation->number(-90.0, 90.0);
  if (const auto distance = node.find("distance")) view.distance = distance->number(kViewDistanceRange.lowest, kViewDistanceRange.highest);
  if (const auto pan = node.find("pan")) {
    const std::vector<Node> elements = pan->elements(2, 2);
    view.pan = {elements[0].number(-kMostViewPan, kMostViewPan), elements[1].number(-kMostViewPan, kMostViewPan)};
  }
  return view;
}

nlohmann::json toJson(const View& view) {
  return {{"angleDeg", view.angleDeg}, {"elevationDeg", view.elevationDeg}, {"distance", view.distance}, {"pan", {view.pan.x, view.pan.y}}};
}

}  // namespace warpscope
