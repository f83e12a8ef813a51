#include "serve/connection.h"

#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "serve/page.h"
#include "serve/response.h"
#include "serve/socket.h"

namespace latelight::serve {

namespace {

namespace beast = boost::beast;
namespace http = beast::http;
using boost::asio::ip::tcp;

constexpr uint32_t kMaxHeaderBytes = 8192;
constexpr size_t kMaxDrainedBytes = 256 << 10;  // read after the answer to a request that was not read to its end
constexpr std::chrono::seconds kDrainTime{1};

std::string_view view(beast::string_view text) {
  return {text.data(), text.size()};
}

// No client sends two of a field that states a single value. Which of them counts would be a matter of taste, so such a
// request states none, and is refused.
RequestHeader headerOf(const http::request<http::empty_body>& request) {
  RequestHeader header{view(request.target()), {}, {}};
  if (request.count(http::field::host) == 1) header.host = view(request[http::field::host]);
  if (const size_t origins = request.count(http::field::origin); origins > 0)
    header.origin = origins == 1 ? view(request[http::field::origin]) : std::string_view();
  return header;
}

// Returns the status with which a request that could not be read is answered, or nothing if the connection is broken.
std::optional<http::status> statusOf(beast::error_code error) {
  if (error == beast::error::timeout) return http::status::request_timeout;
  if (error == http::error::header_limit) return http::status::request_header_fields_too_large;
  if (error == http::error::body_limit || error == http::error::unexpected_body) return http::status::payload_too_large;
  const bool isMalformed = error.category() == http::make_error_code(http::error::bad_method).category();
  return isMalformed ? std::optional(http::status::bad_request) : std::nullopt;
}

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket socket, Hub& hub)
      : stream_(std::move(socket)),
        deadline_(stream_.get_executor()),
        hub_(hub),
        visit_(std::make_unique<Visit>(hub, [this] { stream_.cancel(); })) {
    beast::error_code error;
    const tcp::endpoint peer = stream_.socket().remote_endpoint(error);
    peer_ = error ? "somebody" : peer.address().to_string();
  }

  void read() {
    visit_->waitForRequest();
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(0);
    // The stream's own timeout would close it, so that the request could not be answered.
    stream_.expires_never();
    isReading_ = true, isLate_ = false;
    deadline_.expires_after(hub_.requestTimeout());
    deadline_.async_wait([self = shared_from_this()](beast::error_code error) {
      if (error || !self->isReading_) return;
      self->isLate_ = true;
      self->stream_.cancel();
    });
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](beast::error_code error, size_t) {
      self->isReading_ = false;
      self->deadline_.cancel();
      self->stream_.expires_after(self->hub_.requestTimeout());  // of the answer
      self->answer(self->isLate_ ? beast::error_code(beast::error::timeout) : error);
    });
  }

 private:
  void answer(beast::error_code error);
  void answerUnread(beast::error_code error);
  Response respond(const http::request<http::empty_body>& request, const AccessCheck::Answer& answer, bool crowded);
  void write(Response response);
  void drain(size_t drained);

  beast::tcp_stream stream_;
  boost::asio::steady_timer deadline_;       // of a request
  bool isReading_ = false, isLate_ = false;  // a request; the deadline has passed
  Hub& hub_;
  std::unique_ptr<Visit> visit_;
  std::string peer_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::empty_body>> parser_;
  Response response_;
};

// A connection that was kept open for another request, or that the server closes, ends without a line in the log.
void Connection::answer(beast::error_code error) {
  if (error == http::error::end_of_stream || error == boost::asio::error::operation_aborted) return;
  if (error) return answerUnread(error);
  const http::request<http::empty_body>& request = parser_->get();
  const AccessCheck::Answer answer = hub_.accessCheck().open(headerOf(request));
  if (!answer.refusal.empty()) hub_.logRefusal(peer_, answer.refusal);
  const bool crowded = answer.refusal.empty() && !visit_->beginService();
  if (crowded) hub_.logRefusal(peer_, "too many connections");
  if (answer.refusal.empty() && !crowded && answer.path == "socket" && beast::websocket::is_upgrade(request))
    return startSocket(stream_.release_socket(), parser_->release(), peer_, hub_, std::move(visit_));
  write(respond(request, answer, crowded));
}

// All such requests have the same answers, with and without the token.
void Connection::answerUnread(beast::error_code error) {
  const bool isLate = error == beast::error::timeout;
  if (isLate && !parser_->got_some()) return;
  hub_.logRefusal(peer_, isLate ? "its request took too long" : "its request cannot be read: " + error.message());
  const std::optional<http::status> status = statusOf(error);
  if (!status) return;
  Response response{*status, 11};
  const beast::string_view reason = http::obsolete_reason(*status);
  response.body() = std::string(reason.data(), reason.size()) + ".\n";
  setHeader(response, kPlainText);
  response.keep_alive(false);
  response.prepare_payload();
  write(std::move(response));
}

Response Connection::respond(const http::request<http::empty_body>& request, const AccessCheck::Answer& answer,
                             bool crowded) {
  const PageFile* file = answer.refusal.empty() && !crowded ? findPageFile(answer.path) : nullptr;
  const bool reads = request.method() == http::verb::get || request.method() == http::verb::head;
  Response response{http::status::ok, request.version()};
  if (!answer.refusal.empty())
    response.result(http::status::forbidden), response.body() = "Refused. Use the address that the server printed.\n";
  else if (crowded)
    response.result(http::status::service_unavailable), response.body() = "Too many connections. Try again.\n";
  else if (!reads)
    response.result(http::status::method_not_allowed), response.set(http::field::allow, "GET, HEAD");
  else if (!file)
    response.result(http::status::not_found), response.body() = "There is no such file.\n";
  else
    response.body() = file->text;
  const std::string_view type = file && reads ? file->type : kPlainText;
  setHeader(response, type);
  response.keep_alive(request.keep_alive() && answer.refusal.empty() && !crowded);
  response.prepare_payload();
  if (request.method() == http::verb::head) response.body().clear();
  return response;
}

void Connection::write(Response response) {
  response_ = std::move(response);
  http::async_write(stream_, response_, [self = shared_from_this()](beast::error_code error, size_t) {
    if (error) return;
    if (self->response_.keep_alive()) return self->read();
    beast::error_code ignored;
    self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
    self->buffer_.clear();
    self->visit_->waitForRequest();  // so that new connections may replace it
    self->stream_.expires_after(kDrainTime);
    self->drain(0);
  });
}

// Closing a socket that has unread bytes resets the connection, and the client might lose the answer (RFC 9112, 9.6).
void Connection::drain(size_t drained) {
  if (drained >= kMaxDrainedBytes) return;
  constexpr size_t kChunk = 16 << 10;
  stream_.async_read_some(buffer_.prepare(kChunk),
                          [self = shared_from_this(), drained](beast::error_code error, size_t bytes) {
                            if (!error) self->drain(drained + bytes);
                          });
}

}  // namespace

void startConnection(tcp::socket socket, Hub& hub) {
  if (hub.isClosed()) return;
  std::make_shared<Connection>(std::move(socket), hub)->read();
}

}  // namespace latelight::serve
