// The checkpoints of a recording, by a delegate that has no such commands.
#include "delegate/host/recorded_checkpoints.h"

#include <gtest/gtest.h>

#include "testenv/unit/delegate/host/fake_delegate.h"

namespace alabaster::hd::host {
namespace {

TEST(RecordedCheckpoints, ADelegateWithoutThemSavesNone) {
  FakeDelegate delegate;
  std::vector<std::string> said;
  RecordOptions options;
  options.checkpoint = "frame.checkpoint";
  options.resume = true;
  options.diagnostics = [&](const Diagnostic& d) { said.push_back(d.text); };
  RecordedCheckpoints checkpoints(&delegate, options, "/settings");
  EXPECT_FALSE(checkpoints.resume());
  checkpoints.write_last({});
  EXPECT_TRUE(checkpoints.last_failed());
  ASSERT_EQ(said.size(), 2u);
  EXPECT_NE(said[0].find("'frame.checkpoint': the delegate could not run the command resumeCheckpoint"),
            std::string::npos);
  EXPECT_NE(said[1].find("could not be written: the delegate could not run"), std::string::npos);
}

}  // namespace
}  // namespace alabaster::hd::host
