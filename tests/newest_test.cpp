// The hand-over between threads and the worker built on it: the newest wins, nothing queues up, everything ends when told to.
// Mirrors render/base/newest.h and render/base/newest_worker.h.
#include "render/base/newest.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <semaphore>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "render/base/newest_worker.h"

namespace warpscope {
namespace {

TEST(Newest, HoldsNothingAtFirst) {
  Newest<int> newest;
  EXPECT_FALSE(newest.hasValue());
  EXPECT_EQ(newest.tryTake(), std::nullopt);
}

TEST(Newest, GivesTheNewestOnce) {
  Newest<int> newest;
  newest.put(1);
  newest.put(2);
  newest.put(3);
  EXPECT_TRUE(newest.hasValue());
  EXPECT_EQ(newest.tryTake(), 3);
  EXPECT_EQ(newest.tryTake(), std::nullopt);
}

TEST(Newest, TakeReturnsWhenAskedToStop) {
  Newest<int> newest;
  std::optional<int> taken = 7;
  {
    std::jthread waiting([&](const std::stop_token& stop) { taken = newest.take(stop); });
    waiting.request_stop();
  }
  EXPECT_EQ(taken, std::nullopt);
}

TEST(Newest, PassesMoveOnlyValues) {
  Newest<std::unique_ptr<int>> newest;
  newest.put(std::make_unique<int>(5));
  const auto taken = newest.take({});
  ASSERT_TRUE(taken);
  EXPECT_EQ(**taken, 5);
}

TEST(Newest, NeverGoesBackBetweenThreads) {
  constexpr int kLast = 20000;
  Newest<int> newest;
  std::vector<int> taken;
  std::jthread consumer([&](const std::stop_token& stop) {
    while (const std::optional<int> value = newest.take(stop)) {
      taken.push_back(*value);
      if (*value == kLast) return;
    }
  });
  for (int i = 1; i <= kLast; ++i) newest.put(i);
  consumer.join();
  ASSERT_FALSE(taken.empty());
  EXPECT_EQ(taken.back(), kLast);
  EXPECT_TRUE(std::is_sorted(taken.begin(), taken.end()));
}

struct Answer {
  int value = 0;
  std::string error;
};

/// A worker whose jobs wait until they are let through.
class WorkerTest : public ::testing::Test {
 protected:
  using Worker = NewestWorker<int, Answer>;

  std::unique_ptr<Worker> makeWorker() {
    return std::make_unique<Worker>(
        [this]() -> Worker::Work {
          return [this](int job, Answer& answer, const std::stop_token& stop) {
            begun_.release();
            while (!gate_.try_acquire_for(std::chrono::milliseconds(1)))
              if (stop.stop_requested()) throw OperationCancelled();
            if (job < 0) throw std::runtime_error("less than nothing");
            answer.value = job;
          };
        },
        [this] { news_.release(); });
  }

  std::counting_semaphore<> begun_{0}, gate_{0}, news_{0};
};

TEST_F(WorkerTest, SkipsJobsThatWereReplacedMeanwhile) {
  const auto worker = makeWorker();
  worker->post(1);
  begun_.acquire();
  for (int job = 2; job <= 100; ++job) worker->post(job);
  gate_.release(2);
  news_.acquire();
  news_.acquire();
  const std::optional<Answer> answer = worker->tryTake();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->value, 100);
  begun_.acquire();
  EXPECT_FALSE(begun_.try_acquire());  // two jobs began in all
}

TEST_F(WorkerTest, TurnsExceptionsIntoText) {
  const auto worker = makeWorker();
  gate_.release();
  worker->post(-1);
  news_.acquire();
  EXPECT_EQ(worker->tryTake()->error, "less than nothing");
}

TEST_F(WorkerTest, CancelledJobsLeaveNothing) {
  const auto worker = makeWorker();
  worker->post(1);
  begun_.acquire();
  worker->post(2);
  worker->cancel();  // the one at work, and the one that waits
  worker->post(3);
  begun_.acquire();
  gate_.release();
  news_.acquire();
  EXPECT_EQ(worker->tryTake()->value, 3);
  EXPECT_EQ(worker->tryTake(), std::nullopt);
}

/// The worker has looked at the token for the last time, but its result is not there yet: it lets go of the job in between.
TEST(NewestWorker, AJobThatIsCancelledWhenItsWorkIsDoneLeavesNothing) {
  struct Job {
    int value;
    std::shared_ptr<void> onRelease;
  };
  using Worker = NewestWorker<Job, Answer>;
  std::counting_semaphore<> released(0), news(0);
  Worker worker([]() -> Worker::Work { return [](const Job& job, Answer& answer, const std::stop_token&) { answer.value = job.value; }; },
                [&] { news.release(); });
  const auto cancel = [&](int*) {
    worker.cancel();
    released.release();
  };
  static int anything = 0;
  worker.post({1, std::shared_ptr<void>(&anything, cancel)});
  released.acquire();
  worker.post({2, nullptr});
  news.acquire();
  EXPECT_EQ(worker.tryTake()->value, 2);
  EXPECT_FALSE(news.try_acquire());
}

/// What is kept goes whatever is cancelled after that, and a result that nobody took with it.
TEST(NewestWorkerForgets, EvenWhereAllIsCancelledAfterwards) {
  struct Answer {
    int value = 0;
    std::string error;
  };
  using Worker = NewestWorker<int, Answer>;
  std::counting_semaphore<> begun(0), mayEnd(0), forgotten(0), news(0);
  const auto work = [&](int job, Answer& answer, const std::stop_token&) {
    if (job == 0) return forgotten.release();
    if (job == 2) {
      begun.release();
      mayEnd.acquire();
    }
    answer.value = job;
  };
  Worker worker([&]() -> Worker::Work { return work; }, [&] { news.release(); });
  worker.post(1);
  news.acquire();
  worker.post(2);
  begun.acquire();
  worker.forget();
  worker.cancel();
  mayEnd.release();
  forgotten.acquire();
  EXPECT_FALSE(worker.tryTake());
  EXPECT_FALSE(forgotten.try_acquire());
  worker.post(3);
  news.acquire();
  EXPECT_EQ(worker.tryTake()->value, 3);
}

TEST_F(WorkerTest, EndsInTheMiddleOfAJob) {
  auto worker = makeWorker();
  worker->post(1);
  begun_.acquire();
  EXPECT_FALSE(worker->waitForEnd(std::chrono::steady_clock::now()));
  worker->requestStop();
  EXPECT_TRUE(worker->waitForEnd(std::chrono::steady_clock::now() + std::chrono::seconds(10)));
  worker.reset();
}

}  // namespace
}  // namespace warpscope
