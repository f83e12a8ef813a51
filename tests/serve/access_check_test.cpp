#include "serve/access_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "base/error.h"
#include "serve/log_limit.h"
#include "serve/token.h"

namespace latelight::serve {
namespace {

const std::string kToken = "0123456789abcdef0123456789abcdef";

std::string refusal(std::string_view target, std::string_view host, std::optional<std::string_view> origin = {}) {
  return AccessCheck(kToken, {"render.example.org"}).open({target, host, origin}).refusal;
}

// Such names could never equal that of a request.
TEST(GateTest, NamesAreThoseOfHosts) {
  for (const char* name : {"a b/c", "", "render:8765", "http://render", "[::1]", "Render", "r\xc3\xa9nder", "a/b"})
    EXPECT_THROW(AccessCheck(kToken, {"render", name}), Error) << name;
  for (const char* name : {"render", "render.example.org.", "xn--rnder-bsa", "gpu_7", "7", "10.0.0.7", "::1"})
    EXPECT_EQ(AccessCheck(kToken, {name}).open({"/" + kToken + "/", name[0] == ':' ? "[::1]" : name, {}}).refusal, "");
}

TEST(GateTest, TokensAreRandom) {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const std::string token = newToken();
    EXPECT_EQ(token.size(), 32u);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), token.npos);
    EXPECT_TRUE(seen.insert(token).second);
  }
}

TEST(GateTest, ComparesWholeTokens) {
  EXPECT_TRUE(sameToken(kToken, kToken));
  EXPECT_FALSE(sameToken(kToken, kToken.substr(1)));
  EXPECT_FALSE(sameToken("", kToken));
  for (size_t i = 0; i < kToken.size(); ++i) {
    std::string other = kToken;
    other[i] ^= 1;
    EXPECT_FALSE(sameToken(kToken, other));
  }
}

TEST(GateTest, OpensForTheTokenAlone) {
  EXPECT_EQ(AccessCheck(kToken, {}).open({"/" + kToken + "/main.js?x=/y", "localhost", {}}).path, "main.js");
  EXPECT_EQ(AccessCheck(kToken, {}).open({"/" + kToken + "/", "localhost", {}}).path, "");
  for (const std::string& target :
       std::vector<std::string>{"", "/", "//", "*", "/main.js", "/?token=" + kToken, "/" + kToken.substr(1) + "/",
                                "/x/" + kToken + "/", "/" + kToken + "x/"})
    EXPECT_NE(refusal(target, "localhost"), "") << target;
}

// RFC 9112, 3.2.2. Clients send the same authority as in Host.
TEST(GateTest, AcceptsTheAbsoluteFormOfTheSameHost) {
  EXPECT_EQ(AccessCheck(kToken, {}).open({"http://localhost:8765/" + kToken + "/main.js?x", "localhost:8765", {}}).path,
            "main.js");
  EXPECT_EQ(refusal("http://[::1]:8765/" + kToken + "/", "[::1]:8765", "http://[::1]:8765"), "");
  EXPECT_NE(refusal("http://evil.example/" + kToken + "/", "evil.example"), "");
  for (const std::string start :
       {"http://", "http://localhost", "http://localhost:87655", "http://localhost:8765.evil", "http://evil.example",
        "http://x@localhost:8765", "http://localhost:8765@evil.example", "https://localhost:8765", "//localhost:8765",
        "http:/localhost:8765", "http://localhost:8765/x", "http://127.0.0.1:8765"})
    EXPECT_NE(refusal(start + "/" + kToken + "/", "localhost:8765"), "") << start;
  EXPECT_NE(refusal("http://localhost:8765" + kToken + "/", "localhost:8765"), "");
  EXPECT_NE(refusal("http://localhost:8765", "localhost:8765"), "");
}

TEST(GateTest, KnowsItsOwnNames) {
  const std::string target = "/" + kToken + "/";
  for (const char* host : {"localhost", "LocalHost:8765", "127.0.0.1:1", "[::1]:8765", "[::1]", "192.168.1.7:80",
                           "render.example.org:8765", "Render.Example.org"})
    EXPECT_EQ(refusal(target, host), "") << host;
  for (const char* host :
       {"", "evil.example.org", "localhost.evil.example.org", "127.0.0.1.evil.example.org:8765", "[evil", "xlocalhost",
        "render.example.org.evil", "[::1]evil.example.org", "[::1", "[::1]8765", "[localhost]:8765", "::1",
        "localhost:evil", "127.0.0.1:80:90", "localhost:80.evil.example.org"})
    EXPECT_NE(refusal(target, host), "") << host;
}

TEST(GateTest, PagesOfOtherOriginsStayOutside) {
  const std::string target = "/" + kToken + "/socket";
  EXPECT_EQ(refusal(target, "localhost:8765", "http://localhost:8765"), "");
  for (const char* origin : {"", "null", "http://localhost", "http://localhost:80", "https://localhost:8765",
                             "http://evil.example.org", "http://127.0.0.1:8765"})
    EXPECT_NE(refusal(target, "localhost:8765", origin), "") << origin;
}

TEST(LogLimitTest, CountsWhatItLeavesOut) {
  LogLimit limit;
  const LogLimit::Time begin{};
  for (uint32_t i = 0; i < LogLimit::kMaxLines; ++i) EXPECT_EQ(limit.next(begin), 0u);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(limit.next(begin + LogLimit::kPeriod / 2), std::nullopt);
  EXPECT_EQ(limit.next(begin + LogLimit::kPeriod), 1000u);
  EXPECT_EQ(limit.next(begin + LogLimit::kPeriod), 0u);
}

}  // namespace
}  // namespace latelight::serve
