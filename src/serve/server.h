// Viewing sessions for browsers: one process, HTTP and WebSocket on one port.
//
// Every tab has a session of its own. Requests pass the gate (gate.h); what a page says is in messages.h, and how fast
// pictures go in pace.h.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "view/session.h"

namespace latelight::serve {

struct ServerOptions {
  std::string address = "127.0.0.1";
  uint16_t port = 0;                 // 0: any that is free
  std::vector<std::string> names{};  // of this machine, for browsers: lower case; addresses and "localhost" always are
  uint32_t sessions = 8;             // at once
  double patience = 10;              // seconds that a request may take
};

class Server {
 public:
  // Throws Error where the address can't be listened at, or the session can't be.
  Server(const ServerOptions& options, const view::Start& start);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;
  const std::string& token() const;
  std::string url() const;
  std::string device() const;  // that the first session renders on

  // Until stop(), SIGINT or SIGTERM; a second signal ends the process. Throws Error(Internal) for what validation
  // layers said.
  void run();
  void stop();  // from any thread

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::serve
