// What one server does for many clients: frames a second in all, how evenly, how late, and how much memory a client takes. Run by hand, against a server of its own process.
// Every client looks around and asks for the next frame as soon as one has come; what comes is not decoded, so that the machine is the server's.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/experiment/configuration.h"
#include "app/frames/wire_fields.h"
#include "app/scene/scene.h"
#include "net/client.h"
#include "render/base/error.h"
#include "tests/bench/bench_main.h"

namespace warpscope {
namespace {

using namespace std::chrono_literals;

constexpr std::array<uint32_t, 4> kSidesPx{256, 512, 768, 1024};
constexpr double kDegreesAFrame = 3.0;
constexpr auto kSettling = 3s;

struct Sample {
  double latencyMs = 0.0, queueMs = 0.0, serverMs = 0.0;
  size_t bytes = 0;
};

/// Asks, takes and asks again.
class Onlooker final : public net::ClientEvents {
 public:
  Onlooker(std::shared_ptr<net::IoThread> io, const Scene& scene, const net::Address& address, uint32_t sidePx, double angleDeg, int segments, const CodecSettings& coding)
      : scene_(scene), coding_(coding), sidePx_(sidePx), angleDeg_(angleDeg) {
    march_ = scene.march;
    march_.sample.segments = segments;
    march_.sample.proxy = 0;
    net::ClientSettings settings;
    settings.address = address;
    client_ = std::make_unique<net::Client>(std::move(io), settings, *this);
    ask();
  }

  uint32_t sidePx() const { return sidePx_; }
  void setMeasuring(bool isMeasuring) { isMeasuring_ = isMeasuring; }
  std::vector<Sample> samples() const {
    const std::scoped_lock lock(mutex_);
    return samples_;
  }
  std::string trouble() const {
    const std::scoped_lock lock(mutex_);
    return trouble_;
  }
  void close() { client_->close(); }

 private:
  void ask() {
    View view = scene_.views.front();
    view.angleDeg = angleDeg_ += kDegreesAFrame;
    net::FrameRequest request;
    request.id = ++lastId_;
    request.camera = toFields(makeCamera(scene_, view, sidePx_, sidePx_));
    request.settings = toFields(march_);
    request.codec = toFields(coding_);
    client_->request(request);
  }

  void onState(const net::ConnectionState& state) override {
    if (state.sentence.empty()) return;
    const std::scoped_lock lock(mutex_);
    trouble_ = state.sentence;
  }
  void onScene(const net::SceneFields&) override {}
  std::string faultOf(const net::FrameHead& head, uint64_t payloadBytes) override { return warpscope::faultOf(head, payloadBytes); }
  bool admits(const net::SettingFields& asked, const net::SettingFields& answered) override { return warpscope::admits(asked, answered); }
  void onFrame(net::Frame frame, const net::FrameArrival& arrival) override {
    if (isMeasuring_) {
      const net::StageTimes& stages = frame.head.stages;
      const std::scoped_lock lock(mutex_);
      samples_.push_back({std::chrono::duration<double, std::milli>(arrival.arrivedAt - arrival.requestedAt).count(), stages.queueMs,
                          stages.marchMs + stages.compactMs + stages.copyMs + stages.encodeMs, frame.payload.size()});
    }
    ask();
  }
  void onFailure(const net::Failure& failure) override {
    const std::scoped_lock lock(mutex_);
    trouble_ = failure.sentence;
  }

  const Scene& scene_;
  const CodecSettings coding_;
  const uint32_t sidePx_;
  double angleDeg_;
  MarchSettings march_;
  uint64_t lastId_ = 0;
  std::atomic<bool> isMeasuring_ = false;
  mutable std::mutex mutex_;
  std::vector<Sample> samples_;
  std::string trouble_;
  std::unique_ptr<net::Client> client_;
};

/// Resident memory of a process in MiB; nothing if there is no such process.
std::optional<double> residentMiB(const std::string& pid) {
  std::ifstream file("/proc/" + pid + "/status");
  for (std::string word; file >> word;)
    if (double kib = 0.0; word == "VmRSS:" && file >> kib) return kib / 1024.0;
  return std::nullopt;
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())))];
}

