// Times the panels' pictures when everything has come to rest, one panel after the other, so that what is measured runs alone.
#pragma once

#include <optional>
#include <span>

#include "app/session/live_panel.h"

namespace warpscope {

class PictureTiming {
 public:
  using TimePoint = Clock::TimePoint;

  /// `isAtRest`: nothing is under way, and what is on show is what was wanted and is judged. `happened`: something did just now, which is nothing
  /// to stop for but makes the quiet begin anew. After a while of quiet lets a panel time its picture, if it has not yet; the others wait.
  void update(std::span<LivePanel> panels, bool isAtRest, bool happened, TimePoint now);
  /// Whether there has been quiet for a while and no panel has its picture still to time: what is measured now runs alone, too.
  bool isOver(std::span<const LivePanel> panels, TimePoint now) const;
  /// Whether `panel` was timing its picture, which is over with this.
  bool finish(size_t panel);
  /// Gives up what is being timed.
  void stop(std::span<LivePanel> panels);
  /// Forgets what is being timed.
  void clear() { timing_.reset(); }

 private:
  TimePoint quietSince_{};        // when something happened last
  std::optional<size_t> timing_;  // the panel that times its picture
};

}  // namespace warpscope
