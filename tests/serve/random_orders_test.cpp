// Random orders and uploads against a server, by pages that hold its token: every kind of message with valid,
// borderline and invalid values, on several sessions at once. An invalid message must end its own session and nothing
// else, and what the server holds must stay level.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "long_tests.h"
#include "models/models.h"
#include "serve/client.h"
#include "serve/server.h"
#include "without_validation.h"

namespace latelight::serve {
namespace {

using namespace std::chrono_literals;
using Json = nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

// --- what a process holds -------------------------------------------------------------------------------------------

struct Footprint {
  size_t heap, descriptors, threads;
};

size_t entriesIn(const char* folder) {
  return size_t(std::distance(std::filesystem::directory_iterator(folder), {}));
}

Footprint footprint() {
  const struct mallinfo2 info = mallinfo2();
  return {info.uordblks + info.hblkhd, entriesIn("/proc/self/fd"), entriesIn("/proc/self/task")};
}

// Returns what the process holds once it has held no less for half a second: sessions end after their connections, each
// on a thread of its own.
Footprint settled() {
  Footprint least = footprint();
  for (int i = 0; i < 10; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    const Footprint now = footprint();
    if (now.threads >= least.threads && now.descriptors >= least.descriptors) continue;
    least = now;
    i = 0;
  }
  return footprint();
}

// --- random messages ------------------------------------------------------------------------------------------------

// The server accepts a message unless it is none of its page's; it then closes the connection. `pieces`: the binary
// messages that follow a file's announcement.
struct Said {
  std::string text;
  bool accepted = true;
  std::vector<std::string> pieces{};
};

class Messages {
 public:
  explicit Messages(uint32_t seed) : random_(seed) {}

  Said next() {
    const uint32_t kind = below(100);
    if (kind < 4) return invalid();
    if (kind < 8) return file();
    return valid();
  }
  uint32_t below(uint32_t count) { return random_() % count; }

 private:
  template <typename T>
  T pick(std::initializer_list<T> values) {
    return values.begin()[below(uint32_t(values.size()))];
  }
  std::string text(std::initializer_list<const char*> values) { return pick(values); }
  bool coin() { return below(2) != 0; }

  // Any number that JSON can express: pages compute coordinates, and nothing limits them.
  double number() {
    if (below(4) != 0) return int(below(400)) - 100 + below(16) / 16.0;
    return pick({0.0, -0.0, 1e-320, 1.0 / 3, -1e9, 1e19, 3e38, -1e300, 1.7976931348623157e308});
  }
  Json size() {
    if (below(4) != 0) return {{"type", "resize"}, {"width", 1 + below(64)}, {"height", 1 + below(64)}};
    const auto [width, height] = pick<std::pair<int, int>>({{0, 0}, {0, 64}, {1, 1}, {2048, 1}, {1, 2048}, {8192, 0}});
    return {{"type", "resize"}, {"width", width}, {"height", height}};
  }
  std::string name() {
    return pick<std::string>({"", "0", "1", "-1", "4294967296", "Camera", "no such name", "--", "\"", "<b>&amp;</b>",
                              "%s%n", "../../etc/passwd", "a\nb", "\xc3\xa9\xe2\x80\xae\xf0\x9f\x98\x80",
                              std::string(1, '\0'), std::string(1000, 'x')});
  }
  // Some values contradict others, or exceed their range. Options that are compiled into shaders have few values here,
  // because lavapipe compiles for seconds.
  Json option() {
    using Names = std::vector<std::string>;
    static const std::vector<std::pair<std::string, Names>> kOptions = {
        {"exposure", {"", "0", "2", "-3.5", "1e9", "nan", "auto", "1,2"}},
        {"tonemap", {"", "aces", "agx", "reinhard", "none", "all"}},
        {"background", {"", "transparent", "#fff", "#12345", "hdri", "red"}},
        {"camera-fit", {"", "vertical", "whole", "WHOLE"}},
        {"layout", {"", "compact", "exact", "none"}},
        {"lighting", {"", "clustered", "forward", "tiled "}},
        {"shadows", {"", "none", "d99"}},
        {"bloom", {"", "0.5", "2", "-1"}},
        {"time", {"", "0", "1e6", "1e7", "x"}},
        {"hdri-rotate", {"", "90", "1e300", "inf"}},
        {"hdri-intensity", {"", "0", "3", "-1"}},
        {"axes", {"", "z-up", "y-up"}},
        {"size", {"64x48", "99999x99999", "x"}},
        {"device", {"cpu", "0"}},
        {"o", {"/tmp/x.png"}},
        {"hdri", {"/etc/passwd", "studio"}},
        {"shaders", {"/tmp"}},
        {"", {"", "x"}}};
    const auto& [key, values] = kOptions[below(uint32_t(kOptions.size()))];
    const std::string value = below(8) == 0 ? name() : values[below(uint32_t(values.size()))];
    return {{"type", "option"}, {"name", (coin() ? "" : "--") + key}, {"value", value}, {"side", side()}};
  }
  std::string side() { return below(4) == 0 ? "right" : "left"; }
  Json light(const char* type, const char* x, const char* y) {
    return {{"type", type}, {"light", pick({0, 1, 63, 1 << 20})}, {x, number()}, {y, number()}};
  }
  Json position() {
    Json three = Json::array();
    for (int i = 0; i < 3; ++i) three.push_back(below(4) ? number() : pick({3e38, -3e38, 0.0}));
    for (Json& each : three)
      if (std::abs(each.get<double>()) > 3.4e38) each = 1;
    return three;
  }

