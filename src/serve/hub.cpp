#include "serve/hub.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <iterator>
#include <optional>
#include <utility>

#include "base/journal.h"

namespace latelight::serve {

namespace {

constexpr size_t kMaxWaiting = 256, kMaxServed = 256;  // connections
// Sessions that may still finish a picture after their pages have left, in addition to the open sessions: a reload, or
// several in a row, must be admitted at once.
constexpr size_t kMaxClosing = 4;

}  // namespace

Hub::Hub(boost::asio::io_context& io, AccessCheck accessCheck, view::Start start, uint32_t sessions,
         std::chrono::milliseconds requestTimeout)
    : io_(io),
      accessCheck_(std::move(accessCheck)),
      start_(std::move(start)),
      sessions_(sessions),
      requestTimeout_(requestTimeout) {}

// --- connections ----------------------------------------------------------------------------------------------------

// The connection's handlers remove it later.
void Hub::end(Visitor& visitor) {
  if (!std::exchange(visitor.closing, true)) visitor.close();
}

bool Hub::closeLongestWaiting() {
  for (Visitor& visitor : waiting_) {
    if (visitor.closing) continue;
    end(visitor);
    return true;
  }
  return false;
}

// Logs at most once per second, so that clients that open connections cannot fill a disk.
void Hub::closeIdleSession() {
  if (waiting_.size() < kMaxWaiting || !closeLongestWaiting()) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - crowdLogged_ < std::chrono::seconds(1)) return;
  crowdLogged_ = now;
  record(fmt::format("closed the oldest connection that sent no request: {} wait", kMaxWaiting));
}

void Hub::logRefusal(const std::string& peer, const std::string& why) {
  const std::optional<uint64_t> leftOut = refusals_.next(std::chrono::steady_clock::now());
  if (!leftOut) return;
  if (*leftOut > 0) record(fmt::format("refused {} more since the last line", *leftOut));
  record(fmt::format("refused {}: {}", peer, why));
}

void Hub::close() {
  closed_ = true;
  ready_.reset();
  for (Visitors* list : {&waiting_, &served_})
    for (Visitor& visitor : *list) end(visitor);
}

Visit::Visit(Hub& hub, std::function<void()> close) : hub_(hub), list_(&hub.waiting_) {
  hub_.closeIdleSession();
  list_->push_back({std::move(close)});
  visitor_ = std::prev(list_->end());
}

Visit::~Visit() {
  list_->erase(visitor_);
}

bool Visit::beginService() {
  if (hub_.served_.size() >= kMaxServed) return false;
  hub_.served_.splice(hub_.served_.end(), *list_, visitor_);
  list_ = &hub_.served_;
  return true;
}

void Visit::waitForRequest() {
  hub_.waiting_.splice(hub_.waiting_.end(), *list_, visitor_);
  list_ = &hub_.waiting_;
}

// --- viewers --------------------------------------------------------------------------------------------------------

// The viewer's thread posts its messages to the server's thread. The server runs until the last of these threads has
// ended.
Hub::Admission Hub::admit(Calls calls) {
  if (closed_) return {nullptr, "the server was stopped"};
  const auto leaving =
      static_cast<size_t>(std::ranges::count_if(viewers_, [](const auto& entry) { return entry.second.released; }));
  if (viewers_.size() - leaving >= sessions_)
    return {nullptr, fmt::format("all {} sessions are in use; close another page", sessions_)};
  if (leaving >= sessions_ + kMaxClosing)
    return {nullptr, fmt::format("{} sessions are still ending; try again in a moment", leaving)};
  const uint64_t number = ++numbers_;
  const auto with = [this, number](const auto& act) {
    if (const auto found = viewers_.find(number); found != viewers_.end()) act(found->second.calls);
  };
  Viewer::Calls posted;
  posted.send = [this, with](Message message) {
    boost::asio::post(io_, [with, message = std::move(message)]() mutable {
      with([&](const Calls& calls) { calls.send ? calls.send(std::move(message)) : void(); });
    });
  };
  posted.fail = [this, with](Failure failure) {
    boost::asio::post(io_, [with, failure = std::move(failure)]() mutable {
      with([&](const Calls& calls) { calls.fail ? calls.fail(std::move(failure)) : void(); });
    });
  };
  posted.ended = [this, number, works = boost::asio::make_work_guard(io_)] {
    boost::asio::post(io_, [this, number] { join(number); });
  };
  auto viewer = std::make_shared<Viewer>(std::move(ready_), start_, std::move(posted));
  viewers_[number] = {viewer, std::move(calls)};
  return {viewer, ""};
}

void Hub::release(const std::shared_ptr<Viewer>& viewer) {
  viewer->stop();
  for (auto& [number, admitted] : viewers_)
    if (admitted.viewer == viewer) admitted.calls = {}, admitted.released = true;
}

void Hub::join(uint64_t number) {
  const auto ended = viewers_.extract(number);
  for (const std::string& message : ended.mapped().viewer->validationMessages()) validationMessages_.push_back(message);
}

}  // namespace latelight::serve
