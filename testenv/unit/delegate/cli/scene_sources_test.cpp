// What holds for models of every kind, from outside: the reader of a file, and what is done to its prims.
#include <cmath>
#include <nlohmann/json.hpp>

#include "delegate/archive/archive.h"
#include "testenv/unit/delegate/cli/picture_values.h"
#include "testenv/unit/delegate/cli/run_program.h"
#include "testenv/unit/delegate/description/scene_fixture.h"

namespace alabaster::cli {
namespace {

using nlohmann::json;

#define EXPECT_HAS(text, part) EXPECT_NE((text).find(part), std::string::npos) << "said: " << (text)

class SceneSources : public hd::description::SceneFiles {
 protected:
  Outcome run(const std::vector<std::string>& arguments) const { return run_program(folder_, arguments); }
  std::vector<float> pixels(const std::string& file) const { return pixels_of(folder_ / file); }
  /// An archive of that list of prims, and what else is said beside it.
  void write_archive(const std::string& name, int version, const std::string& text) const {
    std::string header = R"({"__metadata__":{"format":"alabaster scene","version":")" + std::to_string(version) +
                         R"("},"scene.json":{"dtype":"U8","shape":[)" + std::to_string(text.size()) +
                         R"(],"data_offsets":[0,)" + std::to_string(text.size()) + "]}}";
    header.resize((header.size() + 7) / 8 * 8, ' ');
    std::string file(8, '\0');
    for (size_t i = 0; i < 8; ++i) file[i] = char(header.size() >> (8 * i) & 255);
    write(name, file + header + text);
  }
};

// promise: pipeline.archive.answers
TEST_F(SceneSources, AnArchiveFileRemovesAndChangesNothing) {
  write_archive("removed.alab", 2, R"({"prims":[],"removed":["/a"]})");
  write_archive("changes.alab", 2, R"({"prims":[{"path":"/a","fields":[]}]})");
  for (const char* file : {"removed.alab", "changes.alab"}) {
    const Outcome outcome = run({"info", file});
    EXPECT_EQ(outcome.code, 3) << outcome.err;
    EXPECT_HAS(outcome.err, file);
  }
  EXPECT_HAS(run({"info", "removed.alab"}).err,
             "it has a list of removed prims, as only the answers of a reader that follows time have");
  EXPECT_HAS(run({"info", "changes.alab"}).err, "a prim has no kind");
}

// The archives of earlier programs are read, with the names that these took from paths.
// promise: pipeline.archive.versions
TEST_F(SceneSources, AnOlderArchiveIsReadAsBefore) {
  write_archive("old.alab", 1, R"({"prims":[{"path":"/gltf/bust/materials/2_skin","kind":"material",
    "fields":[["surface.type",{"token":"AlabasterDisney"}],["surface.roughness",{"float":0.5}],
    ["surface",{"path":"surface.surface"}]]},
    {"path":"/eye","kind":"camera","fields":[]}]})");
  const Outcome outcome = run({"info", "old.alab", "--json", "--set", "materials/skin.roughness=0.25"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json info = json::parse(outcome.out);
  EXPECT_EQ(info["materials"][0]["name"], "skin");
  EXPECT_EQ(info["materials"][0]["nodes"][0]["parameters"]["roughness"], 0.25);
  write_archive("new.alab", 3, R"({"prims":[]})");
  EXPECT_HAS(run({"info", "new.alab"}).err, "version 3, and this program reads up to version 2");
}

// Names that a glTF gives its prims stay theirs in an archive of them.
// promise: pipeline.archive.facts
TEST_F(SceneSources, AnArchiveKeepsNames) {
  ASSERT_EQ(run({"convert", "lit.gltf", "-o", "lit.alab"}).code, 0);
  for (const char* file : {"lit.gltf", "lit.alab"}) {
    const Outcome outcome = run({"info", file, "--json", "--set", "materials/skin.roughness=0.25", "--set",
                                 "meshes/patch.refineLevel=1", "--set", "lights/lamp.intensity=2"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const json info = json::parse(outcome.out);
    EXPECT_EQ(info["materials"][0]["name"], "skin") << file;
    EXPECT_EQ(info["meshes"][0]["name"], "patch") << file;
    EXPECT_EQ(info["cameras"][0]["name"], "front") << file;
    EXPECT_EQ(info["models"][0]["upAxis"], "Y") << file;
  }
}

/// A bracket of two plates, which looks different from every side.
hd::host::MeshDescription bracket() {
  hd::host::MeshDescription mesh;
  mesh.topology.faceVertexCounts = {4, 4};
  mesh.topology.faceVertexIndices = {0, 1, 2, 3, 0, 4, 5, 1};
  mesh.primvars["points"].value =
      hd::Array<hd::Vec3f>{{0, 0, 0}, {3, 0, 0}, {3, 0, 2}, {0, 0, 2}, {0, 1.5f, 0}, {3, 1, 0}};
  return mesh;
}

// promise: pipeline.archive.facts
TEST_F(SceneSources, ASceneWhereZIsUpHasThePictureOfOneWhereYIs) {
  const hd::Matrix4d turn(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1);
  hd::archive::SceneInfo z_up;
  z_up.up = "Z", z_up.metersPerUnit = 0.01, z_up.timeCodesPerSecond = 24, z_up.range = {1, 48};
  hd::host::RetainedSceneDelegate y, z;
  y.SetMesh("/bracket", bracket());
  hd::host::MeshDescription turned = bracket();
  turned.transform = turn;
  z.SetMesh("/bracket", turned);
  ASSERT_EQ(hd::archive::WriteArchive(folder_ / "y.alab", y.GetPrims()), "");
  ASSERT_EQ(hd::archive::WriteArchive(folder_ / "z.alab", z.GetPrims(), z_up), "");
  ASSERT_EQ(hd::archive::WriteArchive(folder_ / "wrong.alab", z.GetPrims()), "");
  const auto blocks_of = [&](const std::string& name) {
    const Outcome outcome =
        run({"render", name + ".alab", "-o", name + ".exr", "--size", "48x32", "--spp", "64", "--studio", "on"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::vector<float> all = pixels(name + ".exr");
    std::vector<double> blocks(6 * 4, 0);
    for (size_t i = 0; i < 48 * 32 && all.size() >= 48 * 32 * 4; ++i)
      blocks[i / 48 / 8 * 6 + i % 48 / 8] += double(all[4 * i + 1]) / 64;
    return blocks;
  };
  const std::vector<double> as_y = blocks_of("y"), as_z = blocks_of("z"), wrong = blocks_of("wrong");
  double largest = 0;
  for (size_t i = 0; i < as_y.size(); ++i) {
    EXPECT_NEAR(as_z[i], as_y[i], 0.05 * as_y[i]) << i;
    largest = std::max(largest, std::abs(wrong[i] - as_y[i]) / as_y[i]);
  }
  EXPECT_GT(largest, 0.2) << "and the test sees which axis is up";
  const json info = json::parse(run({"info", "z.alab", "--json"}).out)["models"][0];
  EXPECT_EQ(info["upAxis"], "Z");
  EXPECT_EQ(info["metersPerUnit"], 0.01);
  EXPECT_EQ(info["range"], (json{1.0, 48.0}));
  EXPECT_HAS(run({"info", "z.alab"}).out, "up axis: Z");
}

// A patch at radius 1 below a node that turns by 180 degrees in the shutter.
TEST_F(SceneSources, AWheelInAnAnimationKeepsItsRadius) {
  json document = json::parse(hd::description::patch_gltf(true, false));
  document["nodes"][0]["translation"] = {1, 0, 0};
  document["nodes"][0]["scale"] = {0.1, 0.1, 0.1};
  document["nodes"].push_back({{"children", {0}}});
  document["scenes"][0]["nodes"] = {1, 2};
  document["cameras"][0] = {{"type", "orthographic"},
                            {"orthographic", {{"xmag", 1.3}, {"ymag", 1.3}, {"znear", 0.1}, {"zfar", 100}}}};
  const float half = std::sqrt(0.5f), times[3] = {0, 0.5f, 1};
  const float turns[12] = {0, 0, 0, 1, 0, 0, half, half, 0, 0, 1, 0};
  std::ofstream bin(folder_ / "turn.bin", std::ios::binary);
  bin.write(reinterpret_cast<const char*>(times), sizeof times);
  bin.write(reinterpret_cast<const char*>(turns), sizeof turns);
  bin.close();
  document["buffers"].push_back({{"uri", "turn.bin"}, {"byteLength", 60}});
  document["bufferViews"].push_back({{"buffer", 1}, {"byteLength", 12}});
  document["bufferViews"].push_back({{"buffer", 1}, {"byteOffset", 12}, {"byteLength", 48}});
  document["accessors"].push_back({{"bufferView", 2}, {"componentType", 5126}, {"count", 3}, {"type", "SCALAR"}});
  document["accessors"].push_back({{"bufferView", 3}, {"componentType", 5126}, {"count", 3}, {"type", "VEC4"}});
  document["animations"] = {{{"samplers", {{{"input", 2}, {"output", 3}}}},
                             {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}}}}};
  write("wheel.gltf", document.dump());
  // The mean distance from the axis of what the picture covers.
  const auto radius = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"render", "wheel.gltf", "-o", "w.exr", "--size", "64x64", "--spp", "256"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::vector<float> all = pixels("w.exr");
    double sum = 0, weights = 0;
    for (size_t i = 0; i < 64 * 64 && all.size() >= 64 * 64 * 4; ++i) {
      const double x = (double(i % 64) + 0.5) / 32 - 1, y = (double(i / 64) + 0.5) / 32 - 1;
      sum += double(all[4 * i + 3]) * 1.3 * std::hypot(x, y), weights += double(all[4 * i + 3]);
    }
    EXPECT_GT(weights, 5);
    return sum / weights;
  };
  EXPECT_NEAR(radius({"--shutter", "0:1", "--fps", "1"}), radius({"--time", "0"}), 4e-3);
}

}  // namespace
}  // namespace alabaster::cli
