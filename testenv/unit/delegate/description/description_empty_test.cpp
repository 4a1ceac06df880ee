// Lists and objects without content, wherever a description has one.
#include "testenv/support/json_containers.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::hd::description {
namespace {

constexpr const char* kDescription = R"({
  "gltf": [{"file": "lit.gltf", "motion": [{"time": -1, "transform": {"translate": [1, 0, 0]}},
                                           {"time": 1, "transform": {"translate": [3, 0, 0]}}]},
           {"file": "patch.gltf", "transform": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,5,1]}],
  "materials": [{"match": "skin", "set": {"scatterDistance": [0.2, 0.1, 0.05]},
                 "bump": {"file": "heights.hdr", "scale": 0.5}},
                {"name": "wax", "set": {"baseColor": [0.5, 0.4, 0.3]}, "displacement": {"file": "heights.hdr"}}],
  "meshes": [{"match": "*patch*", "scheme": "loop", "refineLevel": 1, "material": "wax",
              "creases": [{"points": [0, 1, 2], "sharpness": 2.5}], "corners": [{"point": 3, "sharpness": 4}],
              "motion": [{"time": 0, "transform": {}}, {"time": 1, "transform": {"translate": [0, 5, 0]}}]}],
  "lights": [{"name": "key", "type": "rectLight", "position": [0, 2, 2], "target": [0, 0, 0], "color": [1, 0.5, 0.2],
              "lightLink": ["*patch*"]},
             {"name": "sky", "type": "domeLight", "texture:file": "heights.hdr"}],
  "camera": {"lookAt": {"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]},
             "clipPlanes": [[1, 0, 0, 0.5], [0, 1, 0, 0]], "shutterOpen": -0.5, "shutterClose": 0.5},
  "settings": {"resolution": [8, 8], "crop": [0, 0, 4, 4], "samples": 1},
  "products": [{"file": "a.exr", "aovs": ["color", "depth"], "resolution": [4, 4], "crop": [1, 1, 3, 3]}]})";

class DescriptionEmpty : public SceneFiles {};

TEST_F(DescriptionEmpty, AnyListOrObjectMayBeEmpty) {
  write_image("heights.hdr");
  ASSERT_TRUE(describe(kDescription).ok) << errors();
  const auto documents = emptied_documents(nlohmann::json::parse(kDescription));
  EXPECT_GT(documents.size(), 50u);
  for (const auto& [place, document] : documents) {
    SCOPED_TRACE(place);
    const bool ok = describe(document.dump()).ok;
    EXPECT_EQ(ok, errors().empty()) << errors();
  }
}

}  // namespace
}  // namespace alabaster::hd::description
