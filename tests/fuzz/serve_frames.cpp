// The bytes of a WebSocket connection after its handshake, with the options of src/serve/socket.cpp. No message may be
// longer than the server allows.
#include <boost/beast/_experimental/test/stream.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include "fuzz/fuzz.h"
#include "serve/messages.h"

using namespace latelight;

namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

constexpr beast::string_view kHandshake =
    "GET /socket HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  boost::asio::io_context io;
  beast::test::stream client(io);
  websocket::stream<beast::test::stream> server(io);
  server.next_layer().connect(client);
  server.read_message_max(serve::kMaxPieceBytes);
  server.binary(true);
  server.next_layer().append(kHandshake);
  server.next_layer().append({reinterpret_cast<const char*>(data), size});
  client.close();
  beast::error_code error;
  server.accept(error);
  beast::flat_buffer buffer;
  while (!error) {
    server.read(buffer, error);
    if (buffer.size() > serve::kMaxPieceBytes) fuzz::report("too long a message");
    buffer.consume(buffer.size());
  }
  return 0;
}
