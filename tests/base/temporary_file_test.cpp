// A program that ends while it writes leaves no temporary files, or only those that the next run deletes.
#include "base/temporary_file.h"
#include "app/folder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "base/fatal_signals.h"
#include "base/files.h"
#include "base/parallel.h"
#include "sanitized.h"

namespace latelight {

namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

class Temporaries : public testing::Test {
 protected:
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path().filename().string());
    std::sort(all.begin(), all.end());
    return all;
  }
  std::vector<std::string> hidden() const {
    std::vector<std::string> all = names();
    std::erase_if(all, [](const std::string& name) { return !name.starts_with('.'); });
    return all;
  }
  app::Folder temporary;
  const fs::path folder = temporary.path();
};

// Runs `body` in a process of its own.
pid_t start(const std::function<void()>& body) {
  const pid_t child = fork();
  if (child != 0) return child;
  body();
  _exit(99);
}

int statusOf(pid_t child) {
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return status;
}

TEST_F(Temporaries, GoWithTheirObject) {
  {
    const TemporaryFile file(folder / "a.png", 0666);
    EXPECT_EQ(file.error(), 0);
    EXPECT_EQ(names().size(), 1u);
  }
  EXPECT_THAT(names(), IsEmpty());
  TemporaryFile file(folder / "a.png", 0666);
  EXPECT_EQ(file.become(folder / "a.png"), 0);
  EXPECT_THAT(names(), ElementsAre("a.png"));
}

TEST_F(Temporaries, GoBeforeASignalEndsTheProgram) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGABRT, SIGSEGV, SIGBUS, SIGXCPU, SIGUSR1, SIGALRM}) {
    const int status = statusOf(start([&] {
      std::signal(signal, SIG_DFL);  // sanitizers install their own handlers for some signals
      handleFatalSignals();
      const TemporaryFile one(folder / "a.png", 0666), other(folder / "b.png", 0666);
      if (names().size() == 2) raise(signal);
    }));
    EXPECT_TRUE(WIFSIGNALED(status)) << strsignal(signal);
    EXPECT_EQ(WTERMSIG(status), signal);
    EXPECT_THAT(names(), IsEmpty()) << strsignal(signal);
  }
}

// The ways in which the processes below crash.
[[gnu::noinline]] int overflowStack(int depth) {
  volatile char room[4096];
  room[0] = static_cast<char>(depth);
  return depth < 0 ? 0 : overflowStack(depth + 1) + room[0];
}

[[gnu::noinline]] int readNothing(const volatile int* from) {
  return *from + 1;
}

