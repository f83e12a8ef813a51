// Long tests: `./dev test` runs them in part or not at all, `./dev test --all` (LATELIGHT_TEST_ALL=1) runs them in
// full. The summary of a run names each of them (tests/dev/summary.awk).
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

namespace latelight::test {

inline bool runsAll() {
  const char* all = std::getenv("LATELIGHT_TEST_ALL");
  return all && *all && std::string(all) != "0";
}

// Whether the current test may run in full. If not, the summary reports that it ran in part.
inline bool runsInFull() {
  if (!runsAll()) testing::Test::RecordProperty("part", "in part");
  return runsAll();
}

// The number of rounds, seeds, samples or frames of the current test: `all` if tests run in full, `usual` otherwise.
template <typename T>
T rounds(T all, T usual) {
  if (runsAll()) return all;
  testing::Test::RecordProperty("part", std::to_string(usual) + " of " + std::to_string(all));
  return usual;
}

}  // namespace latelight::test

// Skips the current test, or all tests of a fixture's SetUp(), unless tests run in full.
#define LATELIGHT_SKIP_UNLESS_ALL() \
  if (!latelight::test::runsAll()) GTEST_SKIP() << "left to ./dev test --all"
