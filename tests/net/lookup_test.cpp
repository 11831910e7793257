// Names that are looked up: answers, failures, and resolvers that take longer than anybody waits.
// Mirrors lookup.h, ClientSettings::resolver and the ends of those who wait.
#include "net/lookup.h"

#include "tests/net/exchange.h"
#include "tests/net/io_test.h"

namespace warpscope::net {
namespace {

using Addresses = std::vector<asio::ip::address>;
using testing::ElementsAre;

/// A resolver that does not come back until it is let go; there may be several calls.
class Stuck {
 public:
  Stuck() : state_(std::make_shared<State>()) {}
  /// Its threads have ended afterwards, all but their last steps.
  ~Stuck() {
    letGo();
    comesTrue([&] { return state_->inside == 0; });
  }

  Resolver resolver() const {
    return [state = state_](const std::string&) {
      ++state->inside;
      std::unique_lock lock(state->mutex);
      state->changed.wait(lock, [&] { return state->isLetGo; });
      --state->inside;
      return Addresses{asio::ip::make_address("127.0.0.1")};
    };
  }
  void letGo() {
    {
      const std::scoped_lock lock(state_->mutex);
      state_->isLetGo = true;
    }
    state_->changed.notify_all();
  }
  bool waitForCall() const { return comesTrue([&] { return state_->inside > 0; }); }

 private:
  struct State {
    std::mutex mutex;
    std::condition_variable changed;
    bool isLetGo = false;
    std::atomic<int> inside{0};
  };
  std::shared_ptr<State> state_;
};

class LookupTest : public IoTest {};

TEST_F(LookupTest, FindsNames) {
  run([&]() -> Awaitable<> {
    const Addresses found = co_await lookUp(io_.get_executor(), "localhost", never(), resolveBySystem);
    EXPECT_FALSE(found.empty());
    for (const asio::ip::address& address : found) EXPECT_TRUE(address.is_loopback());
  });
}

TEST_F(LookupTest, AnswersComeInTheResolversOrder) {
  const Addresses expected{asio::ip::make_address("::1"), asio::ip::make_address("127.0.0.2")};
  run([&]() -> Awaitable<> {
    std::string asked;
    const Addresses found = co_await lookUp(io_.get_executor(), "some.name", never(), [&](const std::string& host) {
      asked = host;
      return expected;
    });
    EXPECT_EQ(found, expected);
    EXPECT_EQ(asked, "some.name");
  });
}

TEST_F(LookupTest, AddressesAreNotLookedUp) {
  run([&]() -> Awaitable<> {
    for (const std::string text : {"127.0.0.1", "::1"}) {
      const Addresses found = co_await lookUp(io_.get_executor(), text, never(), [](const std::string&) -> Addresses {
        ADD_FAILURE() << "nobody need be asked";
        return {};
      });
      EXPECT_THAT(found, ElementsAre(asio::ip::make_address(text)));
    }
  });
}

TEST_F(LookupTest, FailuresSayOfWhat) {
  run([&]() -> Awaitable<> {
    const Resolver unknown = [](const std::string&) -> Addresses { throw system_error(asio::error::host_not_found); };
    const Thrown none = co_await failureOf(lookUp(io_.get_executor(), "no.name", never(), unknown));
    EXPECT_EQ(none.code, asio::error::host_not_found);
    EXPECT_THAT(none.text, HasSubstr("cannot look up 'no.name': "));
    const Thrown empty = co_await failureOf(lookUp(io_.get_executor(), "no.name", never(), [](const std::string&) { return Addresses{}; }));
    EXPECT_EQ(empty.code, asio::error::host_not_found);
    const Resolver broken = [](const std::string&) -> Addresses { throw std::bad_alloc(); };
    const Thrown other = co_await failureOf(lookUp(io_.get_executor(), "no.name", never(), broken));
    EXPECT_EQ(other.code, asio::error::no_recovery);
  });
}

TEST_F(LookupTest, ADeadlineDoesNotWaitForTheResolver) {
  const Stuck stuck;
  Thrown failure;
  spawn([&]() -> Awaitable<> {
    failure = co_await failureOf(lookUp(io_.get_executor(), "slow.name", inTime(milliseconds(50)), stuck.resolver()));
  });
  run([&]() -> Awaitable<> {
    co_await pass(milliseconds(49));
    EXPECT_TRUE(failure.text.empty()) << "not before its time";
    co_await pass(milliseconds(1));
  });
  EXPECT_TRUE(failure.isDeadline);
  EXPECT_THAT(failure.text, HasSubstr("looking up 'slow.name'"));
}

/// The io_context goes while the resolver is at work, and as it comes back: its thread touches nothing that is gone.
TEST(Lookup, TheResolverOutlastsWhoeverAsked) {
  for (int round = 0; round < 100; ++round) {
    Stuck stuck;
    auto io = std::make_unique<asio::io_context>(1);
    asio::co_spawn(*io, [&]() -> Awaitable<> { co_await lookUp(io->get_executor(), "slow.name", never(), stuck.resolver()); },
                   asio::detached);
    io->poll();
    ASSERT_TRUE(stuck.waitForCall());
    if (round % 2 == 0) {
      const std::jthread letsGo([&] { stuck.letGo(); });
      io.reset();
    } else {
      io.reset();
    }
  }
}

/// It ends at all: the resolver comes back only afterwards, and the clock stands still.
TEST(Lookup, AClientAndItsThreadEndBeforeTheResolver) {
  VirtualClock clock;
  const Stuck stuck;
  for (const bool hasThread : {true, false}) {
    Witness witness;
    ClientSettings settings;
    settings.address = parseAddress("warp://slow.name:1");
    settings.resolver = stuck.resolver();
    auto io = std::make_shared<IoThread>(clock);
    std::optional<Client> client(std::in_place, io, settings, witness);
    ASSERT_TRUE(stuck.waitForCall());
    if (hasThread) io.reset();  // then it goes with the client
    client.reset();
    io.reset();
  }
}

TEST(Lookup, AClientConnectsToWhatTheResolverSays) {
  const auto io = std::make_shared<IoThread>();
  ServerSettings served;
  served.scene = someScene();
  const Server server(io, served);
  Stuck stuck;
  Witness witness;
  ClientSettings settings;
  settings.address.where = {"slow.name", server.port()};
  settings.resolver = stuck.resolver();
  const Client client(io, settings, witness);
  ASSERT_TRUE(stuck.waitForCall());
  stuck.letGo();
  EXPECT_TRUE(witness.waitForConnection());
}

}  // namespace
}  // namespace warpscope::net
