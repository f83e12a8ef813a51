// The server as seen by browsers and other clients. All but those of ReconnectsTest run under validation,
// and any message fails the test.
#include "serve/server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <latelight/latelight.h>
#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <random>
#include <set>
#include <thread>

#include "app/folder.h"
#include "app/process.h"
#include "long_tests.h"
#include "lost_device/lose.h"
#include "models/models.h"
#include "output/aov.h"
#include "output/png.h"
#include "render/options/options.h"
#include "serve/client.h"
#include "serve/messages.h"
#include "serve/picture.h"
#include "serve/viewer.h"

namespace latelight::serve {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;
using Json = nlohmann::json;

constexpr uint32_t kSessions = 8;

size_t entries(const char* folder) {
  return std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator());
}
size_t descriptors() {
  return entries("/proc/self/fd");
}
size_t threads() {
  return entries("/proc/self/task");
}
// Without memory that the allocator keeps for reuse, which depends on how many threads ran at the same time.
size_t residentBytes() {
  malloc_trim(0);
  std::ifstream file("/proc/self/statm");
  size_t all = 0, resident = 0;
  file >> all >> resident;
  return resident * 4096;
}

// One server for all tests, in this process.
class ServerTest : public testing::Test {
 protected:
  static void SetUpTestSuite() { run(true); }
  static void run(bool validate) {
    view::Start start{.scene = "builtin:boxes", .device = "cpu", .validate = validate, .width = 64, .height = 48};
    server = new Server({.sessions = kSessions, .requestTimeout = 0.5}, start);
    thread = new std::thread([] { EXPECT_NO_THROW(server->run()); });
    waitUntil([] { return get(server->port(), "/").starts_with("HTTP/1.1 403"); });
  }
  static void TearDownTestSuite() {
    server->stop();
    thread->join();
    delete thread;
    delete server;
  }

  static Client connected() { return Client(server->port(), server->token()); }
  // The number of pages with a session; sessions of closed pages end a little later.
  static Client client() {
    std::optional<Client> made;
    EXPECT_TRUE(waitUntil([&] {
      try {
        made.emplace(connected());
        made->show(made->hear());
        return true;
      } catch (const std::exception&) {
        return false;
      }
    }));
    return std::move(*made);
  }
  static Client resized(uint32_t width = 64, uint32_t height = 48) {
    Client made = client();
    made.say({{"type", "resize"}, {"width", width}, {"height", height}});
    return made;
  }
  static std::string page(const std::string& path, const std::string& more = "") {
    return get(server->port(), "/" + server->token() + "/" + path, more);
  }
  template <typename Condition>
  static bool waitUntil(const Condition& condition) {
    for (int i = 0; i < 36000; ++i) {  // half an hour, only against hangs
      if (condition()) return true;
      std::this_thread::sleep_for(50ms);
    }
    return false;
  }

  static Server* server;
  static std::thread* thread;
};
Server* ServerTest::server = nullptr;
std::thread* ServerTest::thread = nullptr;

// --- the page -------------------------------------------------------------------------------------------------------

TEST_F(ServerTest, GivesOutThePagesFiles) {
  const std::filesystem::path folder = LATELIGHT_SOURCE_DIR "/web/serve";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::string response = page(entry.path().filename());
    EXPECT_THAT(response, StartsWith("HTTP/1.1 200")) << entry.path();
    EXPECT_THAT(response, HasSubstr("Content-Security-Policy: default-src 'none'"));
    EXPECT_TRUE(response.ends_with("\r\n\r\n" + text)) << entry.path();
  }
  EXPECT_THAT(page(""), HasSubstr("<!doctype html>"));
}

