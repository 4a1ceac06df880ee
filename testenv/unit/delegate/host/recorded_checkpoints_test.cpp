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

TEST(RecordedCheckpoints, ANoteSaysWhatFrameItIsOf) {
  const auto note = ReadFrameNote(
      R"({"degraded": true, "fields": {"camera": "/c", "width": 64, "height": 48, "crop": [1, 2, 30, 40], "frame": 7.0},
          "settings": {"samples": 4, "targetError": 0.02, "subsurface": "walk", "adaptive": false}})");
  ASSERT_TRUE(note);
  EXPECT_TRUE(note->degraded);
  EXPECT_EQ(note->frame.camera, Path("/c"));
  EXPECT_EQ(note->frame.width, 64);
  EXPECT_EQ(note->frame.crop, (Rect2i{1, 2, 30, 40}));
  EXPECT_EQ(note->frame.frame, 7);
  EXPECT_EQ(note->frame.settings.at("targetError"), Value(0.02f));
  EXPECT_EQ(note->frame.settings.at("subsurface"), Value("walk"));
}

TEST(RecordedCheckpoints, TextsThatAreNoNotesAreRefused) {
  for (const char* text :
       {"", "[]", "{}", "null", R"({"degraded": 1, "fields": {}, "settings": {}})",
        R"({"degraded": false, "fields": {"width": "wide"}, "settings": {}})",
        R"({"degraded": false, "fields": {"width": -1}, "settings": {}})",
        R"({"degraded": false, "fields": {"crop": [1, 2]}, "settings": {}})", R"({"degraded": false, "fields": {}})"})
    EXPECT_FALSE(ReadFrameNote(text)) << text;
}

}  // namespace
}  // namespace alabaster::hd::host