  Said valid() {
    switch (below(21)) {
      case 0:
        return say({{"type", "shown"}, {"number", pick<uint64_t>({0, 1, 7, 1000, 1ull << 53})}});
      case 1:
        return say({{"type", "screenshot"}, {"side", side()}});
      case 2:
        return say(size());
      case 3:
        return say({{"type", "move"}, {"x", number()}, {"y", number()}});
      case 4:
        return say({{"type", text({"leave", "blur", "reload"})}, {"more", name()}});
      case 5:
        return say(
            {{"type", "button"}, {"button", text({"left", "middle", "right"})}, {"down", coin()}, {"shift", coin()}});
      case 6:
        return say({{"type", "wheel"}, {"steps", number()}});
      case 7:
      case 8: {
        const std::string key =
            text({"ArrowLeft", "ArrowUp", "Home", "Escape", "o", "w", "s", "1", "9", "p", "r", " "});
        return say({{"type", "key"}, {"name", below(8) ? key : name()}, {"down", coin()}, {"shift", coin()}});
      }
      case 9:
      case 10:
      case 11:
        return say(option());
      case 12:
        return say(
            {{"type", "output"},
             {"name", below(4) ? text({"picture", "depth", "normal", "id", "lights", "sheet", "targets"}) : name()},
             {"side", side()}});
      case 13:
        return say({{"type", "split"},
                    {"mode", text({"off", "slider", "difference"})},
                    {"at", number()},
                    {"amplification", number()}});
      case 14:
        return say({{"type", text({"camera", "variant"})}, {"name", name()}});
      case 15:
        return say({{"type", "environment"}, {"name", text({"studio", "none", ""})}});
      case 16:
        return say({{"type", "navigation"}, {"mode", text({"orbit", "fly"})}});
      case 17:
        return say({{"type", text({"play", "lights"})}, {"on", coin()}});
      case 18:
        return say({{"type", "moveLight"}, {"light", pick({0, 1, 63, 1 << 20})}, {"position", position()}});
      case 19:
        return say(light("dragLight", "x", "y"));
      default:
        return say(light("nudgeLight", "dx", "dy"));
    }
  }
  static Said say(const Json& message) { return {message.dump(-1, ' ', true)}; }

  // Bytes that are no picture, in pieces of which the last one may be missing: a later file replaces it.
  Said file() {
    const size_t bytes = below(300);
    Said said{Json{{"type", "file"}, {"name", text({"a.hdr", "b.exr", ".hdr"})}, {"bytes", bytes}}.dump()};
    for (size_t left = bytes; left > 0;) {
      const size_t count = std::min<size_t>(left, 1 + below(200));
      std::string piece(count, '\0');
      for (char& c : piece) c = char(below(256));
      said.pieces.push_back(piece);
      left -= count;
    }
    if (below(4) == 0 && !said.pieces.empty()) said.pieces.pop_back();
    return said;
  }