TEST_F(ServerTest, RefusesOtherRequests) {
  const uint16_t port = server->port();
  const std::string token = server->token();
  for (const char* target : {"/", "/main.js", "/0123456789abcdef0123456789abcdef/", "/../../etc/passwd"})
    EXPECT_THAT(get(port, target), StartsWith("HTTP/1.1 403")) << target;
  for (const char* path : {"../../etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "..%2fetc", "/etc/passwd", "main.js/", "x"})
    EXPECT_THAT(page(path), StartsWith("HTTP/1.1 404")) << path;
  EXPECT_THAT(page("", "Host: evil.example.org\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(page("", "Origin: http://evil.example.org\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(ask(port, "POST /" + token + "/ HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"),
              StartsWith("HTTP/1.1 405"));
  for (const std::string& bytes :
       {std::string("\r\n\r\n"), std::string("\x16\x03\x01\x02\0\x01", 6), std::string("GET / HTTP/9.9\r\n\r\n"),
        std::string("GET / HTTP/1.1\r\nHost localhost\r\n\r\n")})
    EXPECT_THAT(ask(port, bytes), StartsWith("HTTP/1.1 400 Bad Request\r\n"));
  for (const std::string& bytes : {std::string(100'000, 'x'), "GET /" + std::string(20'000, 'a') + " HTTP/1.1\r\n\r\n",
                                   "GET / HTTP/1.1\r\nX: " + std::string(200'000, 'a') + "\r\n\r\n"})
    EXPECT_THAT(ask(port, bytes), StartsWith("HTTP/1.1 431 ")) << bytes.substr(0, 30);
  for (const char* body : {"Content-Length: 4\r\n\r\nbody", "Content-Length: 1000000000\r\n\r\n",
                           "Transfer-Encoding: chunked\r\n\r\n4\r\nbody\r\n0\r\n\r\n"})
    for (const std::string& path : {"/" + token + "/", std::string("/")})
      EXPECT_THAT(ask(port, "POST " + path + " HTTP/1.1\r\nHost: localhost\r\n" + body), StartsWith("HTTP/1.1 413 "))
          << body;
  EXPECT_THAT(page(""), StartsWith("HTTP/1.1 200"));
}

TEST_F(ServerTest, AnswersTheAbsoluteForm) {
  const std::string host = "localhost:" + std::to_string(server->port()), path = "/" + server->token() + "/main.js";
  const auto asked = [&](const std::string& target) {
    return ask(server->port(), "GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
  };
  EXPECT_THAT(asked("http://" + host + path), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(asked("http://evil.example" + path), StartsWith("HTTP/1.1 403"));
}

TEST_F(ServerTest, RefusesSocketsWithoutTheToken) {
  EXPECT_ANY_THROW(Client(server->port(), std::string(32, '0')));
  EXPECT_ANY_THROW(Client(server->port(), server->token(), "http://evil.example.org"));
  EXPECT_NO_THROW(Client(server->port(), server->token(), "http://127.0.0.1:" + std::to_string(server->port())));
}

// A request that never ends occupies its connection only until the server's timeout.
TEST_F(ServerTest, WaitsForNoRequestForLong) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THAT(ask(server->port(), "GET / HTTP/1.1\r\nHost: localhost\r\nX-Slow: "),
              StartsWith("HTTP/1.1 408 Request Timeout\r\n"));
  EXPECT_EQ(ask(server->port(), ""), "");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 20s);
}

// --- messages from pages --------------------------------------------------------------------------------------------

TEST_F(ServerTest, ClosesOnMalformedMessages) {
  const char* const kMessages[] = {
      "",
      "{",
      "[]",
      "null",
      "{}",
      R"({"type":7})",
      R"({"type":"nothing"})",
      R"({"type":"resize","width":-1,"height":10})",
      R"({"type":"resize","width":1e9,"height":10})",
      R"({"type":"resize","width":"64","height":48})",
      R"({"type":"move","x":null,"y":0})",
      R"({"type":"button","button":"fourth","down":true})",
      R"({"type":"option","name":"layout"})",
      R"({"type":"option","name":"layout","value":"compact","side":"middle"})",
      R"({"type":"split","mode":"slider","at":"half","amplification":1})",
      R"({"type":"environment","name":"/etc/passwd"})",
      R"({"type":"shown","number":-1})",
      R"({"type":"lights"})",
      R"({"type":"nudgeLight","light":0,"dx":1})",
      R"({"type":"moveLight","light":0,"position":[1,2]})",
      R"({"type":"moveLight","light":0,"position":[1,2,3,4]})",
      R"({"type":"moveLight","light":0,"position":[1,2,1e300]})",
      R"({"type":"moveLight","light":0,"position":[1,2,true]})",
      R"({"type":"moveLight","light":0,"position":{"x":1,"y":2,"z":3}})",
      R"({"type":"move","x":true,"y":0})",
      R"({"type":"file","name":"sky.png","bytes":10})",
      R"({"type":"file","name":"../sky.hdr","bytes":10})",
      R"({"type":"file","name":"sky.hdr","bytes":100000000})",
      "{\"type\":\"key\",\"name\":\"\xff\xfe\",\"down\":true}",
  };
  for (const char* message : kMessages) {
    Client bad = client();
    EXPECT_NO_THROW(bad.sayText(message));
    EXPECT_ANY_THROW(for (;;) bad.hear()) << message;
    EXPECT_TRUE(bad.closeCode() == 1008 || bad.closeCode() == 1007) << message << ": " << bad.closeCode();
  }
  Client binary = client(), more = client();
  more.sayText(R"({"type":"file","name":"sky.hdr","bytes":4})");
  more.sayBinary("12345");
  EXPECT_ANY_THROW(for (;;) more.hear());
  EXPECT_EQ(more.closeCode(), 1008);
  binary.sayBinary("{}");
  EXPECT_ANY_THROW(for (;;) binary.hear());
  EXPECT_EQ(binary.closeCode(), 1008);
}

// The server does not read a message that is far too long to its end, so the connection may break before the code
// arrives.
TEST_F(ServerTest, ClosesOnTooLongMessages) {
  const auto keyOf = [](size_t length) { return R"({"type":"key","name":")" + std::string(length, 'a') + "\"}"; };
  Client large = client(), huge = client();
  large.sayText(keyOf(kMaxOrderBytes));
  EXPECT_ANY_THROW(for (;;) large.hear());
  EXPECT_EQ(large.closeCode(), 1008);
  const auto sayAndHear = [&] {
    huge.sayText(keyOf(10 * kMaxPieceBytes));
    for (;;) huge.hear();
  };
  EXPECT_ANY_THROW(sayAndHear());
  EXPECT_TRUE(huge.closeCode() == 1009 || huge.closeCode() == 0) << huge.closeCode();
  EXPECT_NO_THROW(resized().hearFinal());
}

// The session explains messages that are well-formed but invalid.
TEST_F(ServerTest, SaysWhatOptionsCantBe) {
  Client page = resized();
  page.hearFinal();
  page.say({{"type", "option"}, {"name", "layout"}, {"value", "nothing"}});
  do page.show(page.hear());
  while (page.state()["error"] == "");
  EXPECT_THAT(page.state()["error"].get<std::string>(), HasSubstr("--layout"));
  EXPECT_EQ(page.state()["left"]["options"], Json::object());
}

// --- pictures -------------------------------------------------------------------------------------------------------

// The file that the command writes in a shell.
std::string rendered(const std::string& command, const app::Folder& folder = {}) {
  const app::Outcome outcome = app::latelightInShell(command, folder.path());
  EXPECT_EQ(outcome.code, 0) << command << ": " << outcome.err;
  return folder.read("picture.png");
}

std::string screenshot(Client& page) {
  page.say({{"type", "screenshot"}});
  for (;;) {
    Client::Message message = page.hear();
    page.show(message);
    if (message.header.contains("screenshot")) return message.payload;
  }
}

TEST_F(ServerTest, PicturesAreTheCommandLines) {
  Client page = resized(320, 200);
  page.say({{"type", "option"}, {"name", "sun"}, {"value", "30,50,2"}});
  page.say({{"type", "option"}, {"name", "background"}, {"value", "#336699"}});
  page.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", true}});
  const uint64_t last = page.say({{"type", "wheel"}, {"steps", 2}});
  Client::Message shown = page.hearFinal();
  while (shown.header["serial"] != last) shown = page.hearFinal();
  const std::string file = rendered(page.state()["leftCommand"]);
  EXPECT_EQ(screenshot(page), file) << page.state()["leftCommand"];

  const Decoded sent = decode(shown);
  const output::ReadImage exact = output::decodePng(std::as_bytes(std::span(file)), "picture.png");
  ASSERT_EQ(sent.width, exact.width);
  ASSERT_EQ(sent.height, exact.height);
  double squares = 0;
  for (size_t c = 0; c < 3; ++c)
    for (size_t i = 0; i < exact.channels[c].values.size(); ++i)
      squares += std::pow(static_cast<uint8_t>(sent.rgb[3 * i + c]) - 255.0 * exact.channels[c].values[i], 2);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(sent.rgb.size())), 4);  // JPEG of quality 92
}

// The command line names the file as the page did, for users who have it.
TEST_F(ServerTest, AnEnvironmentIsSentByThePage) {
  const app::Folder folder;
  const models::Bytes sky = models::radiancePanorama(64, 32);
  folder.write("SKY.HDR", sky);
  const std::string bytes(reinterpret_cast<const char*>(sky.data()), sky.size());
  Client page = resized();
  page.say({{"type", "option"}, {"name", "background"}, {"value", "hdri"}});
  const uint64_t last = page.say({{"type", "file"}, {"name", "SKY.HDR"}, {"bytes", bytes.size()}});
  for (size_t at = 0; at < bytes.size(); at += 1000) page.sayBinary(bytes.substr(at, 1000));
  while (page.hearFinal().header["serial"] != last) continue;
  EXPECT_EQ(page.state()["environment"], "SKY.HDR");
  EXPECT_EQ(screenshot(page), rendered(page.state()["leftCommand"], folder)) << page.state()["leftCommand"];
  page.say({{"type", "file"}, {"name", "broken.exr"}, {"bytes", 4}});
  page.sayBinary("none");
  do page.show(page.hear());
  while (page.state()["error"] == "");
  EXPECT_THAT(page.state()["error"].get<std::string>(), HasSubstr("broken.exr"));
  EXPECT_EQ(page.state()["environment"], "SKY.HDR");
}

// Runs another server during its lifetime.
struct Running {
  explicit Running(const std::string& scene, bool validate = true, const ServerOptions& options = {})
      : server(options, {.scene = scene, .device = "cpu", .validate = validate, .width = 64, .height = 48}),
        thread([this] { EXPECT_NO_THROW(server.run()); }) {}
  ~Running() {
    server.stop();
    thread.join();
  }
  Server server;
  std::thread thread;
};

TEST(ServerOfALitSceneTest, LightsAreToldWhereTheyAreWantedAndGoWhereTheyAreDragged) {
  Running running(models::modelPath("punctual.glb").string());
  Client page(running.server.port(), running.server.token());
  page.say({{"type", "resize"}, {"width", 64}, {"height", 48}});
  page.hearFinal();
  EXPECT_EQ(page.state()["lights"], Json::array());
  const auto until = [&](const auto& holds) {
    while (!holds()) page.show(page.hear());
  };
  page.say({{"type", "lights"}, {"on", true}});
  until([&] { return !page.state()["lights"].empty(); });
  const Json lights = page.state()["lights"];
  const auto seen = std::ranges::find_if(lights, [](const Json& light) { return !light["at"].is_null(); });
  ASSERT_NE(seen, lights.end());
  const auto light = static_cast<size_t>(seen - lights.begin());
  page.say({{"type", "dragLight"}, {"light", light}, {"x", 20}, {"y", 10}});
  until([&] { return page.state()["lightsMoved"] == true; });
  EXPECT_NEAR(page.state()["lights"][light]["at"][0].get<double>(), 20, 0.1);
  page.say({{"type", "moveLight"}, {"light", light}, {"position", (*seen)["position"]}});
  until([&] { return page.state()["lights"][light]["at"] == (*seen)["at"]; });
  page.say({{"type", "nudgeLight"}, {"light", light}, {"dx", -1}, {"dy", 3}});
  const double x = (*seen)["at"][0], y = (*seen)["at"][1];
  until([&] { return std::abs(page.state()["lights"][light]["at"][0].get<double>() - (x - 1)) < 0.1; });
  EXPECT_NEAR(page.state()["lights"][light]["at"][1].get<double>(), y + 3, 0.1);
  page.say({{"type", "lights"}, {"on", false}});
  until([&] { return page.state()["lights"].empty(); });
}

// --- a device that is lost ---

// The state of the page after it has followed this and no more messages come.
Client::Message hearRest(Client& page, uint64_t serial) {
  Client::Message picture;
  for (;;) {
    Client::Message message = page.hear();
    page.show(message);
    const bool rests = message.header.value("rests", false) && message.header["serial"] == serial;
    if (message.header.contains("picture")) picture = std::move(message);
    if (rests) return picture;
  }
}

// Each page has its own device. At each submission for a page it is lost: the page is told so once, and its next
// picture equals those of the others, whose devices go on.
TEST(ServerThatLosesADeviceTest, ThePageIsToldAndTheOthersGoOn) {
  DevicesToLose devices;
  Running running("builtin:boxes", false);
  Client unlucky(running.server.port(), running.server.token()), other(running.server.port(), running.server.token());
  const auto press = [](Client& page, const char* key) {
    return hearRest(page, page.say({{"type", "key"}, {"name", key}, {"down", true}}));
  };
  for (Client* page : {&unlucky, &other})
    hearRest(*page, page->say({{"type", "resize"}, {"width", 64}, {"height", 48}}));
  // What a page does; returns the sentences that it was shown.
  const auto work = [&] {
    std::set<std::string> sentences;
    const auto note = [&] { sentences.insert(unlucky.state()["error"].get<std::string>()); };
    for (const char* key : {"ArrowLeft", "7"}) press(unlucky, key), note();
    for (const Json& message :
         {Json{{"type", "output"}, {"name", "normal"}, {"side", "left"}},
          Json{{"type", "option"}, {"name", "layout"}, {"value", "thin"}, {"side", "left"}},
          Json{{"type", "split"}, {"mode", "slider"}, {"at", 0.5}, {"amplification", 8}},
          Json{{"type", "move"}, {"x", 20}, {"y", 20}},
          Json{{"type", "button"}, {"button", "left"}, {"down", true}, {"shift", false}},
          Json{{"type", "button"}, {"button", "left"}, {"down", false}, {"shift", false}}, Json{{"type", "reload"}}})
      hearRest(unlucky, unlucky.say(message)), note();
    unlucky.say({{"type", "screenshot"}, {"side", "left"}});
    for (;;) {
      const Client::Message said = unlucky.hear();
      unlucky.show(said);
      if (said.header.contains("failed")) sentences.insert(said.header["failed"].get<std::string>());
      if (said.header.contains("failed") || said.header.contains("screenshot")) break;
    }
    sentences.erase("");
    return sentences;
  };
  const auto restored = [&](Client& page) {
    for (const Json& message :
         {Json{{"type", "split"}, {"mode", "off"}, {"at", 0.5}, {"amplification", 8}},
          Json{{"type", "option"}, {"name", "layout"}, {"value", ""}, {"side", "left"}},
          Json{{"type", "output"}, {"name", "picture"}, {"side", "left"}}, Json{{"type", "camera"}, {"name", ""}}})
      page.say(message);
    for (const char* key : {"Escape", "Escape", "7"}) press(page, key);
    const std::string picture = press(page, "1").payload;
    EXPECT_NE(picture, "");
    EXPECT_EQ(page.state()["error"], "");
    return picture;
  };
  int losses = 0;
  for (int submission = 1;; submission += test::rounds(1, 8)) {
    SCOPED_TRACE(submission);
    devices.loseAt(submission);
    const std::set<std::string> sentences = work();
    if (!devices.hasLost()) break;
    ++losses;
    EXPECT_THAT(sentences, ElementsAre(HasSubstr("The device was lost")));
    EXPECT_EQ(other.state()["error"], "");
    const std::string picture = restored(unlucky);
    EXPECT_EQ(restored(other), picture);
  }
  EXPECT_GE(losses, 1);
  RecordProperty("losses", losses);
}

// A picture at full resolution during movement is encoded as coarsely as the network requires; the same one follows in
// good quality.
TEST_F(ServerTest, WholePicturesAreFineOnceTheyStandStill) {
  Client page = resized(48, 32);
  page.hearFinal();
  const auto hearPicture = [&] {
    for (;;) {
      const Client::Message message = page.hear();
      page.show(message);
      if (message.header.contains("picture")) return message;
    }
  };
  std::optional<Client::Message> moving;
  for (int i = 0; i < 200 && !moving; ++i) {  // drafts, until their size is known to be unnecessary
    page.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", true}});
    const Client::Message shown = hearPicture();
    if (shown.header["picture"]["final"] == false && shown.header["picture"]["width"] == 48) moving = shown;
  }
  ASSERT_TRUE(moving);
  EXPECT_LE(moving->header["picture"]["quality"], 85);
  const Client::Message fine = page.hearFinal();
  EXPECT_EQ(fine.header["picture"]["quality"], 92);
  EXPECT_EQ(fine.header["picture"]["width"], 48);
}

TEST_F(ServerTest, IdlePagesGetNothing) {
  Client page = resized();
  page.hearFinal();
  const auto hearsNothing = [&page] {
    if (!page.hearsWithin(1500ms)) return true;
    page.show(page.hear());
    return false;
  };
  bool idle = false;  // pictures in flight may arrive late
  for (int i = 0; i < 60 && !idle; ++i) idle = hearsNothing();
  EXPECT_TRUE(idle);
}

TEST_F(ServerTest, UnshownPicturesAreNotFollowedByMore) {
  Client page = resized();
  for (int heard = 0; heard < 2; ++heard) page.hear();
  for (int i = 0; i < 60; ++i) {
    page.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", true}});
    ASSERT_FALSE(page.hearsWithin(20ms)) << "after " << i << " keys";
  }
}

// --- many pages -----------------------------------------------------------------------------------------------------

// A session that still renders after its page was closed does not delay a reload.
TEST(ServerOfOneSessionTest, AReloadedPageGetsInAtOnce) {
  Running running("builtin:boxes", false, {.sessions = 1});
  for (int reload = 0; reload < 3; ++reload) {
    Client page(running.server.port(), running.server.token());
    EXPECT_NO_THROW(page.show(page.hear())) << page.closeReason();
    page.say({{"type", "option"}, {"name", "aa"}, {"value", "ss4"}});
    page.say({{"type", "resize"}, {"width", 800}, {"height", 600}});
    std::this_thread::sleep_for(100ms);  // it has started
  }
  Client page(running.server.port(), running.server.token());
  page.show(page.hear());
  testing::internal::CaptureStderr();
  Client second(running.server.port(), running.server.token());
  EXPECT_ANY_THROW(second.hear());
  EXPECT_THAT(second.closeReason(), HasSubstr("all 1 sessions"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              HasSubstr("refused 127.0.0.1: all 1 sessions are in use; close another page\n"));
}

// RFC 6455, 4.2.1 and 4.4: a handshake requires a key and version 13, and the answer to another version states it.
TEST(ServerOfHandshakesTest, RefusesInvalidOnes) {
  Running running("builtin:boxes", false);
  const std::string key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n", version = "Sec-WebSocket-Version: ";
  const auto asked = [&](const std::string& fields) {
    return ask(running.server.port(), "GET /" + running.server.token() +
                                          "/socket HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                                          "Connection: upgrade\r\n" +
                                          fields + "\r\n");
  };
  const std::pair<std::string, const char*> invalid[] = {
      {version + "13\r\n", "HTTP/1.1 400 "}, {key, "HTTP/1.1 400 "}, {key + version + "8\r\n", "HTTP/1.1 426 "}};
  for (const auto& [fields, status] : invalid) {
    testing::internal::CaptureStderr();
    const std::string response = asked(fields);
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("refused 127.0.0.1: The WebSocket handshake "))
        << fields;
    EXPECT_THAT(response, StartsWith(status)) << fields;
    for (const char* field : {"Content-Security-Policy: default-src 'none'", "Referrer-Policy: no-referrer",
                              "X-Content-Type-Options: nosniff", "Cache-Control: no-store", "Connection: close"})
      EXPECT_THAT(response, HasSubstr(field)) << fields;
  }
  EXPECT_THAT(asked(key + version + "8\r\n"), HasSubstr("Sec-WebSocket-Version: 13\r\n"));
}

// A page that opens while the scene file is being written is asked to try again (1013, "try again later"). Its reason
// is valid UTF-8 even if the 123 bytes of a close frame end within a character of the file's name.
TEST(ServerOfAChangingFileTest, APageThatOpensMeanwhileMayTryAgain) {
  const app::Folder folder;
  std::string name;
  while ((folder.at("").size() + name.size()) % 3 != 0) name += 'a';
  for (int i = 0; i < 40; ++i) name += "漢";
  const std::filesystem::path scene = folder.path() / (name + ".glb");
  std::filesystem::copy_file(models::modelPath("punctual.glb"), scene);
  for (const std::string before : {"", "a", "aa"}) {  // one of them ends at a character's end
    const std::filesystem::path path = folder.path() / (before + name + ".glb");
    if (!before.empty()) std::filesystem::rename(scene, path);
    Running running(path.string(), false);
    Client first(running.server.port(), running.server.token());
    first.show(first.hear());
    std::filesystem::rename(path, scene.string() + ".part");
    std::ofstream(path) << "glTF";
    testing::internal::CaptureStderr();
    Client second(running.server.port(), running.server.token());
    EXPECT_ANY_THROW(second.hear());
    EXPECT_EQ(second.closeCode(), 1013);
    EXPECT_THAT(second.closeReason(), HasSubstr("漢"));
    EXPECT_THAT(second.closeReason(), testing::EndsWith("..."));
    EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("refused 127.0.0.1: " + path.string()));
    EXPECT_THAT(Json(second.closeReason()).dump(), HasSubstr("漢")) << "dump() rejects other texts than UTF-8";
    std::filesystem::rename(scene.string() + ".part", path);
    Client third(running.server.port(), running.server.token());
    EXPECT_NO_THROW(third.hear());
    std::filesystem::rename(path, scene);
  }
}

// The program prints the address before run(), and a signal may follow at once.
TEST(ServerSignalsTest, ASignalBeforeRunEndsIt) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Server server({}, {.scene = "builtin:boxes", .device = "cpu", .width = 64, .height = 48});
    std::raise(signal);
    EXPECT_NO_THROW(server.run());
  }
}

