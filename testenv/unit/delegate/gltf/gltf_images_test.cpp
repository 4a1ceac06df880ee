// Which image a texture uses, and which kinds are refused.
#include <set>

#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::gltf::testing {
namespace {

using Bytes = std::vector<uint8_t>;

Bytes bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

// Image 0 is a PNG, 1 a WebP, 2 a KTX2, by their first bytes.
GltfBuilder pictures(const Json& texture) {
  GltfBuilder b;
  b.triangle();
  b.attribute<float>("TEXCOORD_0", {0, 0, 1, 0, 0, 1}, "VEC2");
  const size_t png = b.view(bytes_of({"\x89PNG\r\n\x1a\n\0\0\0\0", 12}));
  const size_t webp = b.view(bytes_of({"RIFF\4\0\0\0WEBP", 12}));
  const size_t ktx = b.view(bytes_of({"\xabKTX 20\xbb\r\n\x1a\n", 12}));
  b.json["images"] = {{{"bufferView", png}}, {{"bufferView", webp}}, {{"bufferView", ktx}}};
  b.json["textures"] = {texture};
  b.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
  b.primitive()["material"] = 0;
  return b;
}

std::string image_of(const Loaded& loaded) {
  for (const auto& [id, node] : loaded.scene->GetMaterials().begin()->second.nodes)
    if (const auto file = node.parameters.find("file"); file != node.parameters.end())
      return file->second.get_or(AssetPath()).authored;
  return {};
}

TEST(GltfImages, WebPComesBeforeTheTexturesOwnSource) {
  const Json webp = {{"EXT_texture_webp", {{"source", 1}}}};
  for (const Json& texture : {Json{{"source", 0}, {"extensions", webp}}, Json{{"extensions", webp}}}) {
    GltfBuilder b = pictures(texture);
    b.json["extensionsUsed"] = b.json["extensionsRequired"] = {"EXT_texture_webp"};
    const Loaded loaded = b.load();
    EXPECT_TRUE(loaded.summary.ok) << loaded.said();
    EXPECT_EQ(image_of(loaded), "made.glb#images[1]");
  }
  const Loaded undeclared = pictures({{"source", 0}}).load();
  EXPECT_EQ(image_of(undeclared), "made.glb#images[0]");
  EXPECT_TRUE(undeclared.says(Severity::warning, "images[1] is WebP, which needs EXT_texture_webp"));
}

// The renderer decodes an image once for each vector of bytes.
TEST(GltfImages, ImagesOfTheSameBytesShareThem) {
  GltfBuilder b = pictures({{"source", 0}});
  const Json view = b.json["images"][0], data = {{"uri", "data:image/png;base64,iVBORw0KGgoAAAAA"}};
  b.json["images"] = Json::array();
  for (int i = 0; i < 20; ++i) b.json["images"].push_back(i % 2 == 0 ? view : data);
  for (size_t i = 0; i < 20; ++i) {
    b.json["textures"][i] = {{"source", i}};
    b.json["materials"][i] = {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}};
  }
  const Loaded loaded = b.load();
  ASSERT_TRUE(loaded.summary.ok) << loaded.said();
  std::set<const void*> images;
  size_t named = 0;
  for (const auto& [path, material] : loaded.scene->GetMaterials())
    for (const auto& [id, node] : material.nodes)
      if (const auto file = node.parameters.find("file"); file != node.parameters.end()) {
        images.insert(file->second.get_or(AssetPath()).bytes.get());
        ++named;
      }
  EXPECT_EQ(named, 20u);
  EXPECT_EQ(images.size(), 2u);
}

// Programs that escape every URI escape the payload of data URIs, too.
TEST(GltfImages, Base64MayBePercentEncoded) {
  GltfBuilder b;
  b.triangle();
  b.json["textures"] = {{{"source", 0}}};
  b.json["images"] = {{{"uri", "data:image/png;base64,iVBORw0KGgoAAA%2BA%2Fw%3D%3D"}},
                      {{"uri", "data:image/png;base64,iV%ZZ"}}};
  const Loaded loaded = b.load();
  EXPECT_FALSE(loaded.says(Severity::warning, "images[0]")) << loaded.said();
  EXPECT_TRUE(loaded.says(Severity::warning, "images[1] the data URI's payload is not base64")) << loaded.said();
}

// Blender 3.4 writes names of buffers as they are, other exporters names of images.
TEST(GltfImages, APercentSignWithoutTwoDigitsStandsForItself) {
  GltfBuilder b;
  b.triangle();
  b.json["images"] = {{{"uri", "10%.png"}}, {{"uri", "20%25.png"}}, {{"uri", "30%2.png"}}, {{"uri", "40%4"}}};
  const Loaded loaded = b.load();
  EXPECT_TRUE(loaded.summary.ok) << loaded.said();
  for (const char* name : {"/10%.png'", "/20%.png'", "/30%2.png'", "/40%4'"})
    EXPECT_TRUE(loaded.says(Severity::warning, name)) << name << "\n" << loaded.said();  // there is no such file
}

TEST(GltfImages, NamesThatAreNoPathsHereAreToldAsWhatTheyAre) {
  const std::pair<const char*, const char*> cases[] = {{"https://host/a.png", "a URI with the scheme 'https:'"},
                                                       {"file:///a.png", "a URI with the scheme 'file:'"},
                                                       {"C:\\a.png", "a drive letter, 'C:'"},
                                                       {"C:/a.png", "a drive letter, 'C:'"},
                                                       {"\\\\server\\a.png", "a share of Windows"},
                                                       {"data:image/png", "the data URI has no payload"},
                                                       {"/elsewhere/a.png", "an absolute path"},
                                                       {"../a.png", "outside the folder"}};
  for (const auto& [uri, said] : cases) {
    GltfBuilder b;
    b.triangle();
    b.json["images"] = {{{"uri", uri}}};
    EXPECT_TRUE(b.load().says(Severity::warning, said)) << uri << "\n" << b.load().said();
    const Json buffer = {{"uri", uri}, {"byteLength", 4}};
    const TemporaryFolder folder;
    const Loaded loaded = folder.load_text(Json{{"asset", {{"version", "2.0"}}}, {"buffers", {buffer}}}.dump());
    EXPECT_TRUE(loaded.says(Severity::error, said)) << uri << "\n" << loaded.said();
  }
}

TEST(GltfImages, BasisUniversalIsRefusedByNameUnlessThereIsAnotherImage) {
  const Json basisu = {{"KHR_texture_basisu", {{"source", 2}}}};
  EXPECT_EQ(image_of(pictures({{"source", 0}, {"extensions", basisu}}).load()), "made.glb#images[0]");
  const Loaded alone = pictures({{"extensions", basisu}}).load();
  EXPECT_TRUE(alone.says(Severity::warning, "images[2] is KTX2 (KHR_texture_basisu), which is not supported"))
      << alone.said();
  EXPECT_EQ(image_of(alone), "made.glb#images[2]");  // without bytes: the renderer refuses it where it is used
  GltfBuilder required = pictures({{"extensions", basisu}});
  required.json["extensionsUsed"] = required.json["extensionsRequired"] = {"KHR_texture_basisu"};
  EXPECT_TRUE(required.load().says(Severity::error, "KHR_texture_basisu is not supported"));
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
