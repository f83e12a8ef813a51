// bench_serve [SCENE] [WIDTHxHEIGHT] [SECONDS] [DEVICE]: measures pictures per second while the camera moves, and the
// latency from a key to its picture in milliseconds, by stage. The page is simulated in this process and decodes each
// picture on one thread. Validation is off.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "serve/client.h"
#include "serve/server.h"

namespace latelight::serve {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::json;

double since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

// Returns the next picture after decoding and showing it.
struct Heard {
  Json picture;
  uint64_t serial = 0;  // of the input that it follows
  double decoding = 0;  // in milliseconds
};
Heard hearPicture(Client& page) {
  for (;;) {
    const Client::Message message = page.hear();
    const auto begin = Clock::now();
    if (message.header.contains("picture")) decode(message);
    const double decoding = 1000 * since(begin);
    page.show(message);
    if (message.header.contains("picture")) return {message.header["picture"], message.header["serial"], decoding};
  }
}

void drag(Client& page, int step) {
  page.say({{"type", "move"}, {"x", 300 + 5 * step % 400}, {"y", 300}});
}

// Like a mouse: some two hundred events per second, whether pictures arrive or not.
Client::Message hearWhileDragging(Client& page, int& step) {
  for (;;) {
    do drag(page, ++step);
    while (!page.hearsWithin(std::chrono::milliseconds(5)));
    Client::Message message = page.hear();
    page.show(message);
    if (!message.header.contains("picture")) continue;
    decode(message);
    return message;
  }
}

void measureRate(Client& page, double seconds) {
  page.say({{"type", "move"}, {"x", 300}, {"y", 300}});
  page.say({{"type", "button"}, {"button", "left"}, {"down", true}});
  int step = 0;
  for (const auto begin = Clock::now(); since(begin) < 2;) hearWhileDragging(page, step);  // lets it find its pace
  int pictures = 0;
  size_t bytes = 0;
  double rendering = 0;
  Json last;
  const auto begin = Clock::now();
  for (; since(begin) < seconds; ++pictures) {
    const Client::Message shown = hearWhileDragging(page, step);
    bytes += shown.payload.size();
    rendering += shown.header["picture"]["milliseconds"].get<double>();
    last = shown.header["picture"];
  }
  const double time = since(begin);
  page.say({{"type", "button"}, {"button", "left"}, {"down", false}});
  fmt::print("moving: {:.1f} pictures a second, {}x{}, quality {}, {:.0f} kB and {:.1f} ms of rendering each\n",
             pictures / time, last["width"].get<int>(), last["height"].get<int>(), last["quality"].get<int>(),
             static_cast<double>(bytes) / pictures / 1000, rendering / pictures);
}

// From rest, as for a key press. The rest of the time is transfer and waiting.
void measureLatency(Client& page, int times) {
  std::vector<double> waits, rendering, encoding, decoding, ways, finals;
  for (int i = 0; i < times; ++i) {
    const auto begin = Clock::now();
    const uint64_t serial = page.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", true}});
    Heard shown = hearPicture(page);
    while (shown.serial < serial) shown = hearPicture(page);
    waits.push_back(1000 * since(begin));
    rendering.push_back(shown.picture["milliseconds"]);
    encoding.push_back(shown.picture["encoding"]);
    decoding.push_back(shown.decoding);
    ways.push_back(waits.back() - rendering.back() - encoding.back() - decoding.back());
    while (!shown.picture["final"].get<bool>()) shown = hearPicture(page);
    finals.push_back(1000 * since(begin));
    page.say({{"type", "key"}, {"name", "ArrowLeft"}, {"down", false}});
  }
  fmt::print("a key to its picture: {:.1f} ms, the slowest of {} {:.1f} ms; to the final one: {:.1f} ms\n",
             median(waits), times, std::ranges::max(waits), median(finals));
  fmt::print(
      "  of these: rendering {:.1f} ms, encoding {:.1f} ms, decoding {:.1f} ms, the way and the rest {:.1f} ms\n",
      median(rendering), median(encoding), median(decoding), median(ways));
}

// Runs until it is stopped.
struct Running {
  Server& server;
  std::thread thread;
  ~Running() {
    server.stop();
    thread.join();
  }
};

void bench(int argc, char** argv) {
  const auto argument = [&](int i, const char* normal) { return std::string(i < argc ? argv[i] : normal); };
  const std::string size = argument(2, "1280x720");
  const auto width = static_cast<uint32_t>(std::stoul(size)),
             height = static_cast<uint32_t>(std::stoul(size.substr(size.find('x') + 1)));
  Server server(
      {}, {.scene = argument(1, "builtin:hall"), .device = argument(4, "auto"), .width = width, .height = height});
  const Running running{server, std::thread([&] { server.run(); })};
  {
    Client page(server.port(), server.token());
    page.say({{"type", "resize"}, {"width", width}, {"height", height}});
    page.hearFinal();
    fmt::print("{} on {}, {}\n", argument(1, "builtin:hall"), server.device(), size);
    measureRate(page, std::stod(argument(3, "10")));
    page.hearFinal();
    measureLatency(page, 20);
  }
}

}  // namespace
}  // namespace latelight::serve

int main(int argc, char** argv) {
  try {
    latelight::serve::bench(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_serve: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