// Idle connections are closed for new ones, the oldest first; sessions and pages with the token are not affected.
TEST(ServerInACrowdTest, SilentConnectionsKeepNobodyOut) {
  namespace asio = boost::asio;
  using asio::ip::tcp;
  Running running("builtin:boxes", false);
  const uint16_t port = running.server.port();
  Client page(port, running.server.token());
  page.show(page.hear());
  asio::io_context io;
  std::vector<tcp::socket> silent;
  for (int i = 0; i < 300; ++i) silent.emplace_back(io).connect({asio::ip::address_v4::loopback(), port});
  EXPECT_THAT(get(port, "/" + running.server.token() + "/"), StartsWith("HTTP/1.1 200"));
  EXPECT_NO_THROW(Client(port, running.server.token()).hear());
  page.say({{"type", "resize"}, {"width", 64}, {"height", 48}});
  EXPECT_NO_THROW(page.hearFinal());
  const auto isClosed = [](tcp::socket& socket) {
    char byte = 0;
    return recv(socket.native_handle(), &byte, 1, MSG_DONTWAIT) == 0;
  };
  EXPECT_TRUE(isClosed(silent.front()));
  EXPECT_FALSE(isClosed(silent.back()));
}

// --- memory ---------------------------------------------------------------------------------------------------------

