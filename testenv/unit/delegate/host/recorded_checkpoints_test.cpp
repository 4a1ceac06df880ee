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
  EXPECT_EQ(checkpoints.resume().status, CommandStatus::unknown);
  checkpoints.write_last({});
  EXPECT_NE(checkpoints.last_fault().find("could not be written: there are no commands"), std::string::npos);
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[0], "checkpoint 'frame.checkpoint': there are no commands");
}

}  // namespace
}  // namespace alabaster::hd::host
