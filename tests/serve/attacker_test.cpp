// An attacker's script against a server: ways to present a token, a host and an origin, malformed frames, floods, and
// broken uploads (docs/threat-model.md). After each attack the server must still serve its own page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <fmt/format.h>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cctype>
#include <cerrno>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "serve/client.h"
#include "serve/messages.h"
#include "serve/server.h"

namespace latelight::serve {
namespace {

using namespace std::chrono_literals;
using namespace std::string_literals;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kUpgrade =
    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

// A connection for bytes that no browser sends.
class RawConnection {
 public:
  explicit RawConnection(uint16_t port) : socket_(io_) {
    socket_.connect({boost::asio::ip::make_address("127.0.0.1"), port});
    const timeval patience{.tv_sec = 600, .tv_usec = 0};  // only against hangs
    setsockopt(socket_.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  // Returns whether the server still accepted the bytes.
  bool send(const std::string& bytes) {
    boost::system::error_code error;
    boost::asio::write(socket_, boost::asio::buffer(bytes), error);
    return !error;
  }
  // Returns what is received until it ends with `end`, or the server closes the connection.
  std::string hear(const std::string& end) {
    std::string heard;
    char some[4096];
    ssize_t got = 0;
    while ((end.empty() || !heard.ends_with(end)) && (got = recv(socket_.native_handle(), some, sizeof some, 0)) > 0)
      heard.append(some, size_t(got));
    isOpen_ = got > 0;
    timedOut_ = got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
    return heard;
  }
  bool isOpen() const { return isOpen_; }
  bool timedOut() const { return timedOut_; }

 private:
  boost::asio::io_context io_;
  boost::asio::ip::tcp::socket socket_;
  bool isOpen_ = true, timedOut_ = false;
};

class AttackerTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    view::Start start{.scene = "builtin:boxes", .device = "cpu", .validate = true, .width = 64, .height = 48};
    server = new Server({.requestTimeout = 5}, start);
    thread = new std::thread([] { EXPECT_NO_THROW(server->run()); });
  }
  static void TearDownTestSuite() {
    server->stop();
    thread->join();
    delete thread;
    delete server;
  }
  void TearDown() override { expectServes(); }

  static uint16_t port() { return server->port(); }
  static std::string host() { return "localhost:" + std::to_string(port()); }
  static std::string socketPath() { return "/" + server->token() + "/socket"; }

