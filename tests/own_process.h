// For tests that run their own program again, as a process in which a disabled test does the work.
#pragma once

#include <cstdlib>

namespace latelight::test {

// The child runs its test whatever shard of the tests this process runs (tests/in_part): GoogleTest reads the variables
// once, when a program starts.
inline void runAllShardsInChildren() {
  setenv("GTEST_TOTAL_SHARDS", "1", 1);
  setenv("GTEST_SHARD_INDEX", "0", 1);
}

}  // namespace latelight::test
