#include "delegate/hydra/lights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace alabaster::hydra {
namespace {

using Parameters = std::map<hd::Token, hd::Value>;

hd::Value ask(Host host, const char* type, const char* name, const Parameters& held) {
  return TranslateLightParameter({host, true}, type, name, [&](const hd::Token& asked) {
    const auto found = held.find(asked);
    return found == held.end() ? hd::Value() : found->second;
  });
}

TEST(HydraLights, ParametersMayHaveAPrefix) {
  const Parameters spot{{"inputs:shaping:cone:angle", 35.0f}, {"radius", 0.5f}};
  EXPECT_EQ(ask(Host::any, "sphereLight", "shaping:cone:angle", spot), hd::Value(35.0f));
  EXPECT_EQ(ask(Host::any, "sphereLight", "radius", spot), hd::Value(0.5f));
  EXPECT_TRUE(ask(Host::any, "sphereLight", "length", spot).empty());
}

TEST(HydraLights, ASunOfBlenderGetsItsEnergyAndAngleBack) {
  const Parameters sun{{"intensity", 0.75f}, {"angle", 2.0f}, {"exposure", 1.0f}};
  EXPECT_EQ(ask(Host::blender, "distantLight", "intensity", sun), hd::Value(3.0f));
  EXPECT_EQ(ask(Host::blender, "distantLight", "angle", sun), hd::Value(4.0f));
  EXPECT_EQ(ask(Host::blender, "distantLight", "exposure", sun), hd::Value(1.0f));
  EXPECT_EQ(ask(Host::blender_usd, "distantLight", "intensity", sun), hd::Value(3.0f)) << "in either export";
  EXPECT_EQ(ask(Host::any, "distantLight", "intensity", sun), hd::Value(0.75f));
  EXPECT_EQ(ask(Host::blender, "sphereLight", "intensity", sun), hd::Value(0.75f)) << "suns alone";
  EXPECT_TRUE(ask(Host::blender, "distantLight", "intensity", {}).empty()) << "the delegate's default stays";
}

// Cycles: a smoothstep of the cosine from the cone's to that at (1 - blend) of the rest of the cap.
TEST(HydraLights, ASpotOfBlenderKeepsItsFlux) {
  const double outer = 35 * std::numbers::pi / 180;
  for (const float blend : {0.2f, 0.6f, 1.0f}) {
    const Parameters spot{{"inputs:shaping:cone:angle", 35.0f}, {"inputs:shaping:cone:softness", blend}};
    const hd::Value softness = ask(Host::blender, "sphereLight", "shaping:cone:softness", spot);
    const double inner = outer * (1 - softness.number_or(-1));
    double ours = 0, theirs = 0;
    constexpr int kSteps = 4000;
    const auto smoothstep = [](double t) { return t = std::clamp(t, 0.0, 1.0), t * t * (3 - 2 * t); };
    for (int i = 0; i < kSteps; ++i) {
      const double angle = (i + 0.5) / kSteps * outer;
      const double cap = (std::cos(angle) - std::cos(outer)) / (1 - std::cos(outer));
      ours += smoothstep((outer - angle) / (outer - inner)) * std::sin(angle);
      theirs += smoothstep(cap / double(blend)) * std::sin(angle);
    }
    EXPECT_NEAR(ours / theirs, 1, 2e-3) << blend;
    EXPECT_EQ(ask(Host::any, "sphereLight", "shaping:cone:softness", spot), hd::Value(blend));
  }
  const Parameters sharp{{"shaping:cone:angle", 35.0f}, {"shaping:cone:softness", 0.0f}};
  EXPECT_EQ(ask(Host::blender, "sphereLight", "shaping:cone:softness", sharp), hd::Value(0.0f));
}

TEST(HydraLights, AWorldOfOneColourIsSentOnce) {
  const auto image = [](const char* file) {
    return Parameters{{"texture:file", hd::AssetPath{file, file, nullptr}}, {"color", hd::Vec3f(1, 0, 0)}};
  };
  const Parameters plain = image("/tmp/b/usd/image_cache/color_2550255.hdr");
  EXPECT_TRUE(ask(Host::blender, "domeLight", "texture:file", plain).empty());
  EXPECT_EQ(ask(Host::blender, "domeLight", "color", plain), hd::Value(hd::Vec3f(1, 0, 0)));
  for (const Host host : {Host::any, Host::blender_usd})
    EXPECT_FALSE(ask(host, "domeLight", "texture:file", plain).empty()) << "export to USD sends the image alone";
  for (const char* file : {"/tmp/b/usd/image_cache/img_0x1.exr", "/pictures/color_sky.hdr"})
    EXPECT_FALSE(ask(Host::blender, "domeLight", "texture:file", image(file)).empty()) << file;
}

TEST(HydraLights, TheCameraSeesDomesUnlessTheHostSaysOtherwise) {
  const auto seen = [](const LightRules& rules, const char* type, const Parameters& held) {
    return TranslateLightParameter(rules, type, "visibleToCamera", [&](const hd::Token& asked) {
      const auto found = held.find(asked);
      return found == held.end() ? hd::Value() : found->second;
    });
  };
  EXPECT_EQ(seen({}, "domeLight", {}), hd::Value(true));
  EXPECT_EQ(seen({Host::blender, false}, "domeLight", {}), hd::Value(false));
  EXPECT_EQ(seen({}, "domeLight", {{"visibleToCamera", false}}), hd::Value(false));
  EXPECT_TRUE(seen({}, "rectLight", {}).empty());
}

TEST(HydraLights, HostsHaveNames) {
  EXPECT_EQ(HostOf("blender"), Host::blender);
  EXPECT_EQ(HostOf("blender_usd"), Host::blender_usd);
  EXPECT_EQ(HostOf("usdview"), Host::any);
  EXPECT_EQ(HostOf(""), Host::any);
}

}  // namespace
}  // namespace alabaster::hydra
