#include "serve/hub.h"

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <utility>

#include "base/journal.h"

namespace latelight::serve {

namespace {

constexpr uint32_t kMostConnections = 256;

}  // namespace

Hub::Hub(boost::asio::io_context& io, Gate gate, view::Start start, uint32_t sessions,
         std::chrono::milliseconds patience)
    : io_(io), gate_(std::move(gate)), start_(std::move(start)), sessions_(sessions), patience_(patience) {}

bool Hub::enter() {
  if (closed_) return false;
  if (connections_ >= kMostConnections) {
    record("refused a connection: there are too many");
    return false;
  }
  ++connections_;
  return true;
}

// The viewer's thread posts what it has to say; the server runs until the last of them has ended.
std::shared_ptr<Viewer> Hub::admit(Calls calls) {
  if (closed_ || viewers_.size() >= sessions_) return nullptr;
  const uint64_t number = ++numbers_;
  const auto with = [this, number](const auto& act) {
    if (const auto found = viewers_.find(number); found != viewers_.end()) act(found->second.calls);
  };
  Viewer::Calls posted;
  posted.send = [this, with](std::string message) {
    boost::asio::post(io_, [with, message = std::move(message)]() mutable {
      with([&](const Calls& calls) { calls.send ? calls.send(std::move(message)) : void(); });
    });
  };
  posted.fail = [this, with](std::string sentence) {
    boost::asio::post(io_, [with, sentence = std::move(sentence)]() mutable {
      with([&](const Calls& calls) { calls.fail ? calls.fail(std::move(sentence)) : void(); });
    });
  };
  posted.ended = [this, number, works = boost::asio::make_work_guard(io_)] {
    boost::asio::post(io_, [this, number] { bury(number); });
  };
  auto viewer = std::make_shared<Viewer>(std::move(ready_), start_, std::move(posted));
  viewers_[number] = {viewer, std::move(calls)};
  return viewer;
}

void Hub::letGo(const std::shared_ptr<Viewer>& viewer) {
  viewer->stop();
  for (auto& [number, admitted] : viewers_)
    if (admitted.viewer == viewer) admitted.calls = {};
}

void Hub::bury(uint64_t number) {
  const auto ended = viewers_.extract(number);
  for (const std::string& message : ended.mapped().viewer->validationMessages()) validationMessages_.push_back(message);
}

void Hub::close() {
  closed_ = true;
  ready_.reset();
  for (const auto& [who, call] : std::exchange(closers_, {})) call();
}

}  // namespace latelight::serve
