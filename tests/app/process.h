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
  std::vector<std::string> arguments;  // without the program's name
  // added to this process's environment; XDG_CACHE_HOME is caches() by default
  std::map<std::string, std::string> environment;
  std::filesystem::path folder;  // working directory; empty: that of this process
  // the file that receives standard output, as with ">"; empty: captured in `out`
  std::filesystem::path standardOutput;
  std::chrono::milliseconds timeout{3'600'000};  // a process that runs longer hangs and is killed
  std::function<bool()> until;                   // polled; when it returns true, the process is sent `lastSignal`
  int lastSignal = SIGKILL;                      // the signal that is sent after `until` or `timeout`
};

struct Outcome {
  int code = -1;          // exit code; -1 if the process did not exit by itself
  int signal = 0;         // signal that ended the process; 0: none
  bool timedOut = false;  // true if `timeout` passed or `until` returned true, and the signal was sent
  std::string out, err;
  bool exited() const { return code >= 0; }
  // Returns "exit 3", "signal 11" or that the time ran out, followed by standard error; for messages.
  std::string text() const;
};

// Throws std::runtime_error if `executable` cannot be started.
Outcome runProcess(const std::filesystem::path& executable, const Command& command);

// The path of latelight.
Outcome latelight(const Command& command);
Outcome latelight(std::vector<std::string> arguments);
// Runs a line that begins with "latelight", split as a shell splits it.
Outcome latelightInShell(std::string line, const std::filesystem::path& folder);

// Calls body(0..count-1), two at a time, for runs that consist mostly of start-up. An exception ends the test program.
void inPairs(size_t count, const std::function<void(size_t)>& body);

// A folder for all caches of this test program, deleted when it ends.
const std::filesystem::path& caches();

}  // namespace latelight::app
