#include "serve/socket.h"

#include <fmt/format.h>

#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <span>
#include <utility>

#include "base/journal.h"
#include "base/log.h"
#include "base/text.h"
#include "serve/response.h"
#include "serve/upload.h"

namespace latelight::serve {

namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;

// Bytes per write: small enough for pings in between, and large enough that a picture does not require a hundred system
// calls.
constexpr size_t kFragment = 64 << 10;

class Socket : public std::enable_shared_from_this<Socket> {
 public:
  Socket(tcp::socket socket, Request request, std::string peer, Hub& hub, std::unique_ptr<Visit> visit)
      : stream_(std::move(socket)),
        request_(std::move(request)),
        peer_(std::move(peer)),
        hub_(hub),
        visit_(std::move(visit)) {
    visit_->closeBy([this] { close(websocket::close_code::going_away, "the server was stopped"); });
  }
  ~Socket() { leave(); }

  void accept();

 private:
  void begin();
  void refuseHandshake(beast::error_code error);
  void read();
  void take(beast::error_code error);
  void takeText(const std::string& text);
  void takePiece(const std::string& bytes);
  void send(Message message);
  void write();
  void close(websocket::close_code code, const std::string& reason);
  void refuse(websocket::close_code code, const std::string& why);
  void leave();

  websocket::stream<beast::tcp_stream> stream_;
  const Request request_;
  const std::string peer_;
  Hub& hub_;
  const std::unique_ptr<Visit> visit_;
  std::shared_ptr<Viewer> viewer_;
  beast::flat_buffer buffer_;
  std::unique_ptr<Upload> upload_;
  std::deque<Message> outgoing_;  // the viewer sends at most what Pace allows before they are written
  bool closing_ = false;
};

// Pings detect connections that broke without notice. If a page closes its socket, its session ends at once, even if a
// write that the page never reads keeps the socket from closing.
void Socket::accept() {
  websocket::stream_base::timeout times = websocket::stream_base::timeout::suggested(beast::role_type::server);
  times.handshake_timeout = std::chrono::seconds(10);
  times.idle_timeout = std::chrono::seconds(30);
  times.keep_alive_pings = true;
  stream_.set_option(times);
  stream_.read_message_max(kMaxPieceBytes);
  stream_.binary(true);
  stream_.write_buffer_bytes(kFragment);
  beast::get_lowest_layer(stream_).socket().set_option(tcp::no_delay(true));
  stream_.control_callback([this](websocket::frame_type kind, beast::string_view) {
    if (kind == websocket::frame_type::close) leave();
  });
  stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
    if (response.result() == beast::http::status::switching_protocols) return;
    setHeader(response, kPlainText);
    response.keep_alive(false);
  }));
  stream_.async_accept(request_, [self = shared_from_this()](beast::error_code error) {
    error ? self->refuseHandshake(error) : self->begin();
  });
}

// Beast has answered the request, such as one without a key or of another version of the protocol. A connection that
// broke, or that the server closes, ends without a line in the log.
void Socket::refuseHandshake(beast::error_code error) {
  const bool isRefusal = error.category() == websocket::make_error_code(websocket::error::no_sec_key).category();
  if (isRefusal) hub_.logRefusal(peer_, error.message());
}

// The viewer's calls hold only weak references, so they keep no connection alive.
void Socket::begin() {
  const std::weak_ptr<Socket> weak = weak_from_this();
  Hub::Calls calls;
  calls.send = [weak](Message message) {
    if (const auto self = weak.lock()) self->send(std::move(message));
  };
  calls.fail = [weak](const Failure& failure) {
    const auto code = failure.mayPass ? websocket::close_code::try_again_later : websocket::close_code::internal_error;
    if (const auto self = weak.lock()) self->refuse(code, failure.sentence);
  };
  Hub::Admission admission = hub_.admit(std::move(calls));
  if (!admission.viewer) return refuse(websocket::close_code::try_again_later, admission.refusal);
  viewer_ = std::move(admission.viewer);
  record(fmt::format("a viewer at {} has come", peer_));
  read();
}

void Socket::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code error, size_t) { self->take(error); });
}

void Socket::take(beast::error_code error) {
  if (error) leave();
  if (error == websocket::error::message_too_big) return hub_.logRefusal(peer_, "too long a message");
  if (error || !viewer_) return;
  try {
    const std::string message = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    stream_.got_text() ? takeText(message) : takePiece(message);
  } catch (const BadMessage& bad) {
    return refuse(websocket::close_code::policy_error, bad.what());
  }
  read();
}

// Only the last file of a page counts: it replaces a file that still waits for the viewer.
void Socket::takeText(const std::string& text) {
  if (text.size() > kMaxOrderBytes) throw BadMessage("too long a message");
  Order order = readOrder(text, hub_.start());
  const auto* sent = std::get_if<SendFile>(&order.what);
  if (!sent) return viewer_->take(std::move(order));
  upload_.reset();
  viewer_->dropFile();
  upload_ = std::make_unique<Upload>(*sent, order.serial);
}

void Socket::takePiece(const std::string& bytes) {
  if (!upload_) throw BadMessage("pages send text, and the files that they announce");
  upload_->add(std::as_bytes(std::span(bytes)));
  if (!upload_->isComplete()) return;
  viewer_->take(upload_->order());
  upload_.reset();
}

void Socket::refuse(websocket::close_code code, const std::string& why) {
  hub_.logRefusal(peer_, why);
  close(code, why);
}

// Releases everything except the message that is being written.
void Socket::leave() {
  upload_.reset();
  while (outgoing_.size() > 1) outgoing_.pop_back();
  if (!viewer_) return;
  hub_.release(std::exchange(viewer_, nullptr));
  record(fmt::format("a viewer at {} has left", peer_));
}

void Socket::send(Message message) {
  if (closing_) return;
  outgoing_.push_back(std::move(message));
  if (outgoing_.size() == 1) write();
}

void Socket::write() {
  stream_.async_write(boost::asio::buffer(outgoing_.front().bytes),
                      [self = shared_from_this()](beast::error_code error, size_t) {
                        if (error || self->closing_) return;
                        self->outgoing_.pop_front();
                        if (self->viewer_) self->viewer_->wrote();
                        if (!self->outgoing_.empty()) self->write();
                      });
}

void Socket::close(websocket::close_code code, const std::string& reason) {
  if (std::exchange(closing_, true)) return;
  leave();
  websocket::close_reason said(code);
  // Browsers reject a close frame whose reason is not UTF-8 (RFC 6455, 5.5.1). Names of files need not be.
  const std::string text = abbreviated(printable(reason), said.reason.max_size());
  said.reason.assign(text.data(), text.size());
  stream_.async_close(said, [self = shared_from_this()](beast::error_code) {});
}

}  // namespace

void startSocket(tcp::socket socket, Request request, const std::string& peer, Hub& hub, std::unique_ptr<Visit> visit) {
  std::make_shared<Socket>(std::move(socket), std::move(request), peer, hub, std::move(visit))->accept();
}

}  // namespace latelight::serve
