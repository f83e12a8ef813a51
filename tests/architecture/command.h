// Runs compilers.
#pragma once

#include <cstdio>
#include <string>

namespace latelight {

// What a command wrote, and whether it ended with 0.
struct Result {
  bool good = false;
  std::string output;
};

inline Result runCommand(const std::string& command) {
  Result result;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return result;
  char buffer[4096];
  while (const size_t got = fread(buffer, 1, sizeof(buffer), pipe)) result.output.append(buffer, got);
  result.good = pclose(pipe) == 0;
  return result;
}

}  // namespace latelight
