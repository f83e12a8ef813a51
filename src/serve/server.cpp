#include "serve/server.h"

#include <fmt/format.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <exception>
#include <utility>

#include "base/error.h"
#include "base/journal.h"
#include "serve/connection.h"
#include "serve/token.h"

namespace latelight::serve {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using ErrorCode = boost::system::error_code;

tcp::acceptor listen(asio::io_context& io, const ServerOptions& options) {
  ErrorCode error;
  const asio::ip::address address = asio::ip::make_address(options.address, error);
  if (error)
    badUsage("--address takes an address of this machine, such as 127.0.0.1, ::1 or 0.0.0.0, not \"{}\"",
             options.address);
  const tcp::endpoint at(address, options.port);
  tcp::acceptor acceptor(io);
  acceptor.open(at.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(at, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error == asio::error::address_in_use)
    badUsage("port {} of {} is in use; choose another with --port, or any free one with --port 0", options.port,
             options.address);
  if (error) badUsage("can't listen at port {} of {}: {}", options.port, options.address, error.message());
  return acceptor;
}

}  // namespace

struct Server::Impl {
  Impl(const ServerOptions& options, const view::Start& start)
      : acceptor(listen(io, options)),
        endpoint(acceptor.local_endpoint()),
        token(newToken()),
        hub(io, {token, options.names}, start, options.sessions,
            std::chrono::milliseconds(std::lround(1000 * options.requestTimeout))) {
    auto first = std::make_unique<view::ViewSession>(start);
    device = first->state().device;
    hub.keepReady(std::move(first));
    // Last, because a signal ends the process while the scene is still loaded.
    signals.add(SIGINT);
    signals.add(SIGTERM);
    signals.async_wait([this](ErrorCode error, int) {
      if (!error) close();
    });
  }
  // Pending handlers must not outlive the objects that they use.
  ~Impl() {
    close();
    work();
  }

  void accept();
  void close();
  void work();

  asio::io_context io{1};
  tcp::acceptor acceptor;
  const tcp::endpoint endpoint;  // of the acceptor, which run() closes while other threads may ask for it
  asio::signal_set signals{io};
  asio::steady_timer pause{io};
  const std::string token;
  std::string device;
  Hub hub;
};

// If the process has no file descriptor left, a connection that only waits for a request is closed.
void Server::Impl::accept() {
  acceptor.async_accept([this](ErrorCode error, tcp::socket socket) {
    if (hub.isClosed()) return;
    if (!error) {
      startConnection(std::move(socket), hub);
      return accept();
    }
    const bool retriesSoon = error == asio::error::no_descriptors && hub.closeLongestWaiting();
    if (!retriesSoon) record(fmt::format("a connection could not be accepted: {}", error.message()));
    pause.expires_after(retriesSoon ? std::chrono::milliseconds(10) : std::chrono::seconds(1));
    pause.async_wait([this](ErrorCode) {
      if (!hub.isClosed()) accept();
    });
  });
}

void Server::Impl::close() {
  ErrorCode ignored;
  signals.clear(ignored);
  signals.cancel(ignored);
  acceptor.close(ignored);
  pause.cancel();
  hub.close();
}

// An error of one connection, such as a lack of memory, does not end the others.
void Server::Impl::work() {
  io.restart();
  while (!io.stopped()) {
    try {
      io.run();
    } catch (const std::exception& error) {
      record(fmt::format("internal error: {}", error.what()));
    }
  }
}

Server::Server(const ServerOptions& options, const view::Start& start)
    : impl_(std::make_unique<Impl>(options, start)) {}
Server::~Server() = default;

uint16_t Server::port() const {
  return impl_->endpoint.port();
}

const std::string& Server::token() const {
  return impl_->token;
}

// A server that listens on all addresses is reached on this machine by the loopback address.
std::string Server::url() const {
  const asio::ip::address address = impl_->endpoint.address();
  std::string host = address.to_string();
  if (address.is_unspecified()) host = address.is_v6() ? "::1" : "127.0.0.1";
  if (address.is_v6()) host = "[" + host + "]";
  return fmt::format("http://{}:{}/{}/", host, port(), token());
}

std::string Server::device() const {
  return impl_->device;
}

void Server::run() {
  Impl& i = *impl_;
  i.accept();
  i.work();
  for (const std::string& message : i.hub.validationMessages())
    fail(ExitCode::Internal, "the Vulkan validation layer says: {}", message);
}

void Server::stop() {
  asio::post(impl_->io, [impl = impl_.get()] { impl->close(); });
}

}  // namespace latelight::serve
