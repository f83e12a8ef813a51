#include "viewer/screen.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

#include "app/process.h"

namespace latelight::app {

namespace {

// Reads a big-endian number from an XWD file's header (X11's XWDFile.h).
uint32_t wordAt(const std::string& bytes, size_t index) {
  uint32_t word = 0;
  for (size_t i = 0; i < 4; ++i) word = word << 8 | static_cast<uint8_t>(bytes.at(4 * index + i));
  return word;
}
constexpr size_t kHeaderSize = 0, kBytesPerLine = 12, kColors = 19;

}  // namespace

Screen::Screen(uint32_t width, uint32_t height) {
  std::array<int, 2> pipe{};
  if (::pipe(pipe.data()) != 0) throw std::runtime_error("no pipe");
  const std::string size = fmt::format("{}x{}x24", width, height), number = fmt::format("{}", pipe[1]);
  server_ = fork();
  if (server_ == 0) {
    const int nothing = open("/dev/null", O_WRONLY);
    dup2(nothing, STDERR_FILENO);
    execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", size.c_str(), "-fbdir", folder_.path().c_str(),
           "-nolisten", "tcp", "-noreset", static_cast<char*>(nullptr));
    _exit(127);
  }
  close(pipe[1]);
  // Reads the display's number, which Xvfb prints when it is ready; the end of the line is written separately.
  name_ = ":";
  for (char c = 0; read(pipe[0], &c, 1) == 1 && c != '\n';) name_ += c;
  close(pipe[0]);
  if (name_.size() > 1) return;
  stop();
  throw std::runtime_error("Xvfb does not start; it is in the package xvfb");
}

Screen::~Screen() {
  stop();
}

void Screen::stop() {
  if (server_ < 0) return;
  kill(server_, SIGTERM);
  waitpid(server_, nullptr, 0);
  server_ = -1;
}

void Screen::act(std::vector<std::string> words) const {
  const Outcome outcome =
      runProcess("/usr/bin/xdotool", {.arguments = std::move(words), .environment = {{"DISPLAY", name_}}});
  if (outcome.code != 0) throw std::runtime_error("xdotool: " + outcome.text());
}

output::Picture Screen::pixels(uint32_t width, uint32_t height, uint32_t top) const {
  const std::string file = folder_.read("Xvfb_screen0");
  const size_t line = wordAt(file, kBytesPerLine),
               first = wordAt(file, kHeaderSize) + size_t{12} * wordAt(file, kColors);
  output::Picture picture{width, height, {}};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const char* bgr = &file.at(first + (top + y) * line + 4 * size_t{x});
      for (const int c : {2, 1, 0}) picture.rgba.push_back(static_cast<uint8_t>(bgr[c]));
      picture.rgba.push_back(255);
    }
  return picture;
}

}  // namespace latelight::app
