// The program as users run it: a process, its output, and its exit status.
#pragma once

#include <chrono>
#include <csignal>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace latelight::app {

struct Command {
  std::vector<std::string> arguments;              // after the program's name
  std::map<std::string, std::string> environment;  // beside this process's; XDG_CACHE_HOME is caches() unless set here
  std::filesystem::path folder;                    // to run in; empty: this process's
  std::filesystem::path standardOutput;            // a file to open for it, as with ">"; empty: captured in `out`
  std::chrono::milliseconds timeout{3'600'000};    // it has hung, and is killed
  std::function<bool()> until;                     // asked again and again: it has done enough, and is killed
  int lastSignal = SIGKILL;                        // what it then gets
};

struct Outcome {
  int code = -1;          // of exit; -1 where it did not exit by itself
  int signal = 0;         // that ended it; 0: none
  bool timedOut = false;  // or had done enough, and was sent the signal for that
  std::string out, err;
  bool exited() const { return code >= 0; }
  // "exit 3", "signal 11", "not within its time", and what it said on standard error: for messages.
  std::string text() const;
};

// Throws std::runtime_error where `executable` can't be started.
Outcome runProcess(const std::filesystem::path& executable, const Command& command);

// latelight.
Outcome latelight(const Command& command);
Outcome latelight(std::vector<std::string> arguments);
// A line that begins with "latelight", as a shell reads it.
Outcome latelightInShell(std::string line, const std::filesystem::path& folder);

// Calls body(0..count-1), two at a time: for runs that are mostly start-up. Exceptions end the test program.
void inPairs(size_t count, const std::function<void(size_t)>& body);

// A folder for all caches of this test program, gone when it ends.
const std::filesystem::path& caches();

}  // namespace latelight::app
