// State shared by a server's connections. Only the server's own thread uses it.
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

#include "serve/gate.h"
#include "serve/viewer.h"

namespace latelight::serve {

class Hub {
 public:
  Hub(boost::asio::io_context& io, Gate gate, view::Start start, uint32_t sessions, std::chrono::milliseconds patience);

  const Gate& gate() const { return gate_; }
  const view::Start& start() const { return start_; }
  std::chrono::milliseconds patience() const { return patience_; }  // with a request, and between two

  // A viewer with a number of its own. Its calls arrive in this thread, and none of them arrives after release().
  struct Calls {
    std::function<void(Message message)> send;
    std::function<void(std::string sentence)> fail;
  };
  struct Admission {
    std::shared_ptr<Viewer> viewer;  // null: the page is refused
    std::string refusal;             // the sentence that says why
  };
  Admission admit(Calls calls);
  // The viewer's place is free at once, even while its thread still finishes a picture.
  void release(const std::shared_ptr<Viewer>& viewer);

  void keepReady(std::unique_ptr<view::ViewSession> session) { ready_ = std::move(session); }
  // Closes all connections and refuses new ones.
  void close();
  bool isClosed() const { return closed_; }
  // Makes room for others: closes the connection that has kept the server waiting for a request the longest.
  // Returns false if none waits.
  bool closeLongestWaiting();

  const std::vector<std::string>& validationMessages() const { return validationMessages_; }

 private:
  friend class Visit;
  struct Visitor {
    std::function<void()> close;
    bool closing = false;
  };
  using Visitors = std::list<Visitor>;

  void end(Visitor& visitor);
  void makeRoom();
  void join(uint64_t number);

  boost::asio::io_context& io_;
  const Gate gate_;
  const view::Start start_;
  const uint32_t sessions_;
  const std::chrono::milliseconds patience_;
  Visitors waiting_;  // for a request, in the order of their arrival; none has shown the token since
  Visitors served_;   // have shown the token: they get a response, or are a page's session
  bool closed_ = false;
  std::chrono::steady_clock::time_point crowdLogged_{};
  std::unique_ptr<view::ViewSession> ready_;  // the first, made while the server starts
  struct Admitted {
    std::shared_ptr<Viewer> viewer;
    Calls calls;
    bool released = false;
  };
  std::map<uint64_t, Admitted> viewers_;  // whose threads run
  uint64_t numbers_ = 0;
  std::vector<std::string> validationMessages_;
};

// A connection's entry in the hub. It begins as one that waits for a request. Connections that wait never keep others
// out: when too many do, the hub closes the oldest. Those that have shown the token are counted instead.
class Visit {
 public:
  Visit(Hub& hub, std::function<void()> close);
  ~Visit();
  Visit(const Visit&) = delete;
  Visit& operator=(const Visit&) = delete;

  bool beginService();  // after the token was shown; false: as many as possible are served already
  void waitForRequest();
  void closeBy(std::function<void()> close) { visitor_->close = std::move(close); }

 private:
  Hub& hub_;
  Hub::Visitors* list_;
  Hub::Visitors::iterator visitor_;
};

}  // namespace latelight::serve
