#include "serve/socket.h"

#include <fmt/format.h>

#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/journal.h"

namespace latelight::serve {

namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;

// Bytes that are written at once: pings go between, and a picture is not a hundred calls of the system.
constexpr size_t kFragment = 64 << 10;

class Socket : public std::enable_shared_from_this<Socket> {
 public:
  Socket(tcp::socket socket, Request request, std::string peer, Hub& hub)
      : stream_(std::move(socket)), request_(std::move(request)), peer_(std::move(peer)), hub_(hub) {
    hub_.whenClosed(this, [this] { close(websocket::close_code::going_away, "the server was stopped"); });
  }
  ~Socket() {
    hub_.forget(this);
    hub_.leave();
    if (!viewer_) return;
    hub_.letGo(viewer_);
    record(fmt::format("a viewer at {} has left", peer_));
  }

  void accept();

 private:
  void begin();
  void read();
  void take(beast::error_code error);
  void takeText(const std::string& text);
  void takePiece(const std::string& bytes);
  void send(std::string message);
  void write();
  void close(websocket::close_code code, const std::string& reason);
  void refuse(const std::string& why);

  websocket::stream<beast::tcp_stream> stream_;
  const Request request_;
  const std::string peer_;
  Hub& hub_;
  std::shared_ptr<Viewer> viewer_;
  beast::flat_buffer buffer_;
  struct Incoming {
    SendFile sent;
    uint64_t serial;
    std::vector<std::byte> bytes{};
  };
  std::optional<Incoming> file_;
  std::deque<std::string> outgoing_;  // as many as a viewer may have on their way
  bool closing_ = false;
};

// Pings find out who is gone without a word.
void Socket::accept() {
  websocket::stream_base::timeout times = websocket::stream_base::timeout::suggested(beast::role_type::server);
  times.handshake_timeout = std::chrono::seconds(10);
  times.idle_timeout = std::chrono::seconds(30);
  times.keep_alive_pings = true;
  stream_.set_option(times);
  stream_.read_message_max(kMostPiece);
  stream_.binary(true);
  stream_.write_buffer_bytes(kFragment);
  beast::get_lowest_layer(stream_).socket().set_option(tcp::no_delay(true));
  stream_.async_accept(request_, [self = shared_from_this()](beast::error_code error) {
    if (!error) self->begin();
  });
}

// The viewer's calls hold no connection alive.
void Socket::begin() {
  const std::weak_ptr<Socket> weak = weak_from_this();
  Hub::Calls calls;
  calls.send = [weak](std::string message) {
    if (const auto self = weak.lock()) self->send(std::move(message));
  };
  calls.fail = [weak](const std::string& sentence) {
    if (const auto self = weak.lock()) self->close(websocket::close_code::internal_error, sentence);
  };
  viewer_ = hub_.admit(std::move(calls));
  if (!viewer_)
    return close(websocket::close_code::try_again_later,
                 fmt::format("all {} sessions are in use; close another page", hub_.sessions()));
  record(fmt::format("a viewer at {} has come", peer_));
  read();
}

void Socket::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, size_t) { self->take(error); });
}

void Socket::take(beast::error_code error) {
  if (error == websocket::error::message_too_big) return record(fmt::format("refused {}: too long a message", peer_));
  if (error) return;
  try {
    const std::string message = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    stream_.got_text() ? takeText(message) : takePiece(message);
  } catch (const BadMessage& bad) {
    return refuse(bad.what());
  }
  read();
}

void Socket::takeText(const std::string& text) {
  if (text.size() > kMostBytes) throw BadMessage("too long a message");
  Order order = readOrder(text, hub_.start());
  const auto* sent = std::get_if<SendFile>(&order.what);
  if (!sent) return viewer_->take(std::move(order));
  file_ = Incoming{*sent, order.serial};
}

void Socket::takePiece(const std::string& bytes) {
  if (!file_ || file_->bytes.size() + bytes.size() > file_->sent.bytes)
    throw BadMessage("pages send text, and the files that they say they send");
  const auto piece = std::as_bytes(std::span(bytes));
  file_->bytes.insert(file_->bytes.end(), piece.begin(), piece.end());
  if (file_->bytes.size() < file_->sent.bytes) return;
  auto whole = std::make_shared<const std::vector<std::byte>>(std::move(file_->bytes));
  viewer_->take({view::GiveEnvironment{file_->sent.name, std::move(whole)}, file_->serial});
  file_.reset();
}

void Socket::refuse(const std::string& why) {
  record(fmt::format("refused {}: {}", peer_, why));
  close(websocket::close_code::policy_error, why);
}

void Socket::send(std::string message) {
  if (closing_) return;
  outgoing_.push_back(std::move(message));
  if (outgoing_.size() == 1) write();
}

void Socket::write() {
  stream_.async_write(boost::asio::buffer(outgoing_.front()),
                      [self = shared_from_this()](beast::error_code error, size_t) {
                        if (error || self->closing_) return;
                        self->outgoing_.pop_front();
                        if (!self->outgoing_.empty()) self->write();
                      });
}

void Socket::close(websocket::close_code code, const std::string& reason) {
  if (std::exchange(closing_, true)) return;
  websocket::close_reason said(code);
  said.reason = beast::string_view(reason).substr(0, said.reason.max_size());
  stream_.async_close(said, [self = shared_from_this()](beast::error_code) {});
}

}  // namespace

void startSocket(tcp::socket socket, Request request, const std::string& peer, Hub& hub) {
  if (!hub.enter()) return;
  std::make_shared<Socket>(std::move(socket), std::move(request), peer, hub)->accept();
}

}  // namespace latelight::serve