// Limits the memory of this process during its lifetime.
struct MemoryLimit {
  explicit MemoryLimit(uint64_t bytes) { setMemoryLimit(bytes); }
  ~MemoryLimit() { setMemoryLimit(0); }
};

void announce(Client& page, const std::string& name, size_t bytes) {
  page.say({{"type", "file"}, {"name", name}, {"bytes", bytes}});
}

// While a picture is rendered, one page sends far more than it may queue.
TEST_F(ServerTest, OfFilesThatWaitTheLastIsKept) {
  constexpr size_t kBytes = 32 << 20, kPiece = 64 << 10;
  const models::Bytes sky = models::radiancePanorama(64, 32);
  std::string file(reinterpret_cast<const char*>(sky.data()), sky.size());
  file.resize(kBytes);  // bytes after the last pixel are ignored
  Client page = resized();
  page.hearFinal();
  const size_t bytesBefore = residentBytes();
  page.say({{"type", "option"}, {"name", "aa"}, {"value", "ss4"}});
  page.say({{"type", "resize"}, {"width", 640}, {"height", 480}});
  size_t most = 0;
  uint64_t last = 0;
  for (int i = 0; i < 8; ++i) {
    last = page.say({{"type", "file"}, {"name", "sky" + std::to_string(i) + ".hdr"}, {"bytes", kBytes}});
    for (size_t at = 0; at < kBytes; at += kPiece) page.sayBinary(file.substr(at, kPiece));
    most = std::max(most, residentBytes());
  }
  EXPECT_LT(most, bytesBefore + (192 << 20)) << "the picture, and two files of 32 MiB; not eight";
  page.say({{"type", "option"}, {"name", "aa"}, {"value", ""}});
  page.say({{"type", "resize"}, {"width", 64}, {"height", 48}});
  while (page.hearFinal().header["serial"] <= last) continue;
  EXPECT_EQ(page.state()["environment"], "sky7.hdr");
}

