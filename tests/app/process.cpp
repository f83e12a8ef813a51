#include "app/process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "app/folder.h"

namespace latelight::app {

namespace {

using Clock = std::chrono::steady_clock;

// The environment owns it, so that it is destroyed before static objects.
std::unique_ptr<Folder> cacheFolder;
class Caches : public testing::Environment {
  void SetUp() override { caches(); }
  void TearDown() override { cacheFolder.reset(); }
};
[[maybe_unused]] testing::Environment* const kCaches = testing::AddGlobalTestEnvironment(new Caches);

[[noreturn]] void failToStart(const std::filesystem::path& executable, int error) {
  throw std::system_error(error, std::generic_category(), "can't start " + executable.string());
}

class Pipe {
 public:
  Pipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe2");
  }
  ~Pipe() {
    close(ends_[0]);
    closeWriter();
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int reader() const { return ends_[0]; }
  int writer() const { return ends_[1]; }
  void closeWriter() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

std::vector<std::string> variables(const Command& command) {
  std::map<std::string, std::string> all;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry;
    const size_t equals = text.find('=');
    if (equals != std::string::npos) all[text.substr(0, equals)] = text.substr(equals + 1);
  }
  all["XDG_CACHE_HOME"] = caches().string();
  for (const auto& [name, value] : command.environment) all[name] = value;
  std::vector<std::string> lines;
  for (const auto& [name, value] : all) lines.push_back(name + "=" + value);
  return lines;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> all;
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

pid_t start(const std::filesystem::path& executable, const Command& command, const Pipe& out, const Pipe& err) {
  std::vector<std::string> arguments{executable.string()};
  arguments.insert(arguments.end(), command.arguments.begin(), command.arguments.end());
  std::vector<std::string> environment = variables(command);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  if (command.standardOutput.empty())
    posix_spawn_file_actions_adddup2(&actions, out.writer(), STDOUT_FILENO);
  else
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, command.standardOutput.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0666);
  posix_spawn_file_actions_adddup2(&actions, err.writer(), STDERR_FILENO);
  if (!command.folder.empty()) posix_spawn_file_actions_addchdir_np(&actions, command.folder.c_str());
  pid_t process = 0;
  const int error = posix_spawn(&process, executable.c_str(), &actions, nullptr, pointers(arguments).data(),
                                pointers(environment).data());
  posix_spawn_file_actions_destroy(&actions);
  if (error) failToStart(executable, error);
  return process;
}

// Reads both pipes until the process and its children have closed them, the deadline has passed, or `until` returns
// true.
bool readAll(const Pipe& out, const Pipe& err, Outcome& outcome, Clock::time_point deadline,
             const std::function<bool()>& until = nullptr) {
  constexpr std::chrono::milliseconds::rep kBetween = 2;
  std::array<pollfd, 2> waiting{{{out.reader(), POLLIN, 0}, {err.reader(), POLLIN, 0}}};
  std::array<std::string*, 2> texts{&outcome.out, &outcome.err};
  size_t open = 2;
  while (open > 0) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0 || (until && until())) return false;
    const auto wait = static_cast<int>(until ? std::min(left, kBetween) : left);
    if (poll(waiting.data(), waiting.size(), wait) < 0 && errno != EINTR) return false;
    for (size_t i = 0; i < waiting.size(); ++i) {
      if (waiting[i].fd < 0 || waiting[i].revents == 0) continue;
      std::array<char, 1 << 16> part;
      const ssize_t got = read(waiting[i].fd, part.data(), part.size());
      if (got > 0) texts[i]->append(part.data(), static_cast<size_t>(got));
      if (got > 0 || (got < 0 && errno == EINTR)) continue;
      waiting[i].fd = -1;
      --open;
    }
  }
  return true;
}

}  // namespace

std::string Outcome::text() const {
  std::string how = "exit " + std::to_string(code);
  if (signal) how = "signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  if (timedOut) how += ", not within its time";
  return err.empty() ? how : how + ": " + err;
}

Outcome runProcess(const std::filesystem::path& executable, const Command& command) {
  Pipe out, err;
  const pid_t process = start(executable, command, out, err);
  out.closeWriter();
  err.closeWriter();
  Outcome outcome;
  outcome.timedOut = !readAll(out, err, outcome, Clock::now() + command.timeout, command.until);
  if (outcome.timedOut) {
    kill(process, command.lastSignal);
    readAll(out, err, outcome, Clock::now() + std::chrono::hours(1));
  }
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) outcome.signal = WTERMSIG(status);
  if (WIFEXITED(status)) outcome.code = WEXITSTATUS(status);
  return outcome;
}

Outcome latelight(const Command& command) {
  return runProcess(LATELIGHT_PROGRAM, command);
}

Outcome latelight(std::vector<std::string> arguments) {
  return latelight(Command{.arguments = std::move(arguments)});
}

Outcome latelightInShell(std::string line, const std::filesystem::path& folder) {
  line.replace(0, std::string("latelight").size(), LATELIGHT_PROGRAM);
  return runProcess("/bin/sh", {.arguments = {"-c", line}, .folder = folder});
}

void inPairs(size_t count, const std::function<void(size_t)>& body) {
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t i = next++; i < count; i = next++) body(i);
  };
  std::thread other(work);
  work();
  other.join();
}

const std::filesystem::path& caches() {
  if (!cacheFolder) cacheFolder = std::make_unique<Folder>();
  return cacheFolder->path();
}

}  // namespace latelight::app
