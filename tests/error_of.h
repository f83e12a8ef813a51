// The message of the Error that a call throws.
#pragma once

#include <gtest/gtest.h>
#include <latelight/error.h>

#include <functional>
#include <string>

namespace latelight {

// Returns the message after checking the code. A call that throws nothing fails the test.
inline std::string errorOf(const std::function<void()>& call, ExitCode code = ExitCode::Usage) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

}  // namespace latelight
