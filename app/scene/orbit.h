// What dragging and scrolling over a picture do to a view.
// Distances on the screen come as fractions of the picture's height, so that they mean the same at every content scale.
#pragma once

#include "app/scene/scene.h"

namespace warpscope {

/// Turns the camera about the point it looks at, as if that were dragged along. A drag over the whole height turns it by half a turn.
View orbited(View view, const glm::dvec2& dragHeights);

/// Moves the point looked at, so that what is at the volume's depth follows the pointer. `widthOverHeight` is the picture's.
View panned(View view, double fovYDeg, double widthOverHeight, const glm::dvec2& dragHeights);

/// Nearer for positive notches of a wheel.
View zoomed(View view, double notches);

}  // namespace warpscope