TEST_F(ServerTest, WithoutMemoryThereIsASentenceAndThePageGoesOn) {
  Client page = resized();
  page.hearFinal();
  const auto hearUntil = [&](const auto& holds) {
    for (;;) {
      const Client::Message message = page.hear();
      page.show(message);
      if (holds(message.header)) return message.header;
    }
  };
  {
    const MemoryLimit limit(1 << 20);
    announce(page, "sky.hdr", 2 << 20);
    for (int i = 0; i < 32; ++i) page.sayBinary(std::string(64 << 10, 'x'));
    const Json told = hearUntil([](const Json& header) { return header.contains("failed"); });
    EXPECT_THAT(told["failed"].get<std::string>(), StartsWith("there is no memory for the file 'sky.hdr'"));
    page.say({{"type", "screenshot"}});
    const Json shot = hearUntil([](const Json& header) { return header.contains("failed"); });
    EXPECT_THAT(shot["failed"].get<std::string>(), HasSubstr("there is no memory for"));
    page.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", true}});
    hearUntil([&](const Json&) { return page.state()["error"] != ""; });
    EXPECT_THAT(page.state()["error"].get<std::string>(), HasSubstr("there is no memory for"));
  }
  page.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", true}});
  EXPECT_NO_THROW(decode(page.hearFinal()));
  while (page.state()["error"] != "") page.show(page.hear());
}

