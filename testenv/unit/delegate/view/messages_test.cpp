// The list of what the renderer reports.
#include "delegate/view/messages.h"

#include <gtest/gtest.h>

namespace alabaster::view {
namespace {

TEST(Messages, CountsRepetitionsAndAlarms) {
  Messages messages;
  for (int i = 0; i < 3; ++i) messages.add({hd::Severity::warning, "image.missing", "a.png", "It is missing."});
  messages.add({hd::Severity::info, "note", "", "Done."});
  ASSERT_EQ(messages.all().size(), 2u);
  EXPECT_EQ(messages.all()[0].count, 3);
  EXPECT_EQ(messages.alarms(), 3u);
  messages.clear();
  EXPECT_TRUE(messages.all().empty());
}

TEST(Messages, KeepsTheLatest) {
  Messages messages;
  for (int i = 0; i < 1000; ++i) messages.add({hd::Severity::error, "e", "", std::to_string(i)});
  EXPECT_LE(messages.all().size(), 200u);
  EXPECT_EQ(messages.all().back().diagnostic.text, "999");
}

}  // namespace
}  // namespace alabaster::view
