// The server for `latelight serve`: viewing sessions for browsers, in one process, with HTTP and WebSocket on one port.
//
// Every browser tab has its own session. gate.h checks requests, messages.h defines the messages, and pace.h controls
// the rate of pictures.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "view/session.h"

namespace latelight::serve {

struct ServerOptions {
  std::string address = "127.0.0.1";
  uint16_t port = 0;                 // 0: any free port
  std::vector<std::string> names{};  // names of this machine in browsers, lower case; addresses and "localhost" are
                                     // always accepted
  uint32_t sessions = 8;             // maximum number at the same time
  double requestTimeout = 10;        // maximum duration of a request, in seconds
};

class Server {
 public:
  // Throws Error if the server cannot listen on the address, or if the session cannot be created. From then on, SIGINT
  // and SIGTERM end run(), even if it is called later.
  Server(const ServerOptions& options, const view::Start& start);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  uint16_t port() const;
  const std::string& token() const;
  std::string url() const;
  std::string device() const;  // of the first session

  // Runs until stop(), SIGINT or SIGTERM; a second signal ends the process. Throws Error(Internal) if validation layers
  // reported messages.
  void run();
  void stop();  // from any thread

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace latelight::serve