// For a page that reads nothing, but reports every picture as shown, the server creates only two messages.
TEST(ViewerTest, NothingIsMadeForAPageThatDoesNotRead) {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<Message> sent;
  bool ended = false;
  Viewer::Calls calls;
  calls.send = [&](Message message) {
    const std::lock_guard lock(mutex);
    sent.push_back(std::move(message));
    changed.notify_all();
  };
  calls.fail = [](const Failure& failure) { ADD_FAILURE() << failure.sentence; };
  calls.ended = [&] {
    const std::lock_guard lock(mutex);
    ended = true;
    changed.notify_all();
  };
  Viewer viewer(nullptr, {.scene = "builtin:boxes", .device = "cpu", .width = 64, .height = 48}, calls);
  viewer.take({view::Resize{64, 48}});
  constexpr size_t kShots = 20;
  for (uint64_t i = 0; i < kShots; ++i) viewer.take({TakeScreenshot{view::Side::Left}});
  for (int i = 0; i < 20; ++i) {
    viewer.take({Shown{1'000'000}});
    std::this_thread::sleep_for(50ms);
    const std::lock_guard lock(mutex);
    ASSERT_LE(sent.size(), 2);
  }
  size_t written = 0, shots = 0;
  while (shots < kShots) {  // all of them are created once the page reads
    {
      std::unique_lock lock(mutex);
      ASSERT_TRUE(changed.wait_for(lock, 1800s, [&] { return sent.size() > written; }));
      shots += sent[written].bytes.find("\"screenshot\"") != std::string::npos;
      ++written;
    }
    viewer.wrote();
    viewer.take({Shown{written}});
  }
  viewer.stop();
  std::unique_lock lock(mutex);
  EXPECT_TRUE(changed.wait_for(lock, 1800s, [&] { return ended; }));
}

