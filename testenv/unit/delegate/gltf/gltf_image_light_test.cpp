// EXT_lights_image_based: faces of a cube as the image of a dome.
#include <cmath>

#include "core/images/image_file.h"
#include "core/light/dome_light.h"
#include "core/texture/texture.h"
#include "delegate/support/lookup.h"
#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::gltf::testing {
namespace {

const Vec3d kAxes[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

class Rows final : public RowSource {
 public:
  Rows(std::vector<uint8_t> pixels, size_t row) : pixels_(std::move(pixels)), row_(row) {}
  size_t row_bytes() const override { return row_; }
  void encode(int begin, int end, uint8_t* out) const override {
    std::copy(pixels_.begin() + std::ptrdiff_t(size_t(begin) * row_),
              pixels_.begin() + std::ptrdiff_t(size_t(end) * row_), out);
  }

 private:
  const std::vector<uint8_t> pixels_;
  const size_t row_;
};

// A PNG of one colour, RGB or RGBA.
std::vector<uint8_t> plain_png(int size, const std::vector<uint8_t>& pixel) {
  ImageDescription description;
  description.kind = FileKind::png;
  description.width = description.height = size;
  for (size_t c = 0; c < pixel.size(); ++c)
    description.channels.push_back({std::string(1, "RGBA"[c]), ChannelStore::uint8});
  std::vector<uint8_t> pixels, file;
  for (int i = 0; i < size * size; ++i) pixels.insert(pixels.end(), pixel.begin(), pixel.end());
  std::string fault;
  EXPECT_EQ(image_functions(&fault)->encode(description, Rows(pixels, size_t(size) * pixel.size()), file), "");
  return file;
}

// A sky of 4 x 4 texels a face: red +x, all else dark.
GltfBuilder sky(const std::vector<uint8_t>& bright = {255, 0, 0}) {
  GltfBuilder b;
  b.triangle();
  b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"EXT_lights_image_based"};
  for (const auto& pixel : {bright, std::vector<uint8_t>{0, 0, 0}})
    b.json["images"].push_back({{"bufferView", b.view(plain_png(4, pixel))}});
  b.json["extensions"]["EXT_lights_image_based"]["lights"] = {
      {{"specularImageSize", 4}, {"specularImages", {{0, 1, 1, 1, 1, 1}}}}};
  b.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
  return b;
}

Json& light_of(GltfBuilder& b) {
  return b.json["extensions"]["EXT_lights_image_based"]["lights"][0];
}

// The radiance that the scene's dome has in a direction.
Rgb radiance(const Loaded& loaded, const Vec3d& direction) {
  const auto& lights = loaded.scene->GetLights();
  EXPECT_EQ(lights.size(), 1u) << loaded.said();
  if (lights.size() != 1) return {};
  const auto asset = lights.begin()->second.parameters.at("texture:file").get_or(AssetPath());
  EXPECT_TRUE(asset.bytes) << loaded.said();
  const auto colors = ColorConfig::load("built-in", {});
  TextureSource source;
  source.path = asset.authored, source.bytes = asset.bytes, source.wrap_t = Wrap::clamp;
  alabaster::LightParameters description;
  description.type = LightType::dome;
  description.light_to_world = lights.begin()->second.transform;
  description.intensity = lights.begin()->second.parameters.at("intensity").get_or(0.0f);
  description.texture = load_texture(source, *colors, {});
  const auto hit = DomeLight(description, {}, {}).intersect({{}, to_float(direction)});
  return hit ? hit->radiance : Rgb(0);
}

TEST(GltfImageLight, IsADomeThatTheRotationTurns) {
  const Loaded plain = sky().load();
  ASSERT_TRUE(plain.summary.ok) << plain.said();
  EXPECT_EQ(support::keys_of(plain.scene->GetLights()), (std::vector<Path>{"/gltf/made/lights/image_0"}));
  for (const Vec3d& axis : kAxes) EXPECT_NEAR(radiance(plain, axis).r, axis.x > 0 ? 1 : 0, 1e-3);

  GltfBuilder turned = sky();  // a quarter turn about y takes +x to -z
  light_of(turned)["rotation"] = {0, std::sqrt(0.5), 0, std::sqrt(0.5)};
  light_of(turned)["intensity"] = 3;
  const Loaded loaded = turned.load();
  for (const Vec3d& axis : kAxes) EXPECT_NEAR(radiance(loaded, axis).r, axis.z < 0 ? 3 : 0, 1e-3);
}

// sRGB 188 is .5029 linear.
TEST(GltfImageLight, FourChannelsAreRgbd) {
  EXPECT_NEAR(radiance(sky({188, 188, 188}).load(), {1, 0, 0}).g, 0.5029, 1e-3);
  EXPECT_NEAR(radiance(sky({188, 188, 188, 255}).load(), {1, 0, 0}).g, 0.5029, 1e-3);
  EXPECT_NEAR(radiance(sky({188, 188, 188, 5}).load(), {1, 0, 0}).g, 0.5029 * 51, 0.03);
  EXPECT_NEAR(radiance(sky({255, 255, 255, 0}).load(), {1, 0, 0}).g, 255, 0.3);
}

TEST(GltfImageLight, BelongsToTheSceneThatNamesIt) {
  GltfBuilder b = sky();
  b.json["scenes"].push_back({{"nodes", {0}}});
  GltfOptions other;
  other.scene = "1";
  EXPECT_TRUE(b.load(other).scene->GetLights().empty());
  EXPECT_EQ(b.load().scene->GetLights().size(), 1u);
}

// The light stays, with an image that the renderer refuses, so that it decides about --keep-going.
TEST(GltfImageLight, AFaceThatCannotBeUsedIsLeftToTheRenderer) {
  const auto asset = [](const Loaded& loaded) {
    EXPECT_TRUE(loaded.summary.ok) << loaded.said();
    return loaded.scene->GetLights().begin()->second.parameters.at("texture:file").get_or(AssetPath());
  };
  GltfBuilder small = sky();
  light_of(small)["specularImageSize"] = 8;
  const Loaded resized = small.load();
  EXPECT_TRUE(resized.says(Severity::warning, "images[0] has 4 x 4 pixels, but specularImageSize is 8"))
      << resized.said();
  EXPECT_FALSE(asset(resized).bytes);

  GltfBuilder large = sky();
  light_of(large)["specularImageSize"] = 2;
  const Loaded cut = large.load();
  EXPECT_TRUE(cut.says(Severity::warning, "cannot be a face of extensions.EXT_lights_image_based.lights[0]"));
  EXPECT_FALSE(asset(cut).bytes);

  GltfBuilder broken = sky();
  broken.json["images"][1] = {{"bufferView", broken.view(std::vector<uint8_t>{0x89, 'P', 'N', 'G', 13, 10, 26, 10})}};
  const Loaded damaged = broken.load();
  EXPECT_TRUE(damaged.says(Severity::warning, "images[1] cannot be a face")) << damaged.said();
  EXPECT_EQ(asset(damaged).authored, "made.glb#images[1]");

  GltfBuilder missing = sky();
  missing.json["images"][1] = {{"uri", "nowhere.png"}};
  EXPECT_EQ(asset(missing.load()).authored, "nowhere.png");
}

TEST(GltfImageLight, FaultyDocumentsAreRefused) {
  const auto says = [](const char* text, const std::function<void(GltfBuilder&)>& edit) {
    GltfBuilder b = sky();
    edit(b);
    const Loaded loaded = b.load();
    EXPECT_FALSE(loaded.summary.ok);
    EXPECT_TRUE(loaded.says(Severity::error, text)) << text << "\n" << loaded.said();
  };
  says("lights[0].specularImages must be", [](GltfBuilder& b) { light_of(b)["specularImages"] = Json::array(); });
  says("lights[0].specularImages must be", [](GltfBuilder& b) { light_of(b)["specularImages"] = {{0, 1}}; });
  says("lights[0].specularImages must be", [](GltfBuilder& b) { light_of(b).erase("specularImages"); });
  says("specularImages[0][2] must be an index", [](GltfBuilder& b) { light_of(b)["specularImages"][0][2] = 2; });
  says("specularImages[0][2] must be an index", [](GltfBuilder& b) { light_of(b)["specularImages"][0][2] = "x"; });
  says("specularImageSize", [](GltfBuilder& b) { light_of(b)["specularImageSize"] = 100000; });
  says("scenes[0].extensions.EXT_lights_image_based.light",
       [](GltfBuilder& b) { b.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 1; });
}

TEST(GltfImageLight, CountsItsMemory) {
  GltfBuilder b = sky();
  light_of(b)["specularImageSize"] = 4096;
  GltfOptions options;
  options.memory_limit = size_t(100) << 20;
  const Loaded loaded = b.load(options);
  EXPECT_FALSE(loaded.summary.ok);
  EXPECT_TRUE(loaded.says(Severity::error, "EXT_lights_image_based.lights[0]")) << loaded.said();
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
