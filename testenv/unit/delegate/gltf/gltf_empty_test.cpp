// Lists and objects without content, wherever a document has one.
#include "testenv/support/build_paths.h"
#include "testenv/support/json_containers.h"
#include "testenv/unit/delegate/gltf/gltf_builder.h"

namespace alabaster::hd::gltf::testing {
namespace {

// Skin, morph targets, animation, variants and instances, with which documents of
// testenv/unit/delegate/gltf/translations do without.
GltfBuilder deformed_document() {
  GltfBuilder b;
  b.triangle();
  b.attribute<uint8_t>("JOINTS_0", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, "VEC4");
  b.attribute<float>("WEIGHTS_0", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
  const size_t target = b.add<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3");
  b.primitive()["targets"] = {{{"POSITION", target}}};
  b.primitive()["extensions"]["KHR_materials_variants"]["mappings"] = {{{"material", 0}, {"variants", {0}}}};
  b.json["materials"] = {{{"name", "a"}}};
  b.json["meshes"][0]["weights"] = {0.5};
  b.json["nodes"] = {
      {{"mesh", 0}, {"skin", 0}, {"weights", {0.25}}, {"children", {1}}}, {{"name", "joint"}}, {{"mesh", 0}}};
  b.json["scenes"] = {{{"nodes", {0, 2}}}};
  b.json["skins"] = {{{"joints", {1}}, {"skeleton", 1}}};
  b.node(2)["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
      b.add<float>({0, 0, 0, 1, 0, 0}, "VEC3");
  b.animate(0, "weights", {0, 1}, {0, 1}, "SCALAR");
  b.animate(1, "translation", {0, 1}, {0, 0, 0, 1, 0, 0}, "VEC3");
  b.json["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "v"}}};
  b.json["extensionsUsed"] = {"KHR_materials_variants", "EXT_mesh_gpu_instancing"};
  return b;
}

TEST(GltfEmpty, AnyListOrObjectMayBeEmpty) {
  const GltfBuilder deformed = deformed_document();
  std::vector<std::pair<Json, std::string>> documents{{deformed.document(), deformed.binary()}};
  for (const auto& entry :
       std::filesystem::directory_iterator(alabaster::testing::source_file("testenv/unit/delegate/gltf/translations")))
    if (entry.path().extension() == ".gltf") documents.emplace_back(Json::parse(read_text(entry.path())), "");
  ASSERT_GT(documents.size(), 9u);
  GltfOptions options;
  options.time = 0.5;
  const TemporaryFolder folder;
  size_t edits = 0;
  for (const auto& [sound, binary] : documents) {
    const auto load_edited = [&, &binary = binary](const Json& json) {
      return load(folder.write("edited.glb", make_glb(json.dump(), binary)), options);
    };
    const Loaded whole = load_edited(sound);
    ASSERT_TRUE(whole.summary.ok) << whole.said();
    for (const auto& [place, json] : emptied_documents(sound)) {
      SCOPED_TRACE(place);
      const Loaded loaded = load_edited(json);
      EXPECT_TRUE(loaded.summary.ok || loaded.count(Severity::error) > 0);
      ++edits;
    }
  }
  EXPECT_GT(edits, 500u);
}

// A mesh that nothing uses, one with weights, and one whose weights an animation moves.
TEST(GltfEmpty, AMeshWithoutPrimitivesIsAWarning) {
  GltfBuilder unused, weighted, animated = deformed_document();
  unused.triangle();
  unused.json["meshes"].push_back({{"primitives", Json::array()}});
  weighted.triangle();
  weighted.json["meshes"].push_back({{"primitives", Json::array()}, {"weights", {1}}});
  weighted.json["nodes"].push_back({{"mesh", 1}, {"weights", {1}}});
  animated.json["meshes"][0]["primitives"] = Json::array();
  for (const Loaded& loaded : {unused.load(), weighted.load(), animated.load_at(0.5)}) {
    EXPECT_TRUE(loaded.summary.ok) << loaded.said();
    EXPECT_TRUE(loaded.says(Severity::warning, ".primitives is empty")) << loaded.said();
  }
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