/// Of clients with one size of picture.
void print(const std::string& what, const std::vector<const Onlooker*>& clients, double seconds) {
  std::vector<double> rates, latencies, queues, works;
  size_t bytes = 0;
  for (const Onlooker* client : clients) {
    const std::vector<Sample> samples = client->samples();
    rates.push_back(static_cast<double>(samples.size()) / seconds);
    for (const Sample& sample : samples) {
      latencies.push_back(sample.latencyMs);
      queues.push_back(sample.queueMs);
      works.push_back(sample.serverMs);
      bytes += sample.bytes;
    }
  }
  double all = 0.0;
  for (const double rate : rates) all += rate;
  std::printf("%-10s %3zu clients: %7.1f frames/s in all, %6.2f to %6.2f each; latency %6.0f ms, p99 %6.0f; queue %6.0f ms; march to bytes %6.1f ms, p99 %6.1f; %6.1f MB/s\n", what.c_str(),
              clients.size(), all, *std::ranges::min_element(rates), *std::ranges::max_element(rates), percentile(latencies, 0.5), percentile(latencies, 0.99), percentile(queues, 0.5),
              percentile(works, 0.5), percentile(works, 0.99), 1e-6 * static_cast<double>(bytes) / seconds);
}

/// Arguments: the server's address, its scene, how many clients, how many seconds, segments a ray, the server's process, how frames are encoded (a word of sweeps: jpeg95, tiled).
void run(const std::vector<std::string>& arguments) {
  if (arguments.size() < 4) throw UsageError("ADDRESS SCENE CLIENTS SECONDS [SEGMENTS [PID [CODEC]]]");
  const net::Address address = net::parseAddress(arguments[0]);
  const Scene scene = openScene(arguments[1]);
  const size_t count = std::stoul(arguments[2]);
  const double seconds = std::stod(arguments[3]);
  const int segments = arguments.size() > 4 ? std::stoi(arguments[4]) : 0;
  const std::string pid = arguments.size() > 5 ? arguments[5] : "";
  const CodecSettings coding = arguments.size() > 6 ? codecOfWord(arguments[6]) : CodecSettings();
  const std::optional<double> before = residentMiB(pid);
  const auto io = std::make_shared<net::IoThread>();
  std::vector<std::unique_ptr<Onlooker>> clients;
  for (size_t i = 0; i < count; ++i)
    clients.push_back(std::make_unique<Onlooker>(io, scene, address, kSidesPx[i % kSidesPx.size()], 360.0 * static_cast<double>(i) / static_cast<double>(count), segments, coding));
  std::this_thread::sleep_for(kSettling);
  for (const auto& client : clients) client->setMeasuring(true);
  const auto start = std::chrono::steady_clock::now();
  std::optional<double> most = before;
  for (const auto end = start + std::chrono::duration<double>(seconds); std::chrono::steady_clock::now() < end; std::this_thread::sleep_for(200ms))
    if (const std::optional<double> now = residentMiB(pid); now && most) most = std::max(*most, *now);
  for (const auto& client : clients) client->setMeasuring(false);
  const double measured = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  std::vector<const Onlooker*> all;
  for (const uint32_t sidePx : kSidesPx) {
    std::vector<const Onlooker*> ofSize;
    for (const auto& client : clients)
      if (client->sidePx() == sidePx) ofSize.push_back(client.get());
    if (!ofSize.empty()) print(std::to_string(sidePx) + " px", ofSize, measured);
    all.insert(all.end(), ofSize.begin(), ofSize.end());
  }
  print("all", all, measured);
  if (before && most) std::printf("the server's memory: %.0f MiB before, at most %.0f with clients: %.1f MiB each\n", *before, *most, (*most - *before) / static_cast<double>(count));
  for (const auto& client : clients)
    if (const std::string trouble = client->trouble(); !trouble.empty()) std::printf("trouble: %s\n", trouble.c_str());
  for (const auto& client : clients) client->close();
}

}  // namespace
}  // namespace warpscope

int main(int count, char** arguments) { return warpscope::benchMain("server_bench", [&] { warpscope::run({arguments + 1, arguments + count}); }); }