// Returns the output of a process that runs `crash` with a temporary file. Expects that SIGSEGV ends it and that it
// removes the file.
std::string printedByCrash(const fs::path& folder, const std::function<void()>& crash) {
  int standardError[2];
  EXPECT_EQ(pipe(standardError), 0);
  const pid_t child = start([&] {
    dup2(standardError[1], STDERR_FILENO);
    std::signal(SIGSEGV, SIG_DFL);  // sanitizers install their own handlers
    handleFatalSignals();
    const TemporaryFile file(folder / "a.png", 0666);
    if (!fs::is_empty(folder)) crash();
  });
  close(standardError[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t count; (count = read(standardError[0], buffer, sizeof(buffer))) > 0;)
    text.append(buffer, static_cast<size_t>(count));
  close(standardError[0]);
  const int status = statusOf(child);
  EXPECT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(WTERMSIG(status), SIGSEGV);
  EXPECT_TRUE(fs::is_empty(folder));
  return text;
}

TEST_F(Temporaries, GoBeforeACrashWhichPrintsABacktrace) {
  if (hasAddressSanitizer()) GTEST_SKIP() << "sanitizers report the crash before the signal is raised";
  const auto crashes = [&](const std::function<void()>& crash, const char* function) {
    const std::string text = printedByCrash(folder, crash);
    EXPECT_THAT(text, testing::HasSubstr("crashed by SIGSEGV"));
    EXPECT_THAT(text, testing::HasSubstr(function));
  };
  volatile int sum = 0;
  const auto readNull = [&] { sum = readNothing(nullptr); };
  const auto overflow = [&] { sum = overflowStack(0); };
  crashes(readNull, "readNothing");
  // After a stack overflow, a handler needs an alternate stack, in the main thread and in all others.
  crashes(overflow, "overflowStack");
  crashes([&] { inBackground(overflow).get(); }, "overflowStack");
  crashes(
      [&] {
        parallelFor(64, 1, [&](size_t, size_t) {
          if (gettid() == getpid()) usleep(200'000);  // another thread, if there is one, gets the signal first
          overflow();
        });
      },
      "overflowStack");
}

// as nohup does
TEST_F(Temporaries, SignalsThatAreIgnoredStayIgnored) {
  const int status = statusOf(start([&] {
    std::signal(SIGHUP, SIG_IGN);
    handleFatalSignals();
    raise(SIGHUP);
    _exit(7);
  }));
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 7);
}

// Two threads write files in an endless loop, and the process is terminated at arbitrary times.
TEST_F(Temporaries, NeverOutliveASignalAtAnyMoment) {
  std::mt19937 random(9);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP})
    for (int attempt = 0; attempt < 40; ++attempt) {
      const pid_t child = start([&] {
        handleFatalSignals();
        const auto write = [&](const char* name) {
          const std::vector<std::byte> bytes(200'000);
          for (int i = 0;; ++i) writeFile(folder / (name + std::to_string(i % 8)), bytes);
        };
        std::thread other(write, "a");
        write("b");
      });
      while (names().empty()) usleep(1000);
      usleep(random() % 20'000);
      kill(child, signal);
      const int status = statusOf(child);
      ASSERT_TRUE(WIFSIGNALED(status));
      ASSERT_EQ(WTERMSIG(status), signal);
      ASSERT_THAT(hidden(), IsEmpty());
      for (const std::string& name : names()) {
        ASSERT_EQ(fs::file_size(folder / name), 200'000u) << name;
        fs::remove(folder / name);
      }
    }
}

TEST_F(Temporaries, OfKilledProcessesAreSweptByTheNext) {
  int ready[2];  // sent once the file is locked; before, another process may delete it
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = start([&] {
    const TemporaryFile file(folder / "a.png", 0666);
    for (char byte = 0; write(ready[1], &byte, 1) != 1;) {
    }
    for (;;) pause();
  });
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  close(ready[0]);
  close(ready[1]);
  const std::string left = names().front();
  // While the process lives, no other process deletes its file. Each process cleans a folder only once, so this runs in
  // processes of its own.
  const auto write = [&](const char* name) {
    EXPECT_EQ(WEXITSTATUS(statusOf(start([&] {
                writeFile(folder / name, {});
                _exit(0);
              }))),
              0);
  };
  write("b.png");
  EXPECT_THAT(names(), ElementsAre(left, "b.png"));
  kill(child, SIGKILL);
  statusOf(child);
  EXPECT_THAT(names(), ElementsAre(left, "b.png"));
  write("c.png");
  EXPECT_THAT(names(), ElementsAre("b.png", "c.png"));
}

TEST_F(Temporaries, AreTheOnlyFilesThatAreSwept) {
  const std::vector<std::string> kept{
      ".a.png.1-.latelight-tmp",  ".a.png.1.latelight-tmp", ".a.png.12-3.latelight-tmp.png",
      ".a.png.x-3.latelight-tmp", ".latelight-tmp",         "a.png.12-3.latelight-tmp"};
  for (const std::string& name : kept) std::ofstream(folder / name).put('x');
  std::ofstream(folder / ".a.png.12-3.latelight-tmp").put('x');
  fs::create_directory(folder / ".a.png.12-4.latelight-tmp");
  fs::create_symlink("nowhere", folder / ".a.png.12-5.latelight-tmp");
  { const TemporaryFile file(folder / "b.png", 0666); }
  std::vector<std::string> expected = kept;
  expected.insert(expected.end(), {".a.png.12-4.latelight-tmp", ".a.png.12-5.latelight-tmp"});
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(names(), expected);
}

}  // namespace
}  // namespace latelight
