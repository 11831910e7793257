// Threads, and a NewestWorker's above all, whose loops run on a crew.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <type_traits>
#include <utility>

#include "render/core/crew.h"

namespace warpscope {

/// From then on the thread that made it stands back by `nice` (Crew::standBack), and so do those that it starts; while there is one, its loops run on `crew`. Null: as it is.
class WorkOnCrew {
 public:
  WorkOnCrew(Crew* crew, int nice) : shift_(crew) {
    if (crew != nullptr) Crew::standBack(nice);
  }

 private:
  const Crew::Shift shift_;
};

/// A new crew where loops of the calling thread run on one: for work that must not wait for what that one is at. Null where they run on all cores.
inline std::shared_ptr<Crew> ownCrewBesideThisThreads(int nice) { return Crew::ofThisThread() != nullptr ? std::make_shared<Crew>(0, nice) : nullptr; }

/// What `make` makes, for a NewestWorker whose thread works on the crew so. Null: as it is.
template <class Make>
auto workOfCrew(Make make, std::shared_ptr<Crew> crew, int nice) {
  using Work = std::invoke_result_t<Make&>;
  return [make = std::move(make), crew = std::move(crew), nice]() mutable -> Work {
    if (!crew) return make();
    const WorkOnCrew making(crew.get(), nice);
    return [work = make(), crew](const auto& job, auto& result, const std::stop_token& stop) {
      const Crew::Shift one(crew.get());
      work(job, result, stop);
    };
  };
}

}  // namespace warpscope
