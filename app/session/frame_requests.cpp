// The newest request, and those that are on show.
// See frame_requests.h.
#include "app/session/frame_requests.h"

#include <algorithm>
#include <utility>

#include "app/frames/asked_requests.h"
#include "app/frames/classified_frame.h"
#include "app/frames/coarsening.h"

namespace warpscope {
namespace {

constexpr double kGrowthAtRest = 2.0;  // of a frame's bytes

}  // namespace

void FrameRequests::begin(FrameSource& source, const TransportSettings& transport) {
  source_ = &source;
  transport_ = transport;
  source_->setTransport(transport_);
  wanted_.reset();
  asked_.reset();
  requests_.clear();
  answeredId_ = requestId_;
  frame_.reset();
  frameBytes_ = {};
  proxyBytes_ = 0;
  size_ = {};
  error_.clear();
}

void FrameRequests::setTransport(const TransportSettings& transport) {
  if (transport_ == transport) return;
  transport_ = transport;
  source_->setTransport(transport_);
}

bool FrameRequests::setTransferFunction(const TransferFunction& function, uint64_t version) {
  if (source_ == nullptr || !source_->setTransferFunction(function, version)) return false;
  classify(function);
  return true;
}

void FrameRequests::classify(const TransferFunction& function) {
  if (frame_) frame_ = classifiedBy(function, frame_);
}

bool FrameRequests::ask(const WantedFrame& wanted, bool isFrozen, TimePoint now) {
  wanted_ = wanted;
  isFrozen_ = isFrozen;
  const auto newest = requests_.find(requestId_);
  if (isWhatIsWanted()) {
    if (newest != requests_.end()) newest->second.outdatedAt.reset();  // the camera may have come back
    if (!isToBeRefined()) return false;
    if (now - wantedSince_ < kRest) return true;  // the time passes without further events
    isRefined_ = !hasFewerPixels();  // of more pixels, a server takes it for a camera that moves, and may march it coarser once more
    post(wanted, hasFewerPixels() ? FrameSizeRule::grown(posted_, wanted.camera, kGrowthAtRest) : wanted.camera, now);
    return true;
  }
  if (newest != requests_.end() && !newest->second.outdatedAt) newest->second.outdatedAt = now;
  if (isFrozen && frame_) return false;
  asked_ = wanted_;
  wantedSince_ = now;
  isRefined_ = false;
  post(wanted, transport_.frameKib == 0 ? wanted.camera : size_.choose(wanted.camera, wanted.march, static_cast<double>(bytesOfFrame(transport_))), now);
  return true;
}

void FrameRequests::post(const WantedFrame& wanted, const Camera& camera, TimePoint now) {
  posted_ = camera;
  source_->post({++requestId_, camera, wanted.march}, now);
  WantedFrame& asked = requests_[requestId_].asked;
  asked = wanted;
  asked.camera = camera;
  if (hasFewerPixels()) asked.serverSidePx = longerSide(camera);
  forgetReplaced(requests_, kMostKept);
}

bool FrameRequests::isToBeRefined() const {
  if (isFrozen_ || isUnderWay() || !isWhatIsWanted() || !frame_ || frame_->requestId != requestId_) return false;
  return hasFewerPixels() || (!isRefined_ && isCoarsened(asked_->march, frame_->settings));
}

bool FrameRequests::take() {
  std::optional<ServedFrame> served = source_->tryTake();
  if (!served) return false;
  answeredId_ = served->requestId;
  keep(std::move(*served));
  return true;
}

void FrameRequests::show(ServedFrame served, const WantedFrame& asked) {
  requestId_ = answeredId_ = served.requestId;
  asked_ = wanted_ = asked;
  isRefined_ = true;  // there is nobody who would march it in full
  posted_ = asked.camera;
  requests_[requestId_] = {asked, std::nullopt, std::nullopt};
  keep(std::move(served));
}

void FrameRequests::keep(ServedFrame served) {
  error_ = std::move(served.error);
  if (!served.frame) return;
  frame_ = std::move(served.frame);
  frameBytes_ = served.bytes;
  size_.note(frame_->camera, frame_->settings, static_cast<double>(frameBytes_.ofFrame()));
  if (frameBytes_.proxy > 0) proxyBytes_ = frameBytes_.proxy;
  if (frame_->proxy) frameBytes_.proxy = proxyBytes_;
  frameArrivedAt_ = served.arrivedAt;
  ++received_;
  rate_.tick(served.arrivedAt);
  if (const auto request = requests_.find(served.requestId); request != requests_.end())
    request->second.arrival = Arrival{served.latency, frameBytes_};
}

void FrameRequests::forgetOld(const std::function<bool(uint64_t)>& isOnShow) {
  std::erase_if(requests_, [&](const auto& request) {
    const uint64_t id = request.first;
    const bool isUnderWayOrNewest = id > answeredId_ || (frame_ && id == frame_->requestId);
    return !isUnderWayOrNewest && !isOnShow(id);
  });
}

std::optional<double> FrameRequests::ageOfNewestMs(TimePoint now) const {
  if (!frame_) return std::nullopt;
  return std::max(0.0, millisecondsBetween(frameArrivedAt_, now));
}

double FrameRequests::ageMs(uint64_t requestId, TimePoint now) const {
  if (requestId == requestId_ && isWhatIsWanted()) return 0.0;
  const Request* request = find(requestId);
  return request && request->outdatedAt ? millisecondsBetween(*request->outdatedAt, now) : 0.0;
}

std::optional<FrameRequests::Arrival> FrameRequests::arrivalOf(uint64_t requestId) const {
  const Request* request = find(requestId);
  return request ? request->arrival : std::nullopt;
}

std::optional<WantedFrame> FrameRequests::askedBy(uint64_t requestId) const {
  const Request* request = find(requestId);
  return request ? std::optional(request->asked) : std::nullopt;
}

const FrameRequests::Request* FrameRequests::find(uint64_t requestId) const {
  const auto request = requests_.find(requestId);
  return request == requests_.end() ? nullptr : &request->second;
}

}  // namespace warpscope
