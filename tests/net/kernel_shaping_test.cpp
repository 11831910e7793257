// The model's rate against the kernel's own: datagrams through a token bucket (tc-tbf) on a veth pair between two network namespaces.
// Mirrors net/link_model.h. Skipped, visibly, where namespaces or the bucket cannot be made.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include "net/link_model.h"

namespace warpscope::net {
namespace {

using MachineClock = std::chrono::steady_clock;

constexpr double kRateBitPerS = 20e6, kBurstBytes = 16'000;
constexpr size_t kPayloadBytes = 1400, kHeaderBytes = 14 + 20 + 8;  // Ethernet, IPv4, UDP: the bucket counts them all
constexpr int kDatagrams = 800;                                     // about half a second
constexpr uint16_t kPort = 4711;

/// The processes that are in the namespaces end through these; what they say goes to the test.
[[noreturn]] void stop(int report, const std::string& sentence) {
  [[maybe_unused]] const ssize_t written = write(report, sentence.data(), sentence.size());
  std::_Exit(0);
}

void requireShell(int report, const std::string& command) {
  if (std::system(("{ " + command + "; } >/dev/null 2>&1").c_str()) != 0) stop(report, "skip: '" + command + "' failed");
}

sockaddr_in addressOf(const char* text) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(kPort);
  inet_pton(AF_INET, text, &address.sin_addr);
  return address;
}

/// In its own network: tells when it is ready, takes datagrams, and reports when each came, in microseconds after the first.
[[noreturn]] void receive(int report, std::array<int, 2> readyPipe, std::array<int, 2> goPipe) {
  close(readyPipe[0]);
  close(goPipe[1]);  // or it would wait for itself
  const int ready = readyPipe[1], go = goPipe[0];
  if (unshare(CLONE_NEWNET) != 0) stop(report, "skip: no second network namespace: " + std::string(std::strerror(errno)));
  char byte = 'r';
  if (write(ready, &byte, 1) != 1 || read(go, &byte, 1) != 1) std::_Exit(1);
  requireShell(report, "ip address add 10.177.0.2/24 dev wsb && ip link set wsb up");
  const int descriptor = socket(AF_INET, SOCK_DGRAM, 0);
  const sockaddr_in address = addressOf("10.177.0.2");
  const timeval limit{2, 0};
  setsockopt(descriptor, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  if (bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) stop(report, "failed: bind");
  if (write(ready, &byte, 1) != 1) std::_Exit(1);
  std::string arrivals;
  MachineClock::time_point first;
  std::array<char, 2000> buffer;
  for (int i = 0; i < kDatagrams; ++i) {
    if (recv(descriptor, buffer.data(), buffer.size(), 0) < 0) stop(report, "lost: datagram " + std::to_string(i) + " did not come");
    if (i == 0) first = MachineClock::now();
    arrivals += std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(MachineClock::now() - first).count()) + "\n";
  }
  stop(report, arrivals);
}

void becomeRootOfNewNamespaces(int report) {
  const std::string uid = std::to_string(geteuid()), gid = std::to_string(getegid());
  const bool isRoot = geteuid() == 0;
  if (unshare(isRoot ? CLONE_NEWNET : CLONE_NEWUSER | CLONE_NEWNET) != 0)
    stop(report, "skip: no network namespace: " + std::string(std::strerror(errno)));
  if (isRoot) return;
  std::ofstream("/proc/self/setgroups") << "deny";
  std::ofstream("/proc/self/uid_map") << "0 " << uid << " 1";
  std::ofstream("/proc/self/gid_map") << "0 " << gid << " 1";
}

/// Sends as fast as the bucket lets it: the socket's small buffer makes it wait instead of losing datagrams.
[[noreturn]] void sendThroughBucket(int report) {
  becomeRootOfNewNamespaces(report);
  std::array<int, 2> ready, go;
  if (pipe(ready.data()) != 0 || pipe(go.data()) != 0) std::_Exit(1);
  const pid_t receiver = fork();
  if (receiver == 0) receive(report, ready, go);
  close(ready[1]);
  close(report);
  char byte;
  if (read(ready[0], &byte, 1) != 1) std::_Exit(0);  // it has said why
  const std::string rate = std::to_string(static_cast<int>(kRateBitPerS)) + "bit", burst = std::to_string(static_cast<int>(kBurstBytes));
  const std::string command = "ip link add wsa type veth peer name wsb && ip link set wsb netns " + std::to_string(receiver) +
                              " && ip address add 10.177.0.1/24 dev wsa && ip link set wsa up && tc qdisc add dev wsa root tbf rate " + rate +
                              " burst " + burst + " limit 1000000";
  if (std::system(("{ " + command + "; } >/dev/null 2>&1").c_str()) != 0) std::_Exit(77);  // the receiver sees the pipe close
  if (write(go[1], "g", 1) != 1 || read(ready[0], &byte, 1) != 1) std::_Exit(0);

  const int descriptor = socket(AF_INET, SOCK_DGRAM, 0);
  const int bufferBytes = 100'000;
  setsockopt(descriptor, SOL_SOCKET, SO_SNDBUF, &bufferBytes, sizeof bufferBytes);
  const sockaddr_in address = addressOf("10.177.0.2");
  const std::string payload(kPayloadBytes, 'x');
  for (int i = 0; i < kDatagrams; ++i)
    sendto(descriptor, payload.data(), payload.size(), 0, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  waitpid(receiver, nullptr, 0);
  std::_Exit(0);
}

/// Microseconds after the first datagram, or why there are none.
std::string arrivalsThroughKernel() {
  std::array<int, 2> report;
  if (pipe(report.data()) != 0) return "skip: no pipe";
  const pid_t sender = fork();
  if (sender == 0) {
    close(report[0]);
    sendThroughBucket(report[1]);
  }
  close(report[1]);
  std::string text;
  std::array<char, 4096> piece;
  ssize_t count;
  while ((count = read(report[0], piece.data(), piece.size())) > 0) text.append(piece.data(), static_cast<size_t>(count));
  close(report[0]);
  int status = 0;
  waitpid(sender, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 77 ? "skip: veth or tbf cannot be made here" : text;
}

/// The rate in Mbit/s: the median of many stretches, since a busy machine is late now and then. The first ones belong to the burst.
double rateOf(const std::vector<double>& arrivalsMs) {
  constexpr size_t kBegin = 50, kStretch = 400;
  std::vector<double> rates;
  for (size_t i = kBegin; i + kStretch < arrivalsMs.size(); ++i) {
    const double bits = kStretch * (kPayloadBytes + kHeaderBytes) * 8;
    rates.push_back(bits / (arrivalsMs[i + kStretch] - arrivalsMs[i]) / 1000);
  }
  std::nth_element(rates.begin(), rates.begin() + static_cast<ptrdiff_t>(rates.size() / 2), rates.end());
  return rates[rates.size() / 2];
}

/// Through the kernel, in ms after the first; empty, with the reason, if there are none.
std::vector<double> kernelArrivalsMs(std::string& report) {
  report.clear();
  for (int i = 0; i < 3 && (report.empty() || report.starts_with("lost: ")); ++i) report = arrivalsThroughKernel();
  std::vector<double> arrivalsMs;
  for (size_t at = 0; at < report.size() && std::isdigit(report[at]); at = report.find('\n', at) + 1)
    arrivalsMs.push_back(std::stod(report.substr(at)) / 1000);
  return arrivalsMs;
}

TEST(KernelShaping, TheModelPassesAsMuchAsTheKernel) {
  LinkSettings settings;
  settings.rateBitPerS = kRateBitPerS;
  settings.burstBytes = kBurstBytes;
  const LinkModel::TimePoint start{std::chrono::seconds(1)};
  LinkModel model(settings, start);
  std::vector<double> modelMs;
  for (int i = 0; i < kDatagrams; ++i) {
    const auto arrival = model.arrivalOf(kPayloadBytes + kHeaderBytes, start);
    modelMs.push_back(std::chrono::duration<double, std::milli>(arrival - start).count());
  }
  const double modelMbit = rateOf(modelMs);
  // The kernel's timers are late on a busy machine, and its bucket then gives more at once: one of a few tries has to agree.
  std::string report;
  std::vector<double> kernelMs;
  double kernelMbit = 0.0;
  for (int i = 0; i < 5 && std::abs(modelMbit - kernelMbit) > 0.02 * modelMbit; ++i) {
    kernelMs = kernelArrivalsMs(report);
    if (report.starts_with("skip: ")) GTEST_SKIP() << report.substr(6);
    ASSERT_EQ(kernelMs.size(), static_cast<size_t>(kDatagrams)) << report;
    kernelMbit = rateOf(kernelMs);
  }
  RecordProperty("kernelMbit", std::to_string(kernelMbit));
  RecordProperty("modelMbit", std::to_string(modelMbit));
  EXPECT_NEAR(modelMbit, kernelMbit, modelMbit * 0.02);

  // What both let through before they begin to wait; told, not judged: the kernel's sender may be interrupted in between.
  const auto burst = [](const std::vector<double>& arrivalsMs) {
    return static_cast<int>(std::count_if(arrivalsMs.begin(), arrivalsMs.end(), [](double ms) { return ms < 0.3; }));
  };
  RecordProperty("kernelBurst", burst(kernelMs));
  RecordProperty("modelBurst", burst(modelMs));
}

}  // namespace
}  // namespace warpscope::net
