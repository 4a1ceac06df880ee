// Broken documents: each ends in an error that names the place, or in a warning where the fault is harmless.
#include <gtest/gtest.h>

#include <functional>

#include "testenv/support/gltf_testing.h"

namespace alabaster::hd::gltf::testing {
namespace {

// A triangle with all the elements that the cases below break.
Json sound_document() {
  return Json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0, "children": [1]}, {"camera": 0}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
    "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}}],
    "textures": [{"source": 0, "sampler": 0}], "samplers": [{}],
    "images": [{"bufferView": 2, "mimeType": "image/png"}],
    "buffers": [{"byteLength": 60}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 6},
                    {"buffer": 0, "byteOffset": 44, "byteLength": 16}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0,0,0], "max": [1,1,0]},
                  {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}]})");
}

std::string sound_binary() {
  const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const uint16_t indices[4] = {0, 1, 2, 0};
  std::string binary(reinterpret_cast<const char*>(points), sizeof points);
  binary.append(reinterpret_cast<const char*>(indices), sizeof indices);
  return binary + std::string("\x89PNG\r\n\x1a\n\0\0\0\0\0\0\0\0", 16);
}

Loaded load_document(const Json& document) {
  const TemporaryFolder folder;
  return load(folder.write("case.glb", make_glb(document.dump(), sound_binary())));
}

Json& accessor(Json& document) {
  return document["accessors"][0];
}
Json& view(Json& document) {
  return document["bufferViews"][0];
}

struct Case {
  const char* name;
  std::function<void(Json&)> damage;
  const char* place;  // must be named
  bool fatal = true;
};

