// The messages of calls that must be rejected.
#pragma once

#include <gtest/gtest.h>
#include <latelight/latelight.h>

#include <functional>
#include <string>

namespace latelight::test {

// Returns the message of the usage error with which a call ends.
inline std::string rejectionOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::Usage);
    return error.what();
  }
  return "nothing was rejected";
}

}  // namespace latelight::test