// Forwards bytes between a page and the server, with a limited rate towards the page.
class SlowNetwork {
 public:
  SlowNetwork(uint16_t port, double rate) : rate_(rate) {
    acceptor_.set_option(Tcp::acceptor::receive_buffer_size(16 << 10));
    thread_ = std::thread([this, port] { carry(port); });
  }
  ~SlowNetwork() {
    stops_ = true;
    thread_.join();
  }
  uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  using Tcp = boost::asio::ip::tcp;
  static constexpr auto kStep = 10ms;

  // Reads the available bytes, up to a limit.
  static void pass(Tcp::socket& from, Tcp::socket& to, size_t most) {
    std::vector<char> bytes(std::min(most, from.available()));
    if (bytes.empty()) return;
    bytes.resize(from.read_some(boost::asio::buffer(bytes)));
    boost::asio::write(to, boost::asio::buffer(bytes));
  }
  void carry(uint16_t port) {
    Tcp::socket page = acceptor_.accept(), server(io_);
    server.open(Tcp::v4());
    server.set_option(Tcp::socket::receive_buffer_size(16 << 10));  // otherwise the network itself would buffer more
    server.connect({boost::asio::ip::address_v4::loopback(), port});
    const auto step = static_cast<size_t>(rate_ * std::chrono::duration<double>(kStep).count());
    while (!stops_) {
      try {
        pass(page, server, 1 << 20);
        pass(server, page, step);
      } catch (const std::exception&) {
        return;
      }
      std::this_thread::sleep_for(kStep);
    }
  }

  const double rate_;
  boost::asio::io_context io_;
  Tcp::acceptor acceptor_{io_, {boost::asio::ip::address_v4::loopback(), 0}};
  std::atomic<bool> stops_ = false;
  std::thread thread_;
};

// Its pictures become coarse, few bytes wait for it, and other pages do not wait for it.
TEST_F(ServerTest, ASlowPageGetsCoarsePicturesAndHoldsUpNobody) {
  SlowNetwork network(server->port(), 50e3);
  Client slow(network.port(), server->token()), fast = resized();
  slow.say({{"type", "resize"}, {"width", 800}, {"height", 600}});
  slow.say({{"type", "option"}, {"name", "background"}, {"value", "#336699"}});
  slow.say({{"type", "output"}, {"name", "targets"}});
  const size_t bytesBefore = residentBytes();
  int finals = 0, fastPictures = 0;
  double quality = 100;
  size_t bytes = 0;
  for (int i = 0; finals < 4 && i < 20000; ++i) {
    if (slow.hearsWithin(0ms)) {
      const Client::Message message = slow.hear();
      slow.show(message);
      if (message.header.contains("picture") && message.header["picture"]["final"] == true) {
        ++finals, quality = message.header["picture"]["quality"], bytes = message.payload.size();
        slow.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", true}});
      }
    }
    fast.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", true}});
    while (fast.hearsWithin(5ms)) {
      const Client::Message message = fast.hear();
      fast.show(message);
      fastPictures += message.header.contains("picture");
    }
  }
  EXPECT_EQ(finals, 4);
  EXPECT_LT(quality, 92);
  EXPECT_LT(bytes, 100e3) << "it takes about a second";
  EXPECT_GT(fastPictures, 4 * finals);
  EXPECT_LT(residentBytes(), bytesBefore + (256 << 20)) << "what is rendered at that size, and two messages";
}

// Devices come and go on several threads at once, during which the validation layers of Debian 12 can crash
// (docs/quality.md).
class ReconnectsTest : public ServerTest {
 protected:
  static void SetUpTestSuite() { run(false); }
};

TEST_F(ReconnectsTest, EightLookAtOnceAndTheNinthWaits) {
  {
    std::vector<Client> pages;
    for (uint32_t i = 0; i < kSessions; ++i) pages.push_back(resized(64 + i, 48));
    for (uint32_t i = 0; i < kSessions; ++i) EXPECT_EQ(pages[i].hearFinal().header["picture"]["width"], 64 + i);
    Client ninth = connected();
    EXPECT_ANY_THROW(ninth.hear());
    EXPECT_EQ(ninth.closeCode(), 1013);
    EXPECT_THAT(ninth.closeReason(), HasSubstr("8 sessions"));
  }
  client();
}

