#include "delegate/hydra/host_values.h"

#include <gtest/gtest.h>

namespace alabaster::hydra {
namespace {

TEST(HydraValues, BitsAreThoseOfTheTable) {
  constexpr BitPair table[] = {{1u << 9, hd::dirty::kTransform},
                               {1u << 1, hd::dirty::kParams | hd::dirty::kVisibility}};
  EXPECT_EQ(TranslateBits(1u << 9, table), hd::dirty::kTransform);
  EXPECT_EQ(TranslateBits(1u << 1 | 1u << 9, table),
            hd::dirty::kTransform | hd::dirty::kParams | hd::dirty::kVisibility);
  EXPECT_EQ(TranslateBits(1u << 20, table), hd::dirty::kClean) << "a bit that the table lacks";
}

class HydraSettings : public ::testing::Test {
 protected:
  const std::vector<hd::RenderSettingDescriptor> known_ = [] {
    std::vector<hd::RenderSettingDescriptor> all(4);
    all[0].key = "samples", all[0].defaultValue = int64_t(64);
    all[1].key = "targetError", all[1].defaultValue = 0.0f;
    all[2].key = "denoise", all[2].defaultValue = false;
    all[3].key = "filter", all[3].defaultValue = std::string("box");
    return all;
  }();
};

TEST_F(HydraSettings, HaveTheTypeOfTheirDefault) {
  EXPECT_EQ(TranslateSetting("alabaster:samples", int32_t(16), known_).value, hd::Value(int64_t(16)));
  EXPECT_EQ(TranslateSetting("samples", 16.0, known_).value, hd::Value(int64_t(16)));
  EXPECT_EQ(TranslateSetting("targetError", 0.25, known_).value, hd::Value(0.25f)) << "hosts send double";
  EXPECT_EQ(TranslateSetting("denoise", int64_t(1), known_).value, hd::Value(true)) << "and long";
  EXPECT_EQ(TranslateSetting("filter", "triangle", known_).value, hd::Value("triangle"));
}

TEST_F(HydraSettings, WhatDoesNotFitStaysForTheDelegateToReport) {
  EXPECT_EQ(TranslateSetting("samples", 2.5, known_).value, hd::Value(2.5));
  EXPECT_EQ(TranslateSetting("samples", "many", known_).value, hd::Value("many"));
}

TEST_F(HydraSettings, HaveNamesOfSeveralHosts) {
  EXPECT_EQ(TranslateSetting("alabaster:filter", "box", known_).key, hd::Token("filter"));
  EXPECT_EQ(TranslateSetting("convergedSamplesPerPixel", int32_t(8), known_).key, hd::Token("samples"));
  EXPECT_EQ(TranslateSetting("alabaster:writeScene", "a.alab", known_).key, hd::Token("writeScene"));
  EXPECT_EQ(TranslateSetting("houdini:interactive", "x", known_).key, hd::Token("houdini:interactive"));
}

// A stage comes from a stranger as any scene does.
TEST(HydraValues, AScenesLimitsOnlyTightenTheHosts) {
  const hd::Value none(0.0f), low(5.0f), high(100.0f);
  EXPECT_EQ(WithinHostLimits("timeLimit", low, high), low);
  EXPECT_EQ(WithinHostLimits("timeLimit", high, low), low);
  EXPECT_EQ(WithinHostLimits("timeLimit", none, low), low);
  EXPECT_EQ(WithinHostLimits("timeLimit", low, none), low);
  EXPECT_EQ(WithinHostLimits("timeLimit", none, none), none);
  EXPECT_EQ(WithinHostLimits("memoryLimit", high, low), low);
  EXPECT_EQ(WithinHostLimits("memoryLimit", none, low), low);
  EXPECT_EQ(WithinHostLimits("memoryLimit", low, none), low);
  EXPECT_EQ(WithinHostLimits("memoryLimit", int64_t(1) << 40, none), none) << "above the default";
  EXPECT_EQ(WithinHostLimits("samples", high, low), high);
}

TEST(HydraValues, RenderVarsHaveTheLayersOfTheProgram) {
  const std::pair<HostRenderVar, hd::RenderVar> rows[] = {
      {{"beauty", "Ci", "raw", "color4f", "C"}, {"color", "color", "float"}},
      {{"position", "", "raw", "point3f", ""}, {"position", "position", "float"}},
      {{"Alpha", "a", "raw", "half", ""}, {"alpha", "alpha", "half"}},
      {{"ids", "primId", "raw", "int", "objects"}, {"objects", "primId", "int"}},
      {{"coat", "st", "primvar", "half2", ""}, {"primvars:st", "primvars:st", "half"}},
      {{"key", "lightGroup:key", "raw", "color3h", ""}, {"lightGroup:key", "lightGroup:key", "half"}},
      {{"straight", "C<RD>L", "lpe", "color3f", ""}, {"straight", "directDiffuse", "float"}},
      {{"straight", "lpe:C<RD>[<L.>O]", "raw", "color3f", "d"}, {"d", "directDiffuse", "float"}},
      {{"odd", "C<RS>D", "lpe", "color3f", ""}, {"odd", "lpe:C<RS>D", "float"}}};
  for (const auto& [theirs, ours] : rows) {
    const hd::RenderVar made = TranslateRenderVar(theirs);
    EXPECT_EQ(made, ours) << theirs.prim << " of " << theirs.source_name << ": " << made.name << " " << made.aov.str();
  }
}

TEST(HydraValues, ProgressIsADouble) {
  const hd::Dictionary made = HostStatistics({{"percentDone", 12.5f}, {"samplesTotal", int64_t(4)}});
  EXPECT_EQ(made.at("percentDone"), hd::Value(12.5));
  EXPECT_EQ(made.at("samplesTotal"), hd::Value(int64_t(4)));
  EXPECT_EQ(made.at("fractionDone"), hd::Value(0.0)) << "hosts read it before anything is rendered";
}

}  // namespace
}  // namespace alabaster::hydra
