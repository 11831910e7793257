// Asio's timer, and the alarm that stands in for it where time is moved by hand.
// See timer.h. Services of a context: Boost.Asio documentation, execution_context.
#include "net/timer.h"

namespace warpscope::net {
namespace {

class ClockService final : public asio::execution_context::service {
 public:
  using key_type = ClockService;
  static inline asio::execution_context::id id;

  explicit ClockService(asio::execution_context& context, Clock& clock = steadyClock()) : service(context), clock_(clock) {}

  Clock& clock() const { return clock_; }

 private:
  void shutdown() override {}

  Clock& clock_;
};

}  // namespace

void setClock(asio::execution_context& context, Clock& clock) { asio::make_service<ClockService>(context, clock); }

Clock& clockOf(const asio::any_io_executor& executor) { return asio::use_service<ClockService>(executor.context()).clock(); }

struct Timer::State : std::enable_shared_from_this<State> {
  explicit State(const asio::any_io_executor& executor) : timer(executor), clock(clockOf(executor)) {}
  ~State() { forgetAlarm(); }

  void setTo(TimePoint time) {
    forgetAlarm();
    ++round;
    hasCome = false;
    if (time != TimePoint::max()) {
      alarm = clock.callAt(time, [executor = timer.get_executor(), weak = weak_from_this(), expected = round] {
        asio::post(executor, [weak, expected] {
          if (const std::shared_ptr<State> self = weak.lock()) self->ring(expected);
        });
      });
    }
    timer.expires_at(alarm ? TimePoint::max() : time);
  }
  void forgetAlarm() {
    if (alarm) clock.forget(*std::exchange(alarm, std::nullopt));
  }
  void ring(uint64_t of) {
    if (of != round) return;  // it was set to another time since
    hasCome = true;
    timer.cancel();
  }

  asio::steady_timer timer;
  Clock& clock;
  std::optional<Clock::AlarmId> alarm;  // where the clock has them
  uint64_t round = 0;                   // how often it was set
  bool hasCome = false;                 // by the alarm
};

Timer::Timer(const asio::any_io_executor& executor, TimePoint time) : state_(std::make_shared<State>(executor)) { state_->setTo(time); }

Timer::~Timer() {
  state_->forgetAlarm();
  cancel();
}

Clock& Timer::clock() const { return state_->clock; }
void Timer::setTo(TimePoint time) { state_->setTo(time); }

void Timer::cancel() noexcept {
  error_code ignored;
  state_->timer.cancel(ignored);
}

Awaitable<void> Timer::wait() {
  const std::shared_ptr<State> state = state_;  // which may go meanwhile
  if (state->hasCome) co_return;
  error_code ignored;
  co_await state->timer.async_wait(into(ignored));
}

void Timer::onEnd(std::function<void(bool)> then) {
  if (state_->hasCome) {
    asio::post(state_->timer.get_executor(), [then = std::move(then)] { then(true); });
    return;
  }
  state_->timer.async_wait([state = state_, then = std::move(then)](const error_code& error) { then(!error || state->hasCome); });
}

}  // namespace warpscope::net
