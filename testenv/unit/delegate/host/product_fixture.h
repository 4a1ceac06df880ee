// A folder, a small frame with every AOV, and the reports of operations on them.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <list>

#include "delegate/host/product_writer.h"

namespace alabaster::hd::host {

namespace fs = std::filesystem;
inline constexpr int kWidth = 7, kHeight = 5, kCount = kWidth * kHeight;

class ProductFile : public ::testing::Test {
 protected:
  ProductFile() { fs::create_directories(folder_); }
  ~ProductFile() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  RenderProduct product(const std::string& name) const {
    RenderProduct p;
    p.file = path(name);
    return p;
  }
  bool write(const RenderProduct& p, const ProductImage& image) {
    reports_.clear();
    return !WriteProducts({p}, image, colors_, sink_).empty();
  }
  bool check(const RenderProduct& p) {
    reports_.clear();
    return bool(CheckProduct(p, {0, 0, kWidth, kHeight}, colors_, sink_));
  }
  std::string text() const {
    std::string joined;
    for (const Diagnostic& d : reports_) joined += d.where + ": " + d.text + "\n";
    return joined;
  }
  /// All names in the folder, so that no temporary file goes unnoticed.
  std::vector<std::string> listing() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  fs::path folder_ = fs::temp_directory_path() / ("alabaster_product_" + std::to_string(::getpid()));
  OutputColors colors_{"built-in"};
  std::vector<Diagnostic> reports_;
  DiagnosticSink sink_ = [this](const Diagnostic& d) { reports_.push_back(d); };
};

/// Pixels in a buffer's order that live as long as the program. Pixel i of `value(i, component)` counts from the upper
/// left corner, row by row.
template <class T, class Value>
std::span<const T> pixels_of(int components, Vec2i size, const Value& value) {
  static std::list<std::vector<T>> kept;
  std::vector<T>& pixels = kept.emplace_back();
  for (int y = size.y - 1; y >= 0; --y)
    for (int x = 0; x < size.x; ++x)
      for (int c = 0; c < components; ++c) pixels.push_back(value(y * size.x + x, c));
  return pixels;
}
inline AovPixels floats(int components, const std::function<float(int, int)>& value, Vec2i size = {kWidth, kHeight}) {
  return {components, pixels_of<float>(components, size, value), {}};
}
inline AovPixels ints(const std::function<int32_t(int)>& value) {
  return {1, {}, pixels_of<int32_t>(1, {kWidth, kHeight}, [&](int i, int) { return value(i); })};
}
/// Where values of pixel i, counted so, begin in an AOV of frame().
inline size_t index_of(const ProductImage& image, const char* aov, int i) {
  const AovPixels& pixels = image.aovs.at(aov);
  return image.row_begin(pixels, i / kWidth) + size_t(i % kWidth * pixels.components);
}
inline float float_of(const ProductImage& image, const char* aov, int i, int component) {
  return image.aovs.at(aov).floats[index_of(image, aov, i) + size_t(component)];
}

inline ProductImage frame() {
  ProductImage image;
  image.framing.displayMin = {0, 0};
  image.framing.displayMax = {20, 10};
  image.framing.dataWindow = {3, -2, 3 + kWidth, -2 + kHeight};
  image.framing.pixelAspectRatio = 1;
  image.aovs["color"] = floats(4, [](int i, int c) { return c == 3 ? 1.0f : 0.013f * float(i) + 0.31f * float(c); });
  image.aovs["depth"] = floats(1, [](int i, int) { return 1000.1f + float(i) * 1e-3f; });
  image.aovs["cameraDepth"] = floats(1, [](int i, int) { return i == 0 ? 0.0f : 5000.1f + float(i) * 1e-3f; });
  image.aovs["normal"] = floats(3, [](int i, int c) { return c == 2 ? -1.0f : float(i) / 64; });
  image.aovs["albedo"] = floats(3, [](int i, int c) { return float(i * 3 + c) / 128; });
  image.aovs["alpha"] = floats(1, [](int, int) { return 1.0f; });
  image.aovs["primId"] = ints([](int i) { return i == 0 ? -1 : 20000001 + i; });
  image.aovs["instanceId"] = ints([](int i) { return i - 1; });
  image.aovs["elementId"] = ints([](int i) { return 4097 * i; });
  image.aovs["sampleCount"] = floats(1, [](int i, int) { return float(70000 + i); });
  return image;
}

inline std::vector<RenderVar> all_vars() {
  std::vector<RenderVar> vars;
  for (const char* name : {"color", "alpha", "depth", "cameraDepth", "normal", "albedo", "primId", "instanceId",
                           "elementId", "sampleCount"})
    vars.push_back({name, name, "half"});
  return vars;
}

}  // namespace alabaster::hd::host
