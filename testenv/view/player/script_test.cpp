// The language of scripts.
#include "testenv/view/player/script.h"

#include <gtest/gtest.h>

namespace alabaster::view {
namespace {

TEST(Script, ReadsEachActionWithItsWords) {
  const Script script = read_script(
      "# a story\n\nsize 800 600\nwait covered 5\nwait samples 4\ndrag left 0.5 0.5 0.6 0.4  # orbit\n"
      "choose \"Display\" \"sRGB - Display\"\ntype exposure \"\"\nstate\nquit\r\n");
  ASSERT_EQ(script.problem, "");
  ASSERT_EQ(script.actions.size(), 8u);
  EXPECT_EQ(script.actions[0].name, "size");
  EXPECT_EQ(script.actions[0].number(1), 600);
  EXPECT_EQ(script.actions[0].line, 3);
  EXPECT_EQ(script.actions[3].words, (std::vector<std::string>{"left", "0.5", "0.5", "0.6", "0.4"}));
  EXPECT_EQ(script.actions[4].words, (std::vector<std::string>{"Display", "sRGB - Display"}));
  EXPECT_EQ(script.actions[5].words, (std::vector<std::string>{"exposure", ""}));
  EXPECT_EQ(script.actions[7].line, 10);
}

TEST(Script, NamesTheLineAndTheFault) {
  const std::pair<const char*, const char*> cases[] = {
      {"\nfly 1 2", "line 2: there is no action 'fly'"},
      {"size 800", "line 1: size takes 2 words, not 1"},
      {"click left 3", "'left' is not a number"},
      {"click nan 3", "'nan' is not a number"},
      {"click 1e 3", "'1e' is not a number"},
      {"press \"Save", "a word in quotes has no end"},
      {"wait", "wait for covered"},
      {"wait forever", "wait for covered"},
      {"wait samples", "too few"},
      {"wait covered 1 2", "too few or too many"},
      {"wait seconds soon", "'soon' is not a number"},
      {"quit now", "quit takes 0 words, not 1"},
      {"size -5 -5", "'-5' is not a whole number of pixels from 1 to 16384"},
      {"size 0 600", "'0' is not a whole number of pixels"},
      {"size 800.5 600", "'800.5' is not a whole number of pixels"},
      {"size 1e9 600", "'1e9' is not a whole number of pixels"},
      {"size 99999 600", "from 1 to 16384"},
      {"wait seconds 1e300 2", "'1e300' is not a number of seconds from 0 to 3600"},
      {"wait seconds 5 2", "takes longer than the 2 seconds"},
      {"wait seconds -1", "'-1' is not a number of seconds"},
      {"wait covered 1e300", "'1e300' is not a number of seconds"},
      {"wait samples 1e300 2", "'1e300' is not a number of samples"},
      {"drag left 0 0 1e300 1", "'1e300' is not a number from -10000 to 10000"},
      {"click inf 3", "'inf' is not a number"},
      {"click 1e-400 3", "'1e-400' is not a number"},
  };
  for (const auto& [text, fault] : cases)
    EXPECT_NE(read_script(text).problem.find(fault), std::string::npos) << text << ": " << read_script(text).problem;
}

}  // namespace
}  // namespace alabaster::view
