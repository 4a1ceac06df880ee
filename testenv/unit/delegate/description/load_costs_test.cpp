// Costs of loading a scene: files that are read, and time.
#include <OpenImageIO/imageio.h>

#include <nlohmann/json.hpp>
#include <random>

#include "testenv/support/bytes_read.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

using alabaster::testing::bytes_read;

class LoadCosts : public SceneFiles {};

// promise: security.decoded_once
TEST_F(LoadCosts, AnImageThatIsNamedOftenIsOpenedOnce) {
  constexpr int kSide = 512, kLights = 40;
  std::vector<uint8_t> noise(size_t(kSide) * kSide * 3);
  std::minstd_rand random(3);
  for (uint8_t& byte : noise) byte = uint8_t(random() >> 8);
  const std::string file = folder_ / "noise.png";
  const auto out = OIIO::ImageOutput::create(file);
  ASSERT_TRUE(out && out->open(file, OIIO::ImageSpec(kSide, kSide, 3, OIIO::TypeUInt8)) &&
              out->write_image(OIIO::TypeUInt8, noise.data()) && out->close());
  std::string lights;
  for (int i = 0; i < kLights; ++i)
    lights += (i ? "," : "") + std::string(R"({"name": "l)") + std::to_string(i) +
              R"(", "type": "rectLight", "texture:file": "noise.png"})";
  const uint64_t before = bytes_read();
  if (before == 0) GTEST_SKIP() << "the kernel counts no bytes that are read";
  ASSERT_TRUE(describe(R"({"gltf": [{"file": "patch.gltf"}], "lights": [)" + lights + "]}").ok) << errors();
  EXPECT_LT(bytes_read() - before, 8 * std::filesystem::file_size(file));
}

}  // namespace
}  // namespace alabaster::hd::description