// Faults that tinygltf accepts, and more of their kind.
const std::vector<Case> kCases = {
    {"accessor view out of range", [](Json& d) { accessor(d)["bufferView"] = 9; }, "accessors[0].bufferView"},
    {"accessor offset past the view", [](Json& d) { accessor(d)["byteOffset"] = 1000000000; }, "accessors[0]"},
    {"accessor count beyond memory", [](Json& d) { accessor(d)["count"] = int64_t(1) << 40; }, "accessors[0].count"},
    {"accessor count beyond its view", [](Json& d) { accessor(d)["count"] = 4; }, "accessors[0]"},
    {"accessor count zero", [](Json& d) { accessor(d)["count"] = 0; }, "accessors[0].count"},
    {"accessor count negative", [](Json& d) { accessor(d)["count"] = -3; }, "accessors[0].count"},
    {"accessor count not integral", [](Json& d) { accessor(d)["count"] = 2.5; }, "accessors[0].count"},
    {"accessor offset negative", [](Json& d) { accessor(d)["byteOffset"] = -4; }, "accessors[0].byteOffset"},
    {"accessor zeros beyond memory",
     [](Json& d) {
       accessor(d).erase("bufferView");
       accessor(d)["count"] = 2000000000;
     },
     "accessors[0]"},
    {"accessor component type", [](Json& d) { accessor(d)["componentType"] = 5124; }, "accessors[0].componentType"},
    {"accessor type", [](Json& d) { accessor(d)["type"] = "VEC5"; }, "accessors[0].type"},
    {"accessor type of points", [](Json& d) { accessor(d)["type"] = "VEC2"; }, "attributes.POSITION"},
    {"buffer of a view out of range", [](Json& d) { view(d)["buffer"] = 1; }, "bufferViews[0].buffer"},
    {"buffer of a view negative", [](Json& d) { view(d)["buffer"] = -1; }, "bufferViews[0].buffer"},
    {"view longer than its buffer", [](Json& d) { view(d)["byteLength"] = int64_t(1e15); }, "bufferViews[0]"},
    {"view length beyond integers", [](Json& d) { view(d)["byteLength"] = 1e18; }, "bufferViews[0].byteLength"},
    {"view that ends past its buffer", [](Json& d) { view(d)["byteOffset"] = 60; }, "bufferViews[0]"},
    {"image view longer than its buffer", [](Json& d) { d["bufferViews"][2]["byteLength"] = 4096; }, "bufferViews[2]"},
    {"stride no multiple of four", [](Json& d) { view(d)["byteStride"] = 14; }, "bufferViews[0].byteStride"},
    {"accessor zeros many times",
     [](Json& d) {
       accessor(d).erase("bufferView");
       accessor(d)["count"] = 20000000;
     },
     "accessors[0]"},
    {"stride below the element", [](Json& d) { view(d)["byteStride"] = 4; }, "accessors[0]"},
    {"node cycle", [](Json& d) { d["nodes"][1]["children"] = {0}; }, "nodes[0]"},
    {"node its own child", [](Json& d) { d["nodes"][1]["children"] = {1}; }, "nodes[1]"},
    {"node with two parents",
     [](Json& d) {
       d["nodes"].push_back({{"children", {1}}});
     },
     "nodes[1]"},
    {"child out of range", [](Json& d) { d["nodes"][0]["children"] = {7}; }, "nodes[0].children[0]"},
    {"mesh of a node", [](Json& d) { d["nodes"][0]["mesh"] = 3; }, "nodes[0].mesh"},
    {"camera of a node", [](Json& d) { d["nodes"][1]["camera"] = -1; }, "nodes[1].camera"},
    {"node of a scene", [](Json& d) { d["scenes"][0]["nodes"] = {99}; }, "scenes[0].nodes[0]"},
    {"default scene", [](Json& d) { d["scene"] = 9; }, "scene"},
    {"matrix of 15", [](Json& d) { d["nodes"][0]["matrix"] = std::vector<int>(15, 0); }, "nodes[0].matrix"},
    {"matrix of none", [](Json& d) { d["nodes"][0]["matrix"] = Json::array(); }, "nodes[0].matrix"},
    {"scale of none", [](Json& d) { d["nodes"][0]["scale"] = Json::array(); }, "nodes[0].scale"},
    {"emission of none", [](Json& d) { d["materials"][0]["emissiveFactor"] = Json::array(); },
     "materials[0].emissiveFactor"},
    {"nodes as an object", [](Json& d) { d["nodes"] = Json::object(); }, "nodes"},
    {"attribute out of range", [](Json& d) { d["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 5; },
     "attributes.POSITION"},
    {"mode 99", [](Json& d) { d["meshes"][0]["primitives"][0]["mode"] = 99; }, "primitives[0].mode"},
    {"indices negative", [](Json& d) { d["meshes"][0]["primitives"][0]["indices"] = -2; }, "primitives[0].indices"},
    {"indices of floats", [](Json& d) { d["meshes"][0]["primitives"][0]["indices"] = 0; }, "primitives[0].indices"},
    {"index not below the vertex count", [](Json& d) { accessor(d)["count"] = 2; }, "primitives[0].indices"},
    {"material out of range", [](Json& d) { d["meshes"][0]["primitives"][0]["material"] = 1; },
     "primitives[0].material"},
    {"sparse view",
     [](Json& d) {
       accessor(d)["sparse"] = {
           {"count", 1}, {"indices", {{"bufferView", 8}, {"componentType", 5123}}}, {"values", {{"bufferView", 0}}}};
     },
     "sparse.indices.bufferView"},
    {"sparse count",
     [](Json& d) {
       accessor(d)["sparse"] = {
           {"count", 50}, {"indices", {{"bufferView", 1}, {"componentType", 5123}}}, {"values", {{"bufferView", 0}}}};
     },
     "accessors[0].sparse.count"},
    {"sparse index past the count",
     [](Json& d) {
       accessor(d)["sparse"] = {
           {"count", 1}, {"indices", {{"bufferView", 2}, {"componentType", 5123}}}, {"values", {{"bufferView", 0}}}};
     },
     "accessors[0].sparse.indices"},
    {"texture source", [](Json& d) { d["textures"][0]["source"] = 4; }, "textures[0].source"},
    {"texture sampler", [](Json& d) { d["textures"][0]["sampler"] = 4; }, "textures[0].sampler"},
    {"animation references",
     [](Json& d) {
       d["animations"] = {{{"channels", {{{"sampler", 0}, {"target", {{"node", 44}, {"path", "scale"}}}}}},
                           {"samplers", {{{"input", 0}, {"output", 33}}}}}};
     },
     "animations[0].samplers[0].output"},
    {"yfov negative", [](Json& d) { d["cameras"][0]["perspective"]["yfov"] = -1; }, "cameras[0].perspective.yfov"},
    {"lens missing", [](Json& d) { d["cameras"][0].erase("perspective"); }, "cameras[0].perspective"},
    {"required extension", [](Json& d) { d["extensionsRequired"] = {"FOO_bar"}; }, "FOO_bar is not supported"},
    {"version 1.0", [](Json& d) { d["asset"]["version"] = "1.0"; }, "asset.version"},
    {"version 9.9", [](Json& d) { d["asset"]["version"] = "9.9"; }, "asset.version"},
    {"newer than we read", [](Json& d) { d["asset"]["minVersion"] = "2.1"; }, "asset.minVersion"},
    {"buffer longer than its data", [](Json& d) { d["buffers"][0]["byteLength"] = 64; }, "buffers[0].byteLength"},
    {"buffer above the folder", [](Json& d) { d["buffers"][0]["uri"] = "../x.bin"; }, "outside the folder"},
    {"buffer above the folder, encoded", [](Json& d) { d["buffers"][0]["uri"] = "a/%2e%2E/%2e./x.bin"; },
     "outside the folder"},
    {"buffer by absolute path", [](Json& d) { d["buffers"][0]["uri"] = "/etc/passwd"; }, "outside the folder"},
    {"buffer by scheme", [](Json& d) { d["buffers"][0]["uri"] = "file:///etc/passwd"; }, "scheme"},
    {"buffer missing", [](Json& d) { d["buffers"][0]["uri"] = "none.bin"; }, "none.bin"},
    {"buffer is a folder", [](Json& d) { d["buffers"][0]["uri"] = "."; }, "buffers[0]"},
    {"unknown Disney parameter",
     [](Json& d) {
       d["materials"][0]["extensions"]["ALAB_materials_disney"] = {{"scaterDistance", {1, 1, 1}}};
     },
     "did you mean 'scatterDistance'"},
    {"Disney texture that does not exist",
     [](Json& d) {
       d["materials"][0]["extensions"]["ALAB_materials_disney"] = {{"scatterDistanceTexture", {{"index", 9}}}};
     },
     "ALAB_materials_disney.scatterDistanceTexture.index"},
    {"Disney parameter of the wrong type",
     [](Json& d) {
       d["materials"][0]["extensions"]["ALAB_materials_disney"] = {{"baseColor", 0.5}};
     },
     "ALAB_materials_disney.baseColor"},
    // harmless
    {"image missing",
     [](Json& d) {
       d["images"][0] = {{"uri", "none.png"}};
     },
     "none.png", false},
    {"image outside",
     [](Json& d) {
       d["images"][0] = {{"uri", "../secret.png"}};
     },
     "outside the folder", false},
    {"image of another kind", [](Json& d) { d["images"][0]["bufferView"] = 0; }, "images[0]", false},
    {"bounds that lie",
     [](Json& d) {
       accessor(d)["max"] = {0.5, -1, 0};
     },
     "accessors[0] element 0 ", false},
    {"roughness out of range", [](Json& d) { d["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 2; },
     "roughnessFactor", false},
    {"rotation not of unit length",
     [](Json& d) {
       d["nodes"][0]["rotation"] = {0, 0, 2, 0};
     },
     "nodes[0].rotation", false},
    {"rotation of length zero",
     [](Json& d) {
       d["nodes"][0]["rotation"] = {0, 0, 0, 0};
     },
     "nodes[0].rotation", false},
    {"child listed twice",
     [](Json& d) {
       d["nodes"][0]["children"] = {1, 1};
     },
     "nodes[0].children[1]", false},
    {"joints without a common root",
     [](Json& d) {
       d["nodes"].push_back(Json::object());
       d["skins"] = {{{"joints", {1, 2}}}};
     },
     "skins[0]", false},
    {"undeclared extension",
     [](Json& d) {
       d["materials"][0]["extensions"]["KHR_materials_ior"] = {{"ior", 1.4}};
     },
     "KHR_materials_ior is used but not listed", false},
    {"misplaced extension", [](Json& d) { d["nodes"][0]["extensions"]["KHR_materials_ior"] = Json::object(); },
     "nodes[0].extensions.KHR_materials_ior", false},
};

TEST(GltfInvalid, TheSoundDocumentIsSound) {
  const Loaded loaded = load_document(sound_document());
  EXPECT_TRUE(loaded.summary.ok) << loaded.said();
  EXPECT_EQ(loaded.count(Severity::warning), 0u) << loaded.said();
  EXPECT_EQ(loaded.scene->GetMeshes().size(), 1u);
  EXPECT_EQ(loaded.scene->GetCameras().size(), 1u);
}

// promise: security.memory_safety
TEST(GltfInvalid, EveryDamageIsReportedWithItsPlace) {
  for (const Case& damaged : kCases) {
    Json document = sound_document();
    damaged.damage(document);
    const Loaded loaded = load_document(document);
    EXPECT_EQ(loaded.summary.ok, !damaged.fatal) << damaged.name << "\n" << loaded.said();
    EXPECT_TRUE(loaded.says(damaged.fatal ? Severity::error : Severity::warning, damaged.place)) << damaged.name << "\n"
                                                                                                 << loaded.said();
    EXPECT_TRUE(loaded.says(damaged.fatal ? Severity::error : Severity::warning, "case.glb")) << damaged.name;
    EXPECT_EQ(loaded.scene->GetMeshes().size(), damaged.fatal ? 0u : 1u) << damaged.name;
  }
}

// JSON.stringify writes null for infinity: three.js for the attenuationDistance of glass that does not absorb.
TEST(GltfInvalid, NullCountsAsAbsent) {
  Json document = sound_document();
  document["animations"] = nullptr;
  document["materials"][0]["extensions"] = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                                            {"KHR_materials_volume", {{"attenuationDistance", nullptr}}},
                                            {"KHR_materials_ior", nullptr}};
  const Loaded loaded = load_document(document);
  EXPECT_TRUE(loaded.summary.ok) << loaded.said();
  for (const char* place :
       {"animations is null", "KHR_materials_volume.attenuationDistance is null", "KHR_materials_ior is null"})
    EXPECT_TRUE(loaded.says(Severity::warning, place)) << place << "\n" << loaded.said();
  document["meshes"][0]["primitives"] = nullptr;
  EXPECT_TRUE(load_document(document).says(Severity::error, "meshes[0].primitives is required and missing"));
}

// Texts tell the fault, and after a semicolon what to do about it.
TEST(GltfInvalid, EveryErrorHasARemedy) {
  for (const Case& damaged : kCases) {
    Json document = sound_document();
    damaged.damage(document);
    for (const Diagnostic& d : load_document(document).diagnostics)
      EXPECT_TRUE(d.severity != Severity::error || d.text.find("; ") != std::string::npos)
          << damaged.name << ": " << d.where << " " << d.text;
  }
}

// promise: security.nesting
TEST(GltfInvalid, DeepJsonIsRefusedBeforeAnyParserSeesIt) {
  const TemporaryFolder folder;
  for (const size_t depth : {size_t(129), size_t(20000), size_t(2000000)}) {
    const Loaded loaded = folder.load_text(R"({"asset":{"version":"2.0"},"extras":)" + std::string(depth, '[') +
                                           std::string(depth, ']') + "}");
    EXPECT_FALSE(loaded.summary.ok);
    EXPECT_TRUE(loaded.says(Severity::error, "nested deeper")) << loaded.said();
  }
  EXPECT_TRUE(
      folder.load_text(R"({"asset":{"version":"2.0"},"extras":)" + std::string(100, '[') + std::string(100, ']') + "}")
          .summary.ok);
}

TEST(GltfInvalid, TextThatIsNotJson) {
  const TemporaryFolder folder;
  for (const char* text : {"", "{", "[]", "null", "{\"asset\":{\"version\":\"2.0\"},\"scene\":NaN}", "{\"a\":1e999}",
                           "{\"a\":\"\xff\"}", "glTF", "glT", "\xEF\xBB\xBF", "{\"a\":1}}"}) {
    const Loaded loaded = folder.load_text(text);
    EXPECT_FALSE(loaded.summary.ok) << text;
    EXPECT_GE(loaded.count(Severity::error), 1u) << text;
  }
}

TEST(GltfInvalid, ContainerThatLies) {
  const std::string sound = make_glb(sound_document().dump(), sound_binary());
  const TemporaryFolder folder;
  for (size_t length = 0; length < sound.size(); length += length < 32 ? 1 : 37) {
    const Loaded loaded = load(folder.write("cut.glb", sound.substr(0, length)));
    EXPECT_FALSE(loaded.summary.ok) << length;
    EXPECT_GE(loaded.count(Severity::error), 1u) << length;
  }
  for (size_t byte = 0; byte < 24; ++byte) {  // any outcome except a crash or an unreported refusal
    std::string broken = sound;
    broken[byte] = char(0xff);
    const Loaded loaded = load(folder.write("broken.glb", broken));
    EXPECT_TRUE(loaded.summary.ok || loaded.count(Severity::error) > 0) << byte;
  }
}

TEST(GltfInvalid, WhatIsNoFileIsNotRead) {
  const TemporaryFolder folder;
  EXPECT_TRUE(load(folder.path()).says(Severity::error, "not a regular file"));
  EXPECT_TRUE(load(folder.path() + "/none.gltf").says(Severity::error, "there is no such file"));
}

TEST(GltfInvalid, VersionOneIsNamedAndNothingElse) {
  const TemporaryFolder folder;
  const Json nodes = {{"a", {{"meshes", {"m"}}}}}, meshes = {{"m", Json::object()}};
  for (const Json& document :
       {Json{{"asset", {{"version", "1.0"}}}, {"nodes", nodes}, {"scene", "s"}}, Json{{"asset", {{"version", 1.0}}}},
        Json{{"nodes", nodes}, {"scene", "s"}}, Json{{"asset", {{"generator", "old"}}}, {"meshes", meshes}},
        Json{{"asset", {{"version", "2.0"}}}, {"nodes", nodes}, {"meshes", meshes}}}) {
    const Loaded loaded = folder.load_text(document.dump());
    EXPECT_TRUE(loaded.says(Severity::error, "the file is glTF 1.0")) << loaded.said();
    EXPECT_EQ(loaded.count(Severity::error), 1u) << loaded.said();
  }
  const std::string binary("glTF\1\0\0\0\x18\0\0\0\4\0\0\0\0\0\0\0{}  ", 24);
  const Loaded loaded = load(folder.write("old.glb", binary));
  EXPECT_TRUE(loaded.says(Severity::error, "the file is glTF 1.0")) << loaded.said();
  EXPECT_EQ(loaded.count(Severity::error), 1u) << loaded.said();
}

TEST(GltfInvalid, ManyChildrenListedTwiceDoNotMultiply) {
  Json document = {{"asset", {{"version", "2.0"}}}, {"nodes", Json::array()}};
  for (int i = 0; i < 64; ++i) document["nodes"].push_back({{"children", {i + 1, i + 1}}});
  document["nodes"].push_back(Json::object());
  const TemporaryFolder folder;
  EXPECT_TRUE(folder.load_text(document.dump()).summary.ok);  // 2^64 visits would never end
}

TEST(GltfInvalid, LongNodeChainsAreWalkedWithoutRecursion) {
  Json document = {{"asset", {{"version", "2.0"}}}, {"nodes", Json::array()}};
  for (int i = 0; i < 50000; ++i) document["nodes"].push_back({{"children", {i + 1}}});
  document["nodes"].push_back(Json::object());
  const TemporaryFolder folder;
  EXPECT_TRUE(folder.load_text(document.dump()).summary.ok);
}

// Documents with these faults must be refused. The corpus's file names tell the fault.
bool must_be_refused(const std::string& path) {
  for (const char* kind : {"/unresolved_", "/validator/glb/", "/validator/json/", "/validator/asset/",
                           "index_buffer_oob", "IndexOutOfRange", "node_loop", "RecursiveNodes", "scene-invalid-cycle",
                           "node-oob", "/version-", "Invalid_Json", "short-size", "wrongTypes", "invalid_object",
                           "buffer_view/invalid_length", "invalid_array_elements", "mesh-invalid", "no_bin_chunk"})
    if (path.find(kind) != std::string::npos) return true;
  return false;
}

TEST(GltfInvalid, EveryInvalidAssetIsRefusedOrWarnedOf) {
  const std::string assets = assets_folder();
  if (assets.empty()) GTEST_SKIP() << kNoAssets;
  size_t files = 0, refused = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(assets + "/invalid")) {
    const std::string path = entry.path().string(), extension = entry.path().extension().string();
    if (extension != ".gltf" && extension != ".glb") continue;
    const Loaded loaded = load(path);
    ++files;
    refused += !loaded.summary.ok;
    // Valid files may have an empty scene too, so that warning does not count as having found the fault.
    const size_t empty = loaded.says(Severity::warning, "gltf.scene.empty");
    EXPECT_GT(loaded.count(Severity::error) + loaded.count(Severity::warning), empty) << path;
    EXPECT_EQ(loaded.summary.ok, loaded.count(Severity::error) == 0) << path;
    EXPECT_FALSE(loaded.says(Severity::error, "gltf.internal")) << path << "\n" << loaded.said();
    EXPECT_FALSE(must_be_refused(path) && loaded.summary.ok) << path << "\n" << loaded.said();
    EXPECT_TRUE(loaded.summary.ok || loaded.scene->GetMaterials().empty()) << path;
  }
  EXPECT_EQ(files, 163u);
  EXPECT_GE(refused, 80u);
}

// promise: pipeline.memory.files
TEST(GltfInvalid, ReadingStaysBelowTheMemoryLimitByArithmetic) {
  const TemporaryFolder folder;
  GltfOptions options;
  options.memory_limit = size_t(8) << 20;
  const auto refused = [&](const Json& document, const std::string& what) {
    const Loaded loaded = load(folder.write("case.glb", make_glb(document.dump(), sound_binary())), options);
    EXPECT_FALSE(loaded.summary.ok);
    EXPECT_TRUE(loaded.says(Severity::error, what)) << loaded.said();
    EXPECT_TRUE(loaded.says(Severity::error, "of the memory limit of 8 MiB")) << loaded.said();
  };
  Json values = sound_document();
  for (int i = 0; i < 50000; ++i) values["extras"].push_back({{"", 0}});
  refused(values, "JSON of 100");
  Json buffers = sound_document();
  folder.write("large.bin", std::string(size_t(9) << 20, 'x'));
  buffers["buffers"].push_back({{"uri", "large.bin"}, {"byteLength", 1000}});
  refused(buffers, "large.bin' needs ");
  // Zeros cost the file nothing, and each primitive decodes them again.
  Json zeros = sound_document();
  zeros["accessors"].push_back({{"componentType", 5126}, {"type", "VEC3"}, {"count", 100000}});
  for (int i = 0; i < 10; ++i)
    zeros["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", zeros["accessors"].size() - 1}}}});
  refused(zeros, "the geometry of its meshes needs ");
  options.memory_limit = size_t(256) << 20;
  EXPECT_TRUE(load(folder.write("case.glb", make_glb(zeros.dump(), sound_binary())), options).summary.ok);
}

TEST(GltfInvalid, AFileOfManyBuffersIsReadOnce) {
  const TemporaryFolder folder;
  folder.write("many.bin", std::string(1000, 'x'));
  Json document = sound_document();
  for (int i = 0; i < 2000; ++i) document["buffers"].push_back({{"uri", "many.bin"}, {"byteLength", 1000}});
  const Loaded loaded = load(folder.write("case.glb", make_glb(document.dump(), sound_binary())));
  EXPECT_TRUE(loaded.summary.ok) << loaded.said();
  EXPECT_EQ(loaded.summary.files.size(), 2u);
}

}  // namespace
}  // namespace alabaster::hd::gltf::testing
