#include "base/log.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <latelight/latelight.h>
#include <pty.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

namespace latelight {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string capture(const std::function<void()>& call) {
  testing::internal::CaptureStderr();
  call();
  return testing::internal::GetCapturedStderr();
}

// Returns what `call` writes to standard error if that is a terminal.
std::string onTerminal(const std::function<void()>& call) {
  int ours = -1, theirs = -1;
  if (openpty(&ours, &theirs, nullptr, nullptr, nullptr) != 0) return "no terminal";
  std::fflush(stderr);
  const int saved = dup(STDERR_FILENO);
  dup2(theirs, STDERR_FILENO);
  call();
  std::fflush(stderr);
  dup2(saved, STDERR_FILENO);
  close(theirs);  // reading then ends with an error after the last output
  std::string text;
  char buffer[4096];
  for (ssize_t got = 0; (got = read(ours, buffer, sizeof(buffer))) > 0;) text.append(buffer, static_cast<size_t>(got));
  for (const int fd : {saved, ours}) close(fd);
  return text;
}

// Half of some work that displays no bar for the first `silence` seconds.
void work(double silence) {
  showProgress(true);
  Progress progress("loading", 100, silence);
  progress.step(50);
}
constexpr double kHour = 3600;

TEST(Warn, SaysTheSameSentenceOnce) {
  const auto say = [] {
    warn("a lamp is {}", "dark");
    warn("a lamp is {}", "dark");
    warn("another lamp is dark");
  };
  EXPECT_EQ(capture(say), "warning: a lamp is dark\nwarning: another lamp is dark\n");
  EXPECT_EQ(capture(say), "");
}

TEST(Warn, IsSilentWhenQuiet) {
  setQuiet(true);
  EXPECT_EQ(capture([] { warn("unheard"); }), "");
  setQuiet(false);
  EXPECT_EQ(capture([] { warn("unheard"); }), "warning: unheard\n");
}

TEST(Warn, LetsNoControlSequenceThrough) {
  EXPECT_EQ(capture([] { warn("node '{}'", "\x1b[2J\nx"); }), "warning: node '?[2J?x'\n");
}

TEST(Printable, KeepsTextAndNothingThatActsOnATerminal) {
  EXPECT_EQ(printable("Grüße, 東京 🙂 ~"), "Grüße, 東京 🙂 ~");
  EXPECT_EQ(printable("a\tb\rc\x7f"), "a?b?c?");
  EXPECT_EQ(printable("\u0085\u009b2J"), "??2J") << "C1 controls";
  EXPECT_EQ(printable("\x9b"
                      "2J\xff"),
            "?2J?")
      << "bytes that are no UTF-8, and C1 controls on 8-bit terminals";
  EXPECT_EQ(printable("a\u2028b\u202ec\u2066d"), "a?b?c?d") << "ends of lines, and turns of direction";
  EXPECT_EQ(printable("a\u061cb\u200ec\u200fd"), "a?b?c?d") << "marks of direction";
  EXPECT_EQ(printable("\xc0\xaf\xed\xa0\x80\xf4\x90\x80\x80\xe2\x82"), std::string(11, '?'))
      << "overlong, surrogate, too large, cut";
}

TEST(Warn, IsColouredOnTerminalsUnlessNoColorIsSet) {
  unsetenv("NO_COLOR");
  EXPECT_THAT(onTerminal([] { warn("in colour"); }), HasSubstr("\x1b[33mwarning:"));
  setenv("NO_COLOR", "1", 1);
  EXPECT_THAT(onTerminal([] { warn("in black and white"); }), Not(HasSubstr("\x1b[")));
  unsetenv("NO_COLOR");
}

TEST(Warn, CallsTheHandlerWithEveryWarningInsteadOfWriting) {
  std::vector<std::string> heard;
  const auto say = [] {
    warn("a bell\a {}", "rings");
    warn("a bell\a {}", "rings");
  };
  setWarningHandler([&](const std::string& sentence) { heard.push_back(sentence); });
  EXPECT_EQ(capture(say), "");
  EXPECT_THAT(heard, testing::ElementsAre("a bell? rings", "a bell? rings"));
  setWarningHandler({});
  EXPECT_EQ(capture(say), "warning: a bell? rings\n");
  EXPECT_EQ(heard.size(), 2u);
}

TEST(Warn, HandlersMayReplaceThemselves) {
  setWarningHandler([](const std::string&) { setWarningHandler({}); });
  EXPECT_EQ(capture([] { warn("the first"); }), "");
  EXPECT_EQ(capture([] { warn("the second"); }), "warning: the second\n");
}

TEST(Progress, IsNotShownByALibrary) {
  showProgress(false);
  EXPECT_EQ(onTerminal([] {
              Progress progress("loading", 100, 0);
              progress.step(50);
            }),
            "");
}

TEST(Progress, IsForTerminalsOnly) {
  EXPECT_EQ(capture([] { work(0); }), "");
}

TEST(Progress, KeepsQuietAboutShortWork) {
  EXPECT_EQ(onTerminal([] { work(kHour); }), "");
}

TEST(Progress, ShowsABarAndClearsIt) {
  const std::string text = onTerminal([] { work(0); });
  EXPECT_THAT(text, HasSubstr("loading [###############---------------]  50%"));
  EXPECT_TRUE(text.ends_with("\r\x1b[K"));
}

TEST(Progress, IsSilentWhenQuiet) {
  setQuiet(true);
  EXPECT_EQ(onTerminal([] { work(0); }), "");
  setQuiet(false);
}

TEST(Progress, TakesATotalOfZeroAndTooManySteps) {
  showProgress(true);
  EXPECT_EQ(onTerminal([] { Progress("nothing", 0, 0).step(); }), "");
  const std::string text = onTerminal([] {
    Progress progress("more", 1, 0);
    progress.step(5);
  });
  EXPECT_THAT(text, HasSubstr("100%"));
}

}  // namespace
}  // namespace latelight
