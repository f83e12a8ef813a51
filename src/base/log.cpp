#include "base/log.h"

#include <latelight/latelight.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <memory>
#include <mutex>
#include <unordered_set>
#include <utility>

#include "base/fork.h"
#include "base/journal.h"
#include "base/utf8.h"

namespace latelight {
namespace {

using Clock = std::chrono::steady_clock;
constexpr auto kInterval = std::chrono::milliseconds(100);  // interval between two redraws
constexpr int kBarWidth = 30;                               // characters
constexpr const char* kClearLine = "\r\x1b[K";

using WarningHandler = std::function<void(const std::string&)>;

std::atomic<bool> quiet = false, showsProgress = false;
ForkSafeMutex terminal;  // held while writing to standard error
int visibleBars = 0;     // number of bars on the terminal's last line (guarded by `terminal`)
std::shared_ptr<const WarningHandler> warningHandler;  // null: standard error (guarded by `terminal`)
thread_local std::vector<std::string>* capture = nullptr;

bool isTerminal() {
  return isatty(STDERR_FILENO) == 1;
}

// Implements https://no-color.org: NO_COLOR is present and not empty.
bool wantsColor() {
  const char* off = std::getenv("NO_COLOR");
  return isTerminal() && (!off || !*off);
}

bool isShown(uint32_t code) {
  const auto within = [&](uint32_t first, uint32_t last) { return code >= first && code <= last; };
  const bool control = code < 0x20 || within(0x7f, 0x9f);
  const bool line = within(0x2028, 0x2029);
  // Unicode's property Bidi_Control.
  const bool direction = code == 0x61c || within(0x200e, 0x200f) || within(0x202a, 0x202e) || within(0x2066, 0x2069);
  return code != Utf8Character::kInvalid && !control && !line && !direction;
}

}  // namespace

std::string printable(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::string_view rest = text; !rest.empty();) {
    const Utf8Character character = firstUtf8Character(rest);
    result += isShown(character.code) ? rest.substr(0, character.bytes) : "?";
    rest.remove_prefix(character.bytes);
  }
  return result;
}

WarningCapture::WarningCapture(std::vector<std::string>& captured) : previous_(std::exchange(capture, &captured)) {}
WarningCapture::~WarningCapture() {
  capture = previous_;
}

void warn(const std::string& sentence) {
  if (quiet) return;
  if (capture) {
    capture->push_back(sentence);
    return;
  }
  static std::unordered_set<std::string> logged;
  std::unique_lock lock(terminal);
  if (const std::shared_ptr<const WarningHandler> handler = warningHandler) {
    lock.unlock();
    (*handler)(printable(sentence));
    return;
  }
  if (!logged.insert(sentence).second) return;
  const bool color = wantsColor();
  const std::string line = fmt::format("{}{}warning:{} {}\n", visibleBars ? kClearLine : "", color ? "\x1b[33m" : "",
                                       color ? "\x1b[0m" : "", printable(sentence));
  std::fputs(line.c_str(), stderr);
}

void record(const std::string& sentence) {
  if (quiet) return;
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::lock_guard lock(terminal);
  const std::string line = fmt::format("{}{:02}:{:02}:{:02} {}\n", visibleBars ? kClearLine : "", utc.tm_hour,
                                       utc.tm_min, utc.tm_sec, printable(sentence));
  std::fputs(line.c_str(), stderr);
}

void setQuiet(bool value) {
  quiet = value;
}

void showProgress(bool shown) {
  showsProgress = shown;
}

void setWarningHandler(WarningHandler handler) {
  auto shared = handler ? std::make_shared<const WarningHandler>(std::move(handler)) : nullptr;
  std::lock_guard lock(terminal);
  warningHandler.swap(shared);
}

struct Progress::State {
  std::string what;
  uint64_t total;
  Clock::duration silence;
  std::atomic<uint64_t> done = 0;
  std::atomic<Clock::rep> nextDraw = (Clock::now() + silence).time_since_epoch().count();
  bool drawn = false;  // guarded by `terminal`

  void draw() {
    const uint64_t now = std::min(done.load(), total);
    const int percent = static_cast<int>(100.0 * static_cast<double>(now) / static_cast<double>(total));
    const int filled = kBarWidth * percent / 100;
    std::lock_guard lock(terminal);
    if (!drawn) ++visibleBars;
    drawn = true;
    const std::string line =
        fmt::format("{}{} [{:#<{}}{:-<{}}] {:3}%", kClearLine, what, "", filled, "", kBarWidth - filled, percent);
    std::fputs(line.c_str(), stderr);
  }
};

Progress::Progress(std::string_view what, uint64_t total, double silence)
    : state_(quiet || !showsProgress || total == 0 || !isTerminal()
                 ? nullptr
                 : new State{printable(what), total,
                             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(silence))}) {}

Progress::~Progress() {
  if (state_ && state_->drawn) {
    std::lock_guard lock(terminal);
    --visibleBars;
    std::fputs(kClearLine, stderr);
  }
  delete state_;
}

void Progress::step(uint64_t count) {
  if (!state_) return;
  state_->done += count;
  const Clock::time_point now = Clock::now();
  Clock::rep due = state_->nextDraw;
  if (now.time_since_epoch().count() < due) return;
  // If several threads find a redraw due, only one draws.
  if (state_->nextDraw.compare_exchange_strong(due, (now + kInterval).time_since_epoch().count())) state_->draw();
}

}  // namespace latelight