// Pages that open and close, most of them in the middle of a request, leak nothing.
TEST_F(ReconnectsTest, GiveBackWhatTheyTook) {
  const auto comeAndGo = [](int i) {
    Client page = resized();
    if (i % 5 == 0) page.show(page.hear());
    if (i % 25 == 0) page.hearFinal();
  };
  const auto settles = [](size_t count, size_t (*now)()) { return waitUntil([&] { return now() <= count; }); };
  ASSERT_TRUE(waitUntil([] { return threads() <= 16; }));
  for (int i = 0; i < 10; ++i) comeAndGo(i);
  std::this_thread::sleep_for(1s);
  const size_t descriptorsBefore = descriptors(), threadsBefore = threads();
  const auto grown = [&] {
    const auto bytesBefore = static_cast<int64_t>(residentBytes());
    for (int i = 0; i < 100; ++i) comeAndGo(i);
    EXPECT_TRUE(settles(descriptorsBefore, descriptors)) << descriptors() << " of " << descriptorsBefore;
    EXPECT_TRUE(settles(threadsBefore, threads)) << threads() << " of " << threadsBefore;
    return static_cast<int64_t>(residentBytes()) - bytesBefore;
  };
  constexpr int64_t kEnough = 8 << 20;  // 80 kB per page; a leak would grow further with each round
  int64_t least = grown();
  for (int i = 0; i < 5 && least > kEnough; ++i) least = std::min(least, grown());
  EXPECT_LT(least, kEnough);
  RecordProperty("grown", static_cast<int>(least >> 10));
}

// --- random messages ------------------------------------------------------------------------------------------------

Json randomMessage(std::mt19937& random) {
  const auto upTo = [&](uint32_t most) { return std::uniform_int_distribution<uint32_t>(0, most)(random); };
  const auto one = [&](const auto& list) { return list[upTo(static_cast<uint32_t>(std::size(list)) - 1)]; };
  constexpr const char* kButtons[] = {"left", "middle", "right"};
  constexpr const char* kKeys[] = {"ArrowLeft", "ArrowUp", "Home", "o", "w", "1",      "7",    "f",
                                   " ",         "+",       "p",    "[", "]", "Escape", "Enter"};
  constexpr const char* kOutputs[] = {"picture", "depth", "normal", "id", "albedo", "targets", "nothing"};
  constexpr const char* kModes[] = {"off", "slider", "difference"};
  constexpr const char* kSides[] = {"left", "right"};
  constexpr const char* kTexts[] = {"", "0", "1", "none", "true", "-3", "fxaa", "x"};
  const bool down = upTo(1) == 1;
  switch (upTo(11)) {
    case 0:
    case 1:
    case 2:
      return {{"type", "move"}, {"x", upTo(80)}, {"y", upTo(60)}};
    case 3:
      return {{"type", "button"}, {"button", one(kButtons)}, {"down", down}, {"shift", upTo(3) == 0}};
    case 4:
      return {{"type", "wheel"}, {"steps", static_cast<int>(upTo(6)) - 3}};
    case 5:
    case 6:
      return {{"type", "key"}, {"name", one(kKeys)}, {"down", down}};
    case 7: {
      const auto options = render::options();
      const render::Option& option = options[upTo(static_cast<uint32_t>(options.size()) - 1)];
      const bool named = upTo(1) && !option.names.empty();
      const std::string value = named ? std::string(one(option.names).name) : one(kTexts);
      return {{"type", "option"}, {"name", render::keyOf(option)}, {"value", value}, {"side", one(kSides)}};
    }
    case 8:
      return {{"type", "output"}, {"name", one(kOutputs)}, {"side", one(kSides)}};
    case 9:
      return {{"type", "split"}, {"mode", one(kModes)}, {"at", 0.01 * upTo(100)}, {"amplification", upTo(20)}};
    case 10:
      return {{"type", "nudgeLight"}, {"light", upTo(3)}, {"dx", upTo(90)}, {"dy", upTo(60)}};
    default:
      return {{"type", upTo(1) ? "blur" : "leave"}};
  }
}

// Random options may contradict the scene, such as a light that it does not have. The page then rests with a sentence
// instead of a picture, until the options are restored.
TEST_F(ServerTest, RandomInputsEndInAPicture) {
  std::mt19937 random(13);
  Client page = resized(48, 32);
  page.hearFinal();
  for (int i = 0; i < 1000; ++i) {
    page.say(randomMessage(random));
    while (page.hearsWithin(0ms)) page.show(page.hear());
  }
  page.say({{"type", "blur"}});
  page.say({{"type", "split"}, {"mode", "off"}, {"at", 0.5}, {"amplification", 8}});
  page.say({{"type", "output"}, {"name", "picture"}});
  for (const render::Option& option : render::options())
    if (render::keyOf(option) != "size") page.say({{"type", "option"}, {"name", render::keyOf(option)}, {"value", ""}});
  const uint64_t last = page.say({{"type", "resize"}, {"width", 40}, {"height", 30}});
  Client::Message shown = page.hearFinal();
  while (shown.header["serial"] != last) shown = page.hearFinal();
  const Decoded picture = decode(shown);
  EXPECT_EQ(picture.width, 40u);
  EXPECT_EQ(picture.height, 30u);
}

}  // namespace
}  // namespace latelight::serve
