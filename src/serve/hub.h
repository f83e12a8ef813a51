// State shared by a server's connections. Only the server's thread may use it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "serve/access_check.h"
#include "serve/log_limit.h"
#include "serve/viewer.h"

namespace latelight::serve {

class Hub {
 public:
  Hub(boost::asio::io_context& io, AccessCheck accessCheck, view::Start start, uint32_t sessions,
      std::chrono::milliseconds requestTimeout);

  const AccessCheck& accessCheck() const { return accessCheck_; }
  const view::Start& start() const { return start_; }
  std::chrono::milliseconds requestTimeout() const { return requestTimeout_; }  // for a request, and between two

  // Creates a viewer with a unique number. Its calls arrive in this thread, and none arrives after release().
  struct Calls {
    std::function<void(Message message)> send;
    std::function<void(Failure failure)> fail;
  };
  struct Admission {
    std::shared_ptr<Viewer> viewer;  // null: the page is refused
    std::string refusal;             // the reason, as a sentence
  };
  Admission admit(Calls calls);
  // Frees the viewer's slot at once, even if its thread still finishes a picture.
  void release(const std::shared_ptr<Viewer>& viewer);

  void keepReady(std::unique_ptr<view::ViewSession> session) { ready_ = std::move(session); }
  // Closes all connections and refuses new ones.
  void close();
  bool isClosed() const { return closed_; }
  // Frees a connection: closes the one that has waited for a request the longest. Returns false if none waits.
  bool closeLongestWaiting();

  // Logs the reason for which a request or a page was refused, a limited number of times.
  void logRefusal(const std::string& peer, const std::string& why);

  const std::vector<std::string>& validationMessages() const { return validationMessages_; }

 private:
  friend class Visit;
  struct Visitor {
    std::function<void()> close;
    bool closing = false;
  };
  using Visitors = std::list<Visitor>;

  void end(Visitor& visitor);
  void closeIdleSession();
  void join(uint64_t number);

  boost::asio::io_context& io_;
  const AccessCheck accessCheck_;
  const view::Start start_;
  const uint32_t sessions_;
  const std::chrono::milliseconds requestTimeout_;
  Visitors waiting_;  // waiting for a request, in order of arrival; not authorized since then
  Visitors served_;   // have shown the token: they receive a response, or belong to a page's session
  bool closed_ = false;
  std::chrono::steady_clock::time_point crowdLogged_{};
  LogLimit refusals_;
  std::unique_ptr<view::ViewSession> ready_;  // the first session, created while the server starts
  struct Admitted {
    std::shared_ptr<Viewer> viewer;
    Calls calls;
    bool released = false;
  };
  std::map<uint64_t, Admitted> viewers_;  // viewers whose threads are running
  uint64_t numbers_ = 0;
  std::vector<std::string> validationMessages_;
};

// A connection's entry in the hub. At first, it waits for a request. Waiting connections never block others: if there
// are too many, the hub closes the oldest. The number of connections that have shown the token is limited instead.
class Visit {
 public:
  Visit(Hub& hub, std::function<void()> close);
  ~Visit();
  Visit(const Visit&) = delete;
  Visit& operator=(const Visit&) = delete;

  bool beginService();  // call it after the token was shown; false: the maximum number is already served
  void waitForRequest();
  void closeBy(std::function<void()> close) { visitor_->close = std::move(close); }

 private:
  Hub& hub_;
  Hub::Visitors* list_;
  Hub::Visitors::iterator visitor_;
};

}  // namespace latelight::serve