  // A message of which one value has the wrong type, range or name; or text that is no message at all.
  Said invalid() {
    static const std::vector<std::string> kInvalid = {
        "",
        "{",
        "[]",
        "null",
        "7",
        "{}",
        std::string(3000, '['),
        std::string(4096, ' ') + "{}",
        R"({"type":["resize"]})",
        R"({"type":"Resize","width":64,"height":48})",
        R"({"type":"resize","width":8193,"height":48})",
        R"({"type":"resize","width":-1,"height":48})",
        R"({"type":"resize","width":64.5,"height":48})",
        R"({"type":"resize","width":64})",
        R"({"type":"resize","width":18446744073709551616,"height":48})",
        R"({"type":"resize","width":64,"height":48,"serial":-1})",
        R"({"type":"resize","width":64,"height":48,"serial":9007199254740993})",
        R"({"type":"move","x":1e999,"y":0})",
        R"({"type":"move","x":"0","y":0})",
        R"({"type":"move","x":NaN,"y":0})",
        R"({"type":"button","button":"left","down":1})",
        R"({"type":"button","button":"Left","down":true})",
        R"({"type":"button","button":"left","down":true,"shift":"yes"})",
        R"({"type":"wheel","steps":null})",
        R"({"type":"key","name":7,"down":true})",
        R"({"type":"key","name":"w"})",
        R"({"type":"key","name":"\ud800","down":true})",
        R"({"type":"option","name":"layout","value":1})",
        R"({"type":"option","name":"layout","value":"compact","side":"both"})",
        R"({"type":"output","name":null})",
        R"({"type":"split","mode":"on","at":0.5,"amplification":8})",
        R"({"type":"split","mode":"slider","at":0.5})",
        R"({"type":"camera"})",
        R"({"type":"environment","name":"sky.hdr"})",
        R"({"type":"environment","name":"../../etc/passwd"})",
        R"({"type":"navigation","mode":"walk"})",
        R"({"type":"play","on":"true"})",
        R"({"type":"variant","name":{}})",
        R"({"type":"lights","on":null})",
        R"({"type":"moveLight","light":1048577,"position":[0,0,0]})",
        R"({"type":"moveLight","light":0,"position":[0,0]})",
        R"({"type":"moveLight","light":0,"position":[0,0,1e39]})",
        R"({"type":"dragLight","light":-1,"x":0,"y":0})",
        R"({"type":"nudgeLight","light":0,"dx":0,"dy":false})",
        R"({"type":"shown","number":9007199254740993})",
        R"({"type":"shown","number":"1"})",
        R"({"type":"screenshot","side":"top"})",
        R"({"type":"file","name":"sky.png","bytes":1})",
        R"({"type":"file","name":"a/sky.hdr","bytes":1})",
        R"({"type":"file","name":"sky.hdr","bytes":67108865})",
        R"({"type":"file","name":"sky.hdr","bytes":-1})",
        R"({"type":"file","name":"sky.hdr"})"};
    return {kInvalid[below(uint32_t(kInvalid.size()))], false};
  }

  std::minstd_rand random_;
};

// --- pages ----------------------------------------------------------------------------------------------------------

class RandomOrdersTest : public testing::Test {
 protected:
  RandomOrdersTest()
      : server_({.requestTimeout = 60}, {.scene = "builtin:boxes", .device = "cpu", .width = 64, .height = 48}),
        thread_([this] { EXPECT_NO_THROW(server_.run()); }) {}
  ~RandomOrdersTest() override {
    server_.stop();
    thread_.join();
  }

  // Sessions of earlier connections may still be ending.
  std::unique_ptr<Client> page() {
    for (int attempt = 0;; ++attempt) {
      try {
        auto page = std::make_unique<Client>(server_.port(), server_.token());
        page->show(page->hear());
        return page;
      } catch (const std::exception& refused) {
        if (attempt == 600) throw;
        std::this_thread::sleep_for(50ms);
      }
    }
  }

  // The server's own page, as a browser opens it: its document, and a picture.
  void expectServes() {
    EXPECT_THAT(get(server_.port(), "/" + server_.token() + "/"), StartsWith("HTTP/1.1 200"));
    const auto own = page();
    own->say({{"type", "resize"}, {"width", 64}, {"height", 48}});
    const Decoded shown = decode(own->hearFinal());
    if (first_.empty()) first_ = shown.rgb;
    EXPECT_EQ(shown.rgb, first_) << "orders of other pages changed the picture";
  }

  // Reads and shows what the page was sent so far.
  static void read(Client& page) {
    while (page.hearsWithin(0ms)) page.show(page.hear());
  }
  static void say(Client& page, const Said& said) {
    page.sayText(said.text);
    for (const std::string& piece : said.pieces) page.sayBinary(piece);
  }
  // Returns the code with which the server closes a connection; 0: without one.
  static uint16_t closeCodeOf(Client& page) {
    try {
      for (;;) page.hear();
    } catch (const std::exception&) {
      return page.closeCode();
    }
  }
  // Waits until the session has followed all orders, and returns its last header.
  static Json finish(Client& page) {
    const uint64_t last = page.say({{"type", "leave"}});
    for (;;) {
      const Client::Message message = page.hear();
      page.show(message);
      if (message.header["serial"] >= last) return message.header;
    }
  }

  void expectLevel(const std::vector<Footprint>& footprints, size_t maxMegabytes);

