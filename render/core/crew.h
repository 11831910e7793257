// Threads that work for somebody who must not be in the way: the system lets the program's first thread go before them.
// POSIX nice values, which Linux keeps for each thread (setpriority(2), "C library/kernel differences").
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>

namespace warpscope {

class Crew {
 public:
  /// While there is one, loops of the thread that made it (parallel.h) run on `crew`, which outlives it; null: on all cores, as ever.
  class Shift {
   public:
    explicit Shift(Crew* crew);
    ~Shift();
    Shift(const Shift&) = delete;
    Shift& operator=(const Shift&) = delete;

   private:
    Crew* const before_;
  };
  /// Null where loops run on all cores.
  static Crew* ofThisThread();
  /// While there is one, threads that stand back pause between two pieces of their loops, and where long pieces say, kMostPause at a time. For whoever wants the cores for a short while and at once: nice values share
  /// them fairly, but who wakes up waits until what runs has had its slice of time.
  class Break {
   public:
    Break();
    ~Break();
    Break(const Break&) = delete;
    Break& operator=(const Break&) = delete;
  };
  static constexpr std::chrono::milliseconds kMostPause{50};
  /// Returns when there is no break, or it has lasted long enough; at once for threads that do not stand back, among them who wants the break.
  static void pauseForBreaks() {
    if (breaks_.load(std::memory_order_relaxed) > 0) waitForBreaks();
  }

  /// Lets the program's first thread go before the calling one, and before those that it starts from now on, by so much at least.
  static void standBack(int nice);
  /// Whether it was called on this thread: those that it starts have its nice value only.
  static bool doesThisThreadStandBack();

  /// Nice values by which threads are behind the program's first: those that draw for the window behind the window's own, and marches behind these. Each step is
  /// a factor of 1.25 (sched(7)): the window's own thread, which wants little, has nine tenths of a core that pictures want as well; a march has three tenths beside them, and they do not
  /// wait for it. Less would let it stand still while pictures are drawn all the time; tests/bench/README.md has figures.
  static constexpr int kOfPictures = 9, kOfMarches = kOfPictures + 4;
  /// How many threads loops run on where nobody works with a crew: at least one.
  static size_t usualSize();
  /// So many threads, or `threads`.
  explicit Crew(size_t threads = 0, int nice = kOfMarches);
  ~Crew();
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  size_t size() const;

  /// Calls `body` on each of the threads at the same time, and returns when all calls have. One caller after the other. Throws what the first of them threw.
  void run(const std::function<void()>& body);

 private:
  static void waitForBreaks();

  static inline std::atomic<int> breaks_ = 0;
  struct State;
  const std::unique_ptr<State> state_;
};

}  // namespace warpscope
