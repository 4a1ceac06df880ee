// A folder of small scene files, and the reports of loading one of them.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "delegate/description/render_description.h"

namespace alabaster::hd::description {

/// A 2 x 2 x 0 patch of two triangles: node "patch", material "skin", camera "front" on request.
inline std::string patch_gltf(bool with_camera, bool with_light) {
  std::string nodes = R"({"name": "patch", "mesh": 0})";
  std::string roots = "0";
  std::string extra;
  if (with_camera) {
    nodes += R"(, {"name": "front", "camera": 0, "translation": [0, 0, 5]})";
    roots += ",1";
    extra += R"(, "cameras": [{"name": "front", "type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}])";
  }
  if (with_light) {
    nodes += R"(, {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}})";
    roots += with_camera ? ",2" : ",1";
    extra += R"(, "extensionsUsed": ["KHR_lights_punctual"],
               "extensions": {"KHR_lights_punctual": {"lights": [{"name": "lamp", "type": "point"}]}})";
  }
  // Four positions (-1,-1,0) (1,-1,0) (1,1,0) (-1,1,0) and indices 0 1 2 0 2 3 (uint16).
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [)" + roots + R"(]}], "nodes": [)" + nodes +
         R"(], "materials": [{"name": "skin"}],
    "meshes": [{"name": "patch", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                   "min": [-1, -1, 0], "max": [1, 1, 0]},
                  {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
    "buffers": [{"byteLength": 60, "uri": "patch.bin"}])" +
         extra + "}";
}

inline LoadOptions with_overrides(std::vector<Override> overrides) {
  LoadOptions options;
  options.overrides = std::move(overrides);
  return options;
}
inline LoadOptions with_camera(const std::string& camera) {
  LoadOptions options;
  options.camera = camera;
  return options;
}
inline LoadOptions with_dome(const std::string& dome) {
  LoadOptions options;
  options.dome = dome;
  return options;
}

class SceneFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              ("alabaster_" + std::string(info->name()) + "_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    const float points[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    std::ofstream bin(folder_ / "patch.bin", std::ios::binary);
    bin.write(reinterpret_cast<const char*>(points), sizeof points);
    bin.write(reinterpret_cast<const char*>(indices), sizeof indices);
    bin.close();
    write("patch.gltf", patch_gltf(false, false));
    write("lit.gltf", patch_gltf(true, true));
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  /// One grey pixel as a Radiance file. Images are recognized by their content, whatever their name.
  std::string write_image(const std::string& name) const {
    return write(name, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x81");
  }

  SceneFile load(const std::string& name, const LoadOptions& options = {}) {
    diagnostics.clear();
    return LoadScene(folder_ / name, &scene, sink(), options);
  }
  DiagnosticSink sink() {
    return [this](const Diagnostic& d) { diagnostics.push_back(d); };
  }
  SceneFile describe(const std::string& text, const LoadOptions& options = {}) {
    write("scene.json", text);
    return load("scene.json", options);
  }

  /// "where: text" of every error.
  std::string errors() const {
    std::string all;
    for (const Diagnostic& d : diagnostics)
      if (d.severity == Severity::error) all += d.where + ": " + d.text + "\n";
    return all;
  }

  std::filesystem::path folder_;
  host::RetainedSceneDelegate scene;
  std::vector<Diagnostic> diagnostics;
};

}  // namespace alabaster::hd::description
