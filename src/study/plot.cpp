#include "study/plot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <span>
#include <system_error>

#include "base/log.h"

extern char** environ;

namespace latelight::study {

namespace {

// Okabe and Ito's colors are distinguishable with any color vision. Point types differ as well.
constexpr std::array kColors = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"};

std::string inQuotes(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return result + '"';
}

bool drawable(const Curve& curve) {
  return std::any_of(curve.samples.begin(), curve.samples.end(), [](const Sample& s) { return s.x > 0 && s.y > 0; });
}

// --- running gnuplot -------------------------------------------------------------------------------------------------

struct Close {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

struct Drawn {
  std::vector<std::byte> png;
  std::string problem;  // the error message; empty: none
};

std::vector<std::byte> readToEnd(int from) {
  std::vector<std::byte> bytes;
  std::array<std::byte, 1 << 14> part;
  for (;;) {
    const ssize_t got = read(from, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return bytes;
    bytes.insert(bytes.end(), part.begin(), part.begin() + got);
  }
}

// Starts gnuplot with `input` as standard input and `output` as standard output, and closes `output`. Returns 0 or
// errno.
int spawnGnuplot(int input, int output, pid_t& child) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  char name[] = "gnuplot";
  char* const arguments[] = {name, nullptr};
  const int error = posix_spawnp(&child, name, &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  close(output);
  return error;
}

// Passes the script in a file instead of a pipe, so that no deadlock is possible, regardless of sizes.
Drawn runGnuplot(const std::string& script) {
  const std::unique_ptr<std::FILE, Close> file(std::tmpfile());
  int ends[2];
  if (!file || std::fwrite(script.data(), 1, script.size(), file.get()) != script.size() ||
      std::fflush(file.get()) != 0 || pipe2(ends, O_CLOEXEC) != 0)
    return {{}, fmt::format("its script can't be given to it: {}", std::generic_category().message(errno))};
  lseek(fileno(file.get()), 0, SEEK_SET);
  pid_t child = 0;
  const int error = spawnGnuplot(fileno(file.get()), ends[1], child);
  Drawn drawn;
  if (error == 0) {
    drawn.png = readToEnd(ends[0]);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || drawn.png.empty()) drawn.problem = "it failed";
  } else if (error == ENOENT) {
    drawn.problem = "it is not installed (Debian's package is gnuplot-nox)";
  } else {
    drawn.problem = std::generic_category().message(error);
  }
  close(ends[0]);
  return drawn;
}

}  // namespace

std::string gnuplotScript(const Plot& plot) {
  std::string text = "# Draws itself: gnuplot FILE > picture.png\n";
  text +=
      "if (strstrt(GPVAL_TERMINALS, \"pngcairo\")) {\n"
      "  set terminal pngcairo noenhanced size 880,560 font \"sans,11\"\n"
      "} else {\n"
      "  set terminal png noenhanced size 880,560\n"
      "}\n";
  text += fmt::format("set title {}\nset xlabel {}\nset ylabel {}\n", inQuotes(plot.title), inQuotes(plot.xLabel),
                      inQuotes(plot.yLabel));
  text +=
      "set logscale xy\nset format x \"%.0s%c\"\nset format y \"%g\"\nset grid xtics ytics lt 1 lw 0.5 lc rgb "
      "\"#cccccc\"\n"
      "set key outside right top\n";
  std::string lines;
  size_t number = 0;
  for (const Curve& curve : plot.curves) {
    if (!drawable(curve)) continue;
    text += fmt::format("$curve{} << EOD\n", number);
    for (const Sample& s : curve.samples)
      if (s.x > 0 && s.y > 0) text += fmt::format("{} {}\n", s.x, s.y);
    text += "EOD\n";
    lines += fmt::format("{}$curve{} using 1:2 with linespoints lw 2 ps 1.2 pt {} lc rgb \"{}\" title {}",
                         number ? ", \\\n  " : "", number, number + 4, kColors[number % kColors.size()],
                         inQuotes(curve.name));
    ++number;
  }
  return number ? text + "plot " + lines + "\n" : text;
}

std::vector<NamedFile> drawPlots(const std::vector<Plot>& plots) {
  std::vector<NamedFile> files;
  for (const Plot& plot : plots) {
    if (std::none_of(plot.curves.begin(), plot.curves.end(), drawable)) continue;
    const std::string script = gnuplotScript(plot);
    const auto bytes = std::as_bytes(std::span(script));
    files.push_back({plot.name + ".gnuplot", {bytes.begin(), bytes.end()}});
    Drawn drawn = runGnuplot(script);
    if (drawn.problem.empty())
      files.push_back({plot.name + ".png", std::move(drawn.png)});
    else
      warn("gnuplot cannot draw the plots: {}; its scripts are next to the tables", drawn.problem);
  }
  return files;
}

}  // namespace latelight::study
