// Which files a scene file may name: those in its own folder or below, unless the user allows others.
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

class OutsideFiles : public SceneFiles {
 protected:
  void SetUp() override {
    SceneFiles::SetUp();
    std::filesystem::create_directories(folder_ / "scenes");
  }
  /// A description in the folder scenes, beside which the models lie.
  SceneFile describe_below(const std::string& text, const LoadOptions& options = {}) {
    write("scenes/scene.json", text);
    return load("scenes/scene.json", options);
  }
  static LoadOptions allowed() {
    LoadOptions options;
    options.allow_outside = true;
    return options;
  }
};

#define EXPECT_REFUSED(file)                                                                    \
  do {                                                                                          \
    EXPECT_FALSE((file).ok);                                                                    \
    EXPECT_NE(errors().find("outside the folder of the file that names it"), std::string::npos) \
        << "said: " << errors();                                                                \
    EXPECT_NE(errors().find("--allow-outside"), std::string::npos);                             \
  } while (false)

// promise: security.reads
TEST_F(OutsideFiles, AModelAboveIsRefused) {
  const std::string text = R"({"gltf": [{"file": "../patch.gltf"}]})";
  EXPECT_REFUSED(describe_below(text));
  EXPECT_NE(errors().find("/gltf/0/file"), std::string::npos) << errors();
  EXPECT_TRUE(describe_below(text, allowed()).ok) << errors();
}

TEST_F(OutsideFiles, AbsoluteNamesOfFilesBelowAreAllowed) {
  EXPECT_TRUE(describe(R"({"gltf": [{"file": ")" + (folder_ / "patch.gltf").string() + "\"}]}").ok) << errors();
  EXPECT_REFUSED(describe(R"({"gltf": [{"file": "patch.gltf"}], "products": [{"file": "/tmp/elsewhere.exr"}]})"));
}

// A neighbour whose name begins with the folder's is not below it.
TEST_F(OutsideFiles, FoldersAreComparedWhole) {
  std::filesystem::create_directories(folder_ / "scenes2");
  write_image("scenes2/sky.hdr");
  const std::string dome =
      R"({"lights": [{"name": "sky", "type": "domeLight", "texture:file": "../scenes2/sky.hdr"}]})";
  EXPECT_REFUSED(describe_below(dome));
  EXPECT_TRUE(describe_below(dome, allowed()).ok) << errors();
}

TEST_F(OutsideFiles, LinksAreFollowed) {
  write_image("sky.hdr");
  std::filesystem::create_symlink(folder_ / "sky.hdr", folder_ / "scenes" / "link.hdr");
  const std::string dome = R"({"lights": [{"name": "sky", "type": "domeLight", "texture:file": "link.hdr"}]})";
  EXPECT_REFUSED(describe_below(dome));
  std::filesystem::create_directory_symlink(folder_ / "scenes", folder_ / "same");
  write_image("scenes/near.hdr");
  write("scenes/scene.json", R"({"lights": [{"name": "sky", "type": "domeLight", "texture:file": "near.hdr"}]})");
  EXPECT_TRUE(load("same/scene.json").ok) << errors();
}

// A link whose file is missing: a picture would be made where it leads.
TEST_F(OutsideFiles, LinksThatLeadNowhereAreFollowed) {
  std::filesystem::create_symlink(folder_ / "victim.exr", folder_ / "scenes" / "out.exr");
  write("scenes/m.gltf", patch_gltf(false, false));
  std::filesystem::copy_file(folder_ / "patch.bin", folder_ / "scenes/patch.bin");
  EXPECT_REFUSED(describe_below(R"({"gltf": [{"file": "m.gltf"}], "products": [{"file": "out.exr"}]})"));
}

TEST_F(OutsideFiles, TilesOfASetAreFollowed) {
  write_image("outer.hdr");
  write_image("scenes/t.1001.hdr");
  const std::string text = R"({"gltf": [{"file": "m.gltf"}],
    "materials": [{"match": "skin", "set": {"baseColor": {"file": "t.<UDIM>.hdr"}}}]})";
  write("scenes/m.gltf", patch_gltf(false, false));
  write("scenes/patch.bin", "");
  std::filesystem::copy_file(folder_ / "patch.bin", folder_ / "scenes/patch.bin",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_TRUE(describe_below(text).ok) << errors();
  std::filesystem::create_symlink(folder_ / "outer.hdr", folder_ / "scenes" / "t.1002.hdr");
  EXPECT_REFUSED(describe_below(text));
}

TEST_F(OutsideFiles, ABufferOfAGltfFileIsRefused) {
  std::string text = patch_gltf(false, false);
  text.replace(text.find("patch.bin"), 9, "../patch.bin");
  write("scenes/m.gltf", text);
  EXPECT_REFUSED(load("scenes/m.gltf"));
  EXPECT_TRUE(load("scenes/m.gltf", allowed()).ok) << errors();
  std::filesystem::create_symlink(folder_ / "patch.bin", folder_ / "scenes" / "patch.bin");
  write("scenes/linked.gltf", patch_gltf(false, false));
  EXPECT_REFUSED(load("scenes/linked.gltf"));
}

TEST_F(OutsideFiles, TheUsersOwnWordsNameAnyFile) {
  write_image("sky.hdr");
  write("scenes/scene.json", R"({"lights": [{"name": "a", "type": "rectLight"}]})");
  LoadOptions options = with_dome((folder_ / "sky.hdr").string());
  options.overrides = {"lights/a.texture:file=" + (folder_ / "sky.hdr").string()};
  EXPECT_TRUE(load("scenes/scene.json", options).ok) << errors();
}

}  // namespace
}  // namespace alabaster::hd::description