  const test::WithoutValidation layers_;  // the layer keeps everything that it has seen
  Server server_;
  std::thread thread_;
  std::string first_;
};

// In the second half there are no more descriptors and threads than in the first, and the heap is about as large.
void RandomOrdersTest::expectLevel(const std::vector<Footprint>& footprints, size_t maxMegabytes) {
  const auto [early, late] = std::pair(std::span(footprints).first(footprints.size() / 2),
                                       std::span(footprints).subspan(footprints.size() / 2));
  const auto most = [](std::span<const Footprint> of, size_t Footprint::*what) {
    return (*std::ranges::max_element(of, {}, what)).*what;
  };
  EXPECT_LE(most(late, &Footprint::descriptors), most(early, &Footprint::descriptors));
  EXPECT_LE(most(late, &Footprint::threads), most(early, &Footprint::threads));
  EXPECT_LT(most(late, &Footprint::heap), most(early, &Footprint::heap) + maxMegabytes * 1'000'000);
}

std::string bytesOf(const models::Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST_F(RandomOrdersTest, EndOnlyTheirOwnSession) {
  const uint32_t count = test::rounds(9000u, 400u), inBatch = count / 20;
  constexpr size_t kPages = 3;
  Messages messages(20);
  uint32_t refused = 0;
  std::vector<Footprint> footprints;
  expectServes();
  for (uint32_t begin = 0; begin < count; begin += inBatch) {
    std::vector<std::unique_ptr<Client>> pages;
    for (size_t i = 0; i < kPages; ++i) pages.push_back(page());
    for (uint32_t i = begin; i < begin + inBatch; ++i) {
      std::unique_ptr<Client>& page = pages[messages.below(kPages)];
      const Said said = messages.next();
      SCOPED_TRACE(fmt::format("message {}: {}", i, said.text.substr(0, 200)));
      ASSERT_NO_THROW(read(*page));
      ASSERT_NO_THROW(say(*page, said));
      if (said.accepted) continue;
      ++refused;
      EXPECT_EQ(closeCodeOf(*page), 1008);
      page = this->page();
    }
    for (const auto& page : pages) ASSERT_NO_THROW(finish(*page)) << "after message " << begin + inBatch - 1;
    pages.clear();
    expectServes();
    footprints.push_back(settled());
    fmt::print("{} orders, {} refused: heap {}, descriptors {}, threads {}\n", begin + inBatch, refused,
               footprints.back().heap, footprints.back().descriptors, footprints.back().threads);
    std::fflush(stdout);
  }
  EXPECT_GT(refused, count / 50);
  expectLevel(footprints, 1);
}

// Pages can send environments only: Radiance and OpenEXR files, complete, cut off, or with changed bytes. A complete
// one is used, a file that is cut off is explained and changes nothing, and changed bytes do one or the other.
TEST_F(RandomOrdersTest, UploadsAreUsedOrExplained) {
  const int count = test::rounds(120, 24);
  const std::map<std::string, std::string> files = {{".hdr", bytesOf(models::radiancePanorama(32, 16))},
                                                    {".exr", bytesOf(models::exrPanorama(32, 16))}};
  std::minstd_rand random(7);
  auto page = this->page();
  page->say({{"type", "resize"}, {"width", 32}, {"height", 24}});
  std::string used = "", last;
  int usable = 0, explained = 0;
  std::vector<Footprint> footprints;
  for (int i = 0; i < count; ++i) {
    const auto& [end, whole] = *std::next(files.begin(), i / 3 % 2);
    std::string bytes = whole;
    if (i % 3 == 1) bytes.resize(1 + random() % (whole.size() * 9 / 10));
    if (i % 3 == 2)
      for (uint32_t changes = 1 + random() % 8; changes > 0; --changes) bytes[random() % bytes.size()] = char(random());
    last = fmt::format("file{}{}", i, end);
    page->say({{"type", "file"}, {"name", last}, {"bytes", bytes.size()}});
    for (size_t at = 0; at < bytes.size(); at += 1500) page->sayBinary(bytes.substr(at, 1500));
    finish(*page);
    const std::string environment = page->state()["environment"], error = page->state()["error"];
    if (environment == last) {
      EXPECT_NE(i % 3, 1) << last << " was cut off after " << bytes.size() << " of " << whole.size() << " bytes";
      EXPECT_TRUE(error.empty() || i % 3 == 2) << error;  // changed bytes may make an image too large for the device
      used = last;
      ++usable;
    } else {
      EXPECT_NE(i % 3, 0) << last << ": " << error;
      EXPECT_THAT(error, HasSubstr(last));
      EXPECT_EQ(environment, used);
      ++explained;
    }
    if (i % 6 != 0) continue;
    footprints.push_back(settled());  // with the same complete file; changed ones may be larger
    fmt::print("{} files: heap {}\n", i + 1, footprints.back().heap);
  }
  fmt::print("{} files were used, {} explained\n", usable, explained);
  EXPECT_GE(usable, count / 3);
  EXPECT_GE(explained, count / 3);
  page.reset();
  expectServes();
  expectLevel(footprints, 8);  // a session keeps memory blocks for later images
}

}  // namespace
}  // namespace latelight::serve
