// What the connections of a server share. All of it is used in the server's own thread.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
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
  uint32_t sessions() const { return sessions_; }
  std::chrono::milliseconds patience() const { return patience_; }  // with a request, and between two

  // Connections come and go; false: there are more than there may be.
  bool enter();
  void leave() { --connections_; }

  // A viewer, by its number. Its calls arrive in this thread; none of them after letGo(). Null: all sessions are in
  // use.
  struct Calls {
    std::function<void(std::string message)> send;
    std::function<void(std::string sentence)> fail;
  };
  std::shared_ptr<Viewer> admit(Calls calls);
  void letGo(const std::shared_ptr<Viewer>& viewer);

  void keepReady(std::unique_ptr<view::ViewSession> session) { ready_ = std::move(session); }
  // From then on nobody enters, and those that wait for it are called.
  void close();
  void whenClosed(const void* who, std::function<void()> call) { closers_[who] = std::move(call); }
  void forget(const void* who) { closers_.erase(who); }
  bool isClosed() const { return closed_; }

  const std::vector<std::string>& validationMessages() const { return validationMessages_; }

 private:
  void bury(uint64_t number);

  boost::asio::io_context& io_;
  const Gate gate_;
  const view::Start start_;
  const uint32_t sessions_;
  const std::chrono::milliseconds patience_;
  uint32_t connections_ = 0;
  bool closed_ = false;
  std::unique_ptr<view::ViewSession> ready_;  // the first, made while the server starts
  struct Admitted {
    std::shared_ptr<Viewer> viewer;
    Calls calls;
  };
  std::map<uint64_t, Admitted> viewers_;
  uint64_t numbers_ = 0;
  std::map<const void*, std::function<void()>> closers_;
  std::vector<std::string> validationMessages_;
};

}  // namespace latelight::serve
