// The memory limit, and the allocations that count toward it.
#include "base/memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <latelight/latelight.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

#include "base/error.h"
#include "base/parallel.h"
#include "sanitized.h"

namespace latelight {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr uint64_t kMiB = 1 << 20;

class Memory : public testing::Test {
 protected:
  Memory() { setMemoryLimit(100 * kMiB); }
  ~Memory() override { setMemoryLimit(0); }

  // Returns the message of the rejected allocation; empty if it succeeds.
  static std::string refusal(const std::function<void()>& call) {
    try {
      call();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::OutOfMemory);
      return error.what();
    }
    return "";
  }
};

TEST_F(Memory, IsTakenAndGivenBack) {
  {
    const MemoryClaim first(60 * kMiB, "the first");
    EXPECT_THAT(refusal([] { MemoryClaim(41 * kMiB, "the second"); }),
                AllOf(HasSubstr("the second: 41 MiB are needed, and 60 MiB of the 100 MiB"), HasSubstr("--memory")));
    EXPECT_EQ(refusal([] { MemoryClaim(40 * kMiB, "the second"); }), "");
  }
  EXPECT_EQ(refusal([] { MemoryClaim(100 * kMiB, "all"); }), "");
  EXPECT_NE(refusal([] { MemoryClaim(100 * kMiB + 1, "more"); }), "");
  EXPECT_NE(refusal([] { MemoryClaim(~uint64_t{0}, "everything"); }), "");
}

TEST_F(Memory, StatesSmallAmountsInBytes) {
  setMemoryLimit(1000);
  EXPECT_THAT(refusal([] { MemoryClaim(2000, "a claim"); }),
              HasSubstr("2000 bytes are needed, and 0 bytes of the 1000 bytes"));
}

// Whichever limit is the smaller one is named.
TEST_F(Memory, NamesALimitOfAddresses) {
  if (hasAddressSanitizer())
    GTEST_SKIP() << "the shadow memory of the address sanitizer exceeds any limit on addresses";
  setMemoryLimit(100 * 1024 * kMiB);
  const auto underALimit = [] {
    rlimit limit{};
    limit.rlim_cur = limit.rlim_max = 2048 * kMiB;
    setrlimit(RLIMIT_AS, &limit);
    const std::string sentence = refusal([] { MemoryClaim(2048 * kMiB, "a claim"); });
    _exit(sentence.ends_with("raise the limit on address space (ulimit -v)") ? 0 : 1);
  };
  EXPECT_EXIT(underALimit(), testing::ExitedWithCode(0), "");
}

TEST_F(Memory, MovesWithItsClaim) {
  MemoryClaim kept;
  {
    MemoryClaim claim(60 * kMiB, "a claim");
    kept = std::move(claim);
    MemoryClaim other(std::move(kept));
    kept = std::move(other);
  }
  EXPECT_NE(refusal([] { MemoryClaim(50 * kMiB, "the rest"); }), "");
  kept = {};
  EXPECT_EQ(refusal([] { MemoryClaim(100 * kMiB, "all"); }), "");
}

TEST_F(Memory, ShrinksToNothingAtMost) {
  MemoryClaim claim(60 * kMiB, "a claim");
  const MemoryClaim other(20 * kMiB, "another");
  claim.shrink(50 * kMiB);
  EXPECT_EQ(refusal([] { MemoryClaim(70 * kMiB, "what is free"); }), "");
  EXPECT_NE(refusal([] { MemoryClaim(70 * kMiB + 1, "more"); }), "");
  claim.shrink(~uint64_t{0});
  EXPECT_EQ(refusal([] { MemoryClaim(80 * kMiB, "what is free"); }), "");
  EXPECT_NE(refusal([] { MemoryClaim(80 * kMiB + 1, "more than the other leaves"); }), "");
}

TEST_F(Memory, GrowsFromAllThreads) {
  MemoryClaim claim;
  parallelFor(1000, 1, [&](size_t begin, size_t end) { claim.grow((end - begin) * 100 * 1024, "a part"); });
  EXPECT_NE(refusal([] { MemoryClaim(100 * kMiB - 1000 * 100 * 1024 + 1, "the rest"); }), "");
  EXPECT_EQ(refusal([] { MemoryClaim(100 * kMiB - 1000 * 100 * 1024, "the rest"); }), "");
}

TEST(MemoryLimit, IsByDefaultAShareOfWhatIsFree) {
  EXPECT_GT(memoryLimit(), 0u);
  const auto machine = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  EXPECT_LE(memoryLimit(), machine / 4 * 3);
  if (hasAddressSanitizer())
    GTEST_SKIP() << "the shadow memory of the address sanitizer exceeds any limit on addresses";
  const auto underALimit = [] {
    rlimit limit{};
    limit.rlim_cur = limit.rlim_max = 1024 * kMiB;
    setrlimit(RLIMIT_AS, &limit);
    _exit(addressesLeft() <= 1024 * kMiB && addressesLeft() > 0 ? 0 : 1);
  };
  EXPECT_EXIT(underALimit(), testing::ExitedWithCode(0), "");
}

TEST(MemoryLimit, IsReadAsPeopleWriteIt) {
  EXPECT_EQ(parseMemory("512M"), 512 * kMiB);
  EXPECT_EQ(parseMemory("4G"), 4096 * kMiB);
  EXPECT_EQ(parseMemory("1.5g"), 1536 * kMiB);
  EXPECT_EQ(parseMemory("2GiB"), 2048 * kMiB);
  EXPECT_EQ(parseMemory("2GB"), 2048 * kMiB);
  EXPECT_EQ(parseMemory("1T"), kMiB * kMiB);
  EXPECT_EQ(parseMemory("70000K"), 70000u * 1024);
  EXPECT_EQ(parseMemory("123456"), 123456u);
  for (const char* text : {"", "G", "-1G", "0", "4X", "4G8", "4 G", "1e9", "nan", "inf", "99999999999T", "0.1"})
    EXPECT_EQ(parseMemory(text), 0u) << text;
}

}  // namespace
}  // namespace latelight
