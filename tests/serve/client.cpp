#include "serve/client.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <turbojpeg.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cstring>
#include <stdexcept>

namespace latelight::serve {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using Json = nlohmann::json;

void connect(tcp::socket& socket, uint16_t port) {
  socket.connect({asio::ip::make_address("127.0.0.1"), port});
  // as in browsers: a key does not wait for the acknowledgment of earlier messages
  socket.set_option(tcp::no_delay(true));
  const timeval patience{.tv_sec = 1800, .tv_usec = 0};  // only against hangs
  setsockopt(socket.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
}

}  // namespace

std::string ask(uint16_t port, const std::string& bytes) {
  asio::io_context io;
  tcp::socket socket(io);
  connect(socket, port);
  boost::system::error_code error;
  asio::write(socket, asio::buffer(bytes), error);
  std::string heard;
  char some[4096];
  for (ssize_t got = 0; (got = recv(socket.native_handle(), some, sizeof some, 0)) > 0;) heard.append(some, got);
  return heard;
}

std::string get(uint16_t port, const std::string& target, const std::string& more) {
  const std::string host = more.find("Host:") == more.npos ? "Host: localhost:" + std::to_string(port) + "\r\n" : "";
  return ask(port, "GET " + target + " HTTP/1.1\r\n" + host + more + "Connection: close\r\n\r\n");
}

struct Client::Impl {
  asio::io_context io;
  beast::websocket::stream<tcp::socket> stream{io};
  Json state = Json::object();
  uint64_t serial = 0;
};

Client::Client(uint16_t port, const std::string& token, const std::string& origin) : impl_(std::make_unique<Impl>()) {
  connect(impl_->stream.next_layer(), port);
  impl_->stream.read_message_max(256 << 20);
  impl_->stream.write_buffer_bytes(256 << 10);  // a message is one frame, as browsers send it
  if (!origin.empty())
    impl_->stream.set_option(beast::websocket::stream_base::decorator(
        [origin](beast::websocket::request_type& request) { request.set(beast::http::field::origin, origin); }));
  impl_->stream.handshake("127.0.0.1:" + std::to_string(port), "/" + token + "/socket");
}
Client::~Client() = default;
Client::Client(Client&&) noexcept = default;

uint64_t Client::say(Json message) {
  message["serial"] = ++impl_->serial;
  sayText(message.dump());
  return impl_->serial;
}

void Client::sayText(const std::string& text) {
  impl_->stream.text(true);
  impl_->stream.write(asio::buffer(text));
}

void Client::sayBinary(const std::string& bytes) {
  impl_->stream.binary(true);
  impl_->stream.write(asio::buffer(bytes));
}

Client::Message Client::hear() {
  beast::flat_buffer buffer;
  impl_->stream.read(buffer);
  const std::string bytes = beast::buffers_to_string(buffer.data());
  uint32_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  Message message{Json::parse(bytes.substr(sizeof size, size)), bytes.substr(sizeof size + size)};
  if (message.header.contains("state")) impl_->state.update(message.header["state"]);
  return message;
}

void Client::show(const Message& message) {
  sayText(Json{{"type", "shown"}, {"number", message.header["number"]}}.dump());
}

Client::Message Client::hearFinal() {
  for (;;) {
    Message message = hear();
    show(message);
    if (message.header.contains("picture") && message.header["picture"]["final"] == true) return message;
  }
}

const Json& Client::state() const {
  return impl_->state;
}

// Data that the stream has already buffered counts, too, which the socket does not show: reading answers pings.
bool Client::hearsWithin(std::chrono::milliseconds time) {
  pollfd socket{.fd = impl_->stream.next_layer().native_handle(), .events = POLLIN, .revents = 0};
  return poll(&socket, 1, static_cast<int>(time.count())) > 0;
}

uint16_t Client::closeCode() const {
  return impl_->stream.reason().code;
}

std::string Client::closeReason() const {
  return {impl_->stream.reason().reason.data(), impl_->stream.reason().reason.size()};
}

Decoded decode(const Client::Message& message) {
  const Json& picture = message.header.at("picture");
  Decoded decoded{picture["width"], picture["height"], {}};
  decoded.rgb.resize(size_t{3} * decoded.width * decoded.height);
  const std::unique_ptr<void, int (*)(void*)> decoder(tjInitDecompress(), tjDestroy);
  const auto* from = reinterpret_cast<const unsigned char*>(message.payload.data());
  for (const Json& strip : picture["strips"]) {
    const auto bytes = strip["bytes"].get<unsigned long>();
    int width = 0, rows = 0, chroma = 0, space = 0;
    const bool fits = tjDecompressHeader3(decoder.get(), from, bytes, &width, &rows, &chroma, &space) == 0 &&
                      width == static_cast<int>(decoded.width) && strip["y"].get<uint32_t>() + rows <= decoded.height;
    auto* to = reinterpret_cast<unsigned char*>(&decoded.rgb[size_t{3} * decoded.width * strip["y"].get<uint32_t>()]);
    if (!fits || tjDecompress2(decoder.get(), from, bytes, to, width, 0, rows, TJPF_RGB, 0) != 0)
      throw std::runtime_error("a strip is not the JPEG that its picture says");
    from += bytes;
  }
  return decoded;
}

}  // namespace latelight::serve