  // Sends a request for the page, and one for a session; both must be refused.
  static void expectRefused(const std::string& target, const std::string& header) {
    for (const char* more : {"", kUpgrade}) {
      const std::string response = ask(
          port(), "GET " + target + " HTTP/1.1\r\n" + header + more + (*more ? "" : "Connection: close\r\n") + "\r\n");
      // 400: it cannot be parsed.
      EXPECT_TRUE(response.starts_with("HTTP/1.1 403") || response.starts_with("HTTP/1.1 400")) << target << '\n'
                                                                                                << header << response;
    }
  }
  static void expectServes() {
    EXPECT_THAT(get(port(), "/" + server->token() + "/"), StartsWith("HTTP/1.1 200"));
    for (int attempt = 0;; ++attempt) {
      try {
        Client page(port(), server->token());
        page.say({{"type", "resize"}, {"width", 64}, {"height", 48}});
        EXPECT_EQ(decode(page.hearFinal()).width, 64u);
        return;
      } catch (const std::exception& refused) {  // sessions of earlier connections may still be ending
        ASSERT_LT(attempt, 600) << refused.what();
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
    }
  }

  static Server* server;
  static std::thread* thread;
};
Server* AttackerTest::server = nullptr;
std::thread* AttackerTest::thread = nullptr;

TEST_F(AttackerTest, NoOtherWayToPresentTheTokenWorks) {
  const std::string token = server->token(), field = "Host: " + host() + "\r\n";
  std::string upper = token, escaped, turned(token.rbegin(), token.rend());
  for (char& c : upper) c = char(std::toupper(c));
  for (const char c : token) escaped += fmt::format("%{:02x}", c);
  std::vector<std::string> targets = {"/",
                                      "/socket",
                                      "//",
                                      "/.",
                                      "/?" + token,
                                      "/#" + token,
                                      "/?token=" + token,
                                      "/socket?token=" + token,
                                      "/x/" + token + "/",
                                      "//" + token + "/",
                                      "/./" + token + "/",
                                      "/../" + token + "/",
                                      "/%2f" + token + "/",
                                      "\\" + token + "/",
                                      "/\\" + token + "/",
                                      "/;" + token + "/",
                                      token + "/",
                                      "http://evil.example/" + token + "/",
                                      "http://evil.example@" + host() + "/" + token + "/",
                                      "http://" + host() + "/x/" + token + "/",
                                      "http://" + host() + token + "/",
                                      "//" + host() + "/" + token + "/",
                                      "*",
                                      host(),
                                      "/" + token,
                                      "/" + token + "?/",
                                      "/" + token + "#/",
                                      "/" + token + ";/",
                                      "/" + token + "%2f",
                                      "/" + token + "\\",
                                      "/" + token + "%00/",
                                      "/" + token + ".",
                                      "/" + token + "x/",
                                      "/x" + token + "/",
                                      "/" + token + token + "/",
                                      "/" + escaped + "/",
                                      "/" + turned + "/",
                                      "/" + token.substr(1) + "/",
                                      "/" + token.substr(0, 31) + "/",
                                      "/" + token.substr(0, 16) + "/",
                                      "/" + std::string(32, '0') + "/",
                                      "/" + std::string(32, '*') + "/",
                                      "/" + std::string(32, '%') + "/",
                                      "/" + std::string(1000, 'a') + "/",
                                      "/undefined/",
                                      "/null/",
                                      "/token/",
                                      "/favicon.ico",
                                      "/robots.txt",
                                      "/.well-known/",
                                      "/\xc2\xa0" + token + "/",
                                      "/" + token.substr(0, 31) + "\xef\xbc\x91/"};
  if (upper != token) targets.push_back("/" + upper + "/");
  for (size_t i = 0; i < token.size(); ++i) {
    std::string other = token;
    other[i] = other[i] == 'f' ? '0' : 'f';
    targets.push_back("/" + other + "/socket");
  }
  for (const std::string& target : targets) expectRefused(target, field);
  for (const std::string& header : std::vector<std::string>{
           "Cookie: token=" + token, "Authorization: Bearer " + token, "Authorization: Basic " + token,
           "X-Token: " + token, "Referer: http://" + host() + "/" + token + "/", "Sec-WebSocket-Protocol: " + token,
           "X-Original-URL: /" + token + "/", "X-Rewrite-URL: /" + token + "/", "X-Forwarded-Prefix: /" + token})
    expectRefused("/socket", field + header + "\r\n");
}

TEST_F(AttackerTest, NoOtherHostWorks) {
  const std::string at = ":" + std::to_string(port());
  for (const std::string& other : std::vector<std::string>{"evil.example"s,
                                                           "evil.example" + at,
                                                           "localhost.evil.example" + at,
                                                           "evil.localhost" + at,
                                                           "xlocalhost" + at,
                                                           "localhost." + at,
                                                           "localhost,evil.example",
                                                           "localhost evil.example"s,
                                                           "localhost@evil.example" + at,
                                                           "evil.example@localhost" + at,
                                                           "localhost/evil"s,
                                                           "localhost#"s,
                                                           "localhost?"s,
                                                           "localhost:evil"s,
                                                           "localhost:80:90"s,
                                                           "127.0.0.1.evil.example" + at,
                                                           "127.0.0.1:80x"s,
                                                           "[::1]evil.example"s,
                                                           "[::1"s,
                                                           "[]"s,
                                                           "[::1]]"s,
                                                           "::1"s,
                                                           "[localhost]"s,
                                                           "[evil]"s,
                                                           "127.1"s,
                                                           "0x7f.0.0.1"s,
                                                           "2130706433"s,
                                                           "017700000001"s,
                                                           "localhost%00"s,
                                                           "\"localhost\""s,
                                                           "xn--localhost"s,
                                                           ""s,
                                                           " "s,
                                                           ":"s,
                                                           "."s,
                                                           at})
    expectRefused(socketPath(), "Host: " + other + "\r\n");
  expectRefused(socketPath(), "");
  expectRefused(socketPath(), "X-Forwarded-Host: localhost\r\nForwarded: host=localhost\r\n");
  expectRefused(socketPath(), "Host: evil.example\r\nHost: " + host() + "\r\n");
  expectRefused(socketPath(), "Host: " + host() + "\r\nHost: evil.example\r\n");
  expectRefused(socketPath(), "Host : " + host() + "\r\n");
}

TEST_F(AttackerTest, NoOtherOriginWorks) {
  const std::string own = "http://" + host(), name = std::to_string(port());
  for (const std::string& origin : std::vector<std::string>{""s,
                                                            "null"s,
                                                            "https://" + host(),
                                                            "http://localhost"s,
                                                            "http://localhost:1"s,
                                                            "http://127.0.0.1:" + name,
                                                            "http://evil.example"s,
                                                            own + "0",
                                                            own + "/",
                                                            own + " ,http://evil.example",
                                                            own + ".evil.example",
                                                            "http://evil.example/" + own,
                                                            "HTTP://" + host(),
                                                            "http://LOCALHOST:" + name,
                                                            "file://"s,
                                                            "ws://" + host(),
                                                            "http://user@" + host(),
                                                            "chrome-extension://abc"s,
                                                            "localhost:" + name,
                                                            "*"s})
    expectRefused(socketPath(), "Host: " + host() + "\r\nOrigin: " + origin + "\r\n");
  expectRefused(socketPath(), "Host: " + host() + "\r\nOrigin: " + own + "\r\nOrigin: http://evil.example\r\n");
}

// --- frames ---------------------------------------------------------------------------------------------------------

// A frame with a mask of zeros, so that its payload is sent as it is.
std::string frame(uint8_t first, const std::string& payload, bool masked = true) {
  std::string out(1, char(first));
  const size_t size = payload.size();
  const char mask = char(masked ? 0x80 : 0);
  if (size < 126) {
    out += char(mask | char(size));
  } else if (size < 65536) {
    out += {char(mask | 126), char(size >> 8), char(size)};
  } else {
    out += {char(mask | 127), 0, 0, 0, 0, char(size >> 24), char(size >> 16), char(size >> 8), char(size)};
  }
  return out + (masked ? std::string(4, '\0') : "") + payload;
}

std::vector<std::string> malformedFrames() {
  std::vector<std::string> all;
  for (const int reserved : {0xc1, 0xa1, 0x91, 0xf1, 0xc8, 0xc9}) all.push_back(frame(uint8_t(reserved), "{}"));
  for (const int opcode : {3, 4, 5, 6, 7, 11, 12, 13, 14, 15}) all.push_back(frame(uint8_t(0x80 | opcode), "{}"));
  all.push_back(frame(0x81, "{}", false));
  all.push_back(frame(0x89, "", false));
  for (const int control : {8, 9, 10}) {
    all.push_back(frame(uint8_t(control), ""));                            // in fragments
    all.push_back(frame(uint8_t(0x80 | control), std::string(126, 'x')));  // too long
  }
  all.push_back(frame(0x80, "{}"));  // continues nothing
  all.push_back(frame(0x00, "{}"));
  all.push_back(frame(0x01, "{") + frame(0x81, "}"));  // a text within a text
  all.push_back(frame(0x02, "{") + frame(0x01, "}"));
  for (const char* bad : {"\xff", "\xc0\xaf", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82"})
    all.push_back(frame(0x81, bad));                                    // not UTF-8
  all.push_back("\x82\xff\x80\0\0\0\0\0\0\1"s + std::string(5, '\0'));  // a length of 2^63 + 1
  all.push_back("\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff"s + std::string(5, '\0'));
  all.push_back("\x82\xfe\0\1"s + std::string(5, '\0'));  // lengths that are not minimal
  all.push_back("\x82\xff\0\0\0\0\0\0\0\1"s + std::string(5, '\0'));
  all.push_back(frame(0x88, "\3"));  // half of a code
  for (const int code : {0, 999, 1004, 1005, 1006, 1015, 2999, 5000})
    all.push_back(frame(0x88, {char(code >> 8), char(code)}));
  all.push_back(frame(0x88, "\3\xe8\xff"));  // a reason that is not UTF-8
  std::string fragments = frame(0x01, "{");
  for (int i = 0; i < 80; ++i) fragments += frame(0x00, std::string(1000, ' '));
  all.push_back(fragments + frame(0x80, "}"));  // too long in total
  all.push_back("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  all.push_back(std::string(1000, '\xff'));
  return all;
}

TEST_F(AttackerTest, MalformedFramesEndTheirConnection) {
  const std::string request = "GET " + socketPath() + " HTTP/1.1\r\nHost: " + host() + "\r\n" + kUpgrade + "\r\n";
  const std::vector<std::string> all = malformedFrames();
  ASSERT_GE(all.size(), 34u);
  for (size_t i = 0; i < all.size(); ++i) {
    RawConnection connection(port());
    connection.send(request);
    ASSERT_THAT(connection.hear("\r\n\r\n"), StartsWith("HTTP/1.1 101")) << i;
    connection.send(all[i]);
    connection.hear("");
    EXPECT_FALSE(connection.isOpen()) << i;
    EXPECT_FALSE(connection.timedOut()) << i;
  }
}

// --- floods ---------------------------------------------------------------------------------------------------------

// Neither the log nor the connections of others suffer, and the token is never in the log.
TEST_F(AttackerTest, AFloodOfRequestsFillsNoLog) {
  testing::internal::CaptureStderr();
  for (int i = 0; i < 1000; ++i)
    EXPECT_THAT(get(port(), i % 2 ? "/" : "/" + server->token() + "/x\r\nHost: evil"),
                testing::Not(HasSubstr("200 OK")));
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, testing::Not(HasSubstr(server->token())));
  // Ten lines per ten seconds, and one that counts those left out before.
  EXPECT_LT(std::ranges::count(log, '\n'), 200) << log;
}

TEST_F(AttackerTest, AFloodOfConnectionsKeepsNobodyOut) {
  std::vector<std::unique_ptr<RawConnection>> silent;
  for (int i = 0; i < 400; ++i) {
    silent.push_back(std::make_unique<RawConnection>(port()));
    silent.back()->send("GET /");
  }
  EXPECT_THAT(get(port(), "/" + server->token() + "/"), StartsWith("HTTP/1.1 200"));
}

// A page that holds the token floods its own session: with pings, and with more orders than may wait.
TEST_F(AttackerTest, AFloodOfMessagesHarmsOnlyItsSender) {
  const std::string request = "GET " + socketPath() + " HTTP/1.1\r\nHost: " + host() + "\r\n" + kUpgrade + "\r\n";
  RawConnection pings(port());
  pings.send(request);
  ASSERT_THAT(pings.hear("\r\n\r\n"), StartsWith("HTTP/1.1 101"));
  std::string many;
  for (int i = 0; i < 2000; ++i) many += frame(0x89, "x");
  std::thread writer([&] { pings.send(many + frame(0x88, "\3\xe8")); });
  pings.hear("");
  writer.join();
  EXPECT_FALSE(pings.timedOut());

  Client orders(port(), server->token());
  const auto flood = [&] {
    for (int i = 0; i < 20000; ++i) orders.say({{"type", "screenshot"}});
    for (;;) orders.hear();
  };
  EXPECT_ANY_THROW(flood());
  EXPECT_TRUE(orders.closeCode() == 1008 || orders.closeCode() == 0) << orders.closeCode();
}

// --- uploads --------------------------------------------------------------------------------------------------------

// Broken images of every length: the page is told, and goes on.
TEST_F(AttackerTest, BrokenUploadsAreExplained) {
  std::string whole = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n";
  for (int row = 0; row < 4; ++row) whole += "\2\2\0\x8"s + "\x88R\x88G\x84" + "B\4bbbb\x88\x80";
  std::minstd_rand random(7);
  Client page(port(), server->token());
  page.say({{"type", "resize"}, {"width", 64}, {"height", 48}});
  page.hearFinal();
  for (int i = 0; i < 120; ++i) {
    std::string broken = whole.substr(0, 1 + random() % (whole.size() - 1));
    for (int flips = 0; flips < 3; ++flips) broken[random() % broken.size()] = char(random());
    page.say({{"type", "file"}, {"name", i % 2 ? "sky.hdr" : "sky.exr"}, {"bytes", broken.size()}});
    page.sayBinary(broken);
  }
  const uint64_t last = page.say({{"type", "environment"}, {"name", "none"}});
  while (true) {
    const Client::Message message = page.hear();
    page.show(message);
    if (message.header["serial"].get<uint64_t>() >= last) break;
  }
}

}  // namespace
}  // namespace latelight::serve
