// No pattern takes long or overflows the stack.
#include "delegate/tradeoff/name_pattern.h"

#include <gtest/gtest.h>

#include <chrono>

namespace alabaster::tradeoff {
namespace {

TEST(NamePattern, MatchesPartsOfNames) {
  EXPECT_TRUE(NamePattern("").matches("anything"));
  EXPECT_TRUE(NamePattern("lambert|maxDepth").matches("maxDepth=4"));
  EXPECT_FALSE(NamePattern("lambert|maxDepth").matches("diffusion"));
  EXPECT_TRUE(NamePattern("^quality=").matches("quality=draft"));
  EXPECT_FALSE(NamePattern("^draft").matches("quality=draft"));
}

TEST(NamePattern, RefusesWhatIsNoPattern) {
  EXPECT_NE(NamePattern("(").fault(), "");
  EXPECT_FALSE(NamePattern("(").matches("("));
  EXPECT_NE(NamePattern(std::string(50000, '(')).fault(), "");
  EXPECT_NE(NamePattern("(a{1000}){1000}").fault(), "");
  EXPECT_NE(NamePattern("(.*)\\1").fault(), "");
  EXPECT_EQ(NamePattern("a+|\\+").fault(), "");
}

TEST(NamePattern, NoPatternIsSlow) {
  const auto start = std::chrono::steady_clock::now();
  const NamePattern pattern("(.*)*(.*)*(.*)*x");
  EXPECT_EQ(pattern.fault(), "");
  EXPECT_FALSE(pattern.matches("the reference, with a name that is long enough to try all ways of cutting it"));
  std::string nested(30, '('), repeated = "a" + std::string(30, '+');
  nested += 'a';
  for (int i = 0; i < 30; ++i) nested += "+)";
  EXPECT_NE(NamePattern(nested).fault(), "");
  EXPECT_NE(NamePattern(repeated).fault(), "");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

}  // namespace
}  // namespace alabaster::tradeoff
