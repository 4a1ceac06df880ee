// Shared by tests of the C interface: a quad under a dome, and calls in short.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "delegate/c_api/alabaster.h"

namespace alabaster::c_api_testing {

inline const AlabasterApi& api() {
  return *alabaster_api(ALABASTER_API_VERSION);
}

// Values point at their arguments: temporaries last for the call that they are written in.
inline AlabasterValue array(int32_t type, const void* data, size_t count) {
  return {type, ALABASTER_ARRAY, data, count, nullptr, nullptr};
}
inline AlabasterValue scalar(int32_t type, const void* data) {
  return {type, ALABASTER_SCALAR, data, 1, nullptr, nullptr};
}
inline AlabasterValue number(const float& value) {
  return scalar(ALABASTER_FLOAT, &value);
}
inline AlabasterValue whole(const int32_t& value) {
  return scalar(ALABASTER_INT, &value);
}
inline AlabasterValue flag(const uint8_t& value) {
  return scalar(ALABASTER_BOOL, &value);
}
inline AlabasterValue word(const char* text) {
  return scalar(ALABASTER_TOKEN, text);
}
inline AlabasterValue path(const char* text) {
  return scalar(ALABASTER_PATH, text);
}
inline AlabasterValue matrix(const double* rows) {
  return scalar(ALABASTER_MATRIX, rows);
}
inline AlabasterValue matrix(const std::array<double, 16>& rows) {
  return matrix(rows.data());
}
template <size_t kCount>
AlabasterValue samples(const AlabasterSample (&all)[kCount]) {
  return {ALABASTER_SAMPLES, ALABASTER_SCALAR, all, kCount, nullptr, nullptr};
}

/// A translation.
inline std::array<double, 16> at(double x, double z = 0) {
  return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 0, z, 1};
}

using Fields = std::vector<AlabasterParameter>;
inline AlabasterStatus set(AlabasterScene* scene, const char* path, const char* kind, const Fields& fields = {}) {
  return api().scene_set(scene, path, kind, fields.data(), fields.size());
}
inline AlabasterStatus edit(AlabasterScene* scene, const char* path, const Fields& fields) {
  return api().scene_edit(scene, path, fields.data(), fields.size());
}
/// Last_error has the text.
inline bool says(const char* text) {
  return std::string(api().last_error()).find(text) != std::string::npos;
}

inline void count_release(void* owner) {
  ++*static_cast<int*>(owner);
}

/// A quad under a dome, seen from the front, and a delegate that draws it.
class Door : public ::testing::Test {
 protected:
  static constexpr int kSide = 16;

  Door() {
    const AlabasterDelegateOptions options = {sizeof options, &Door::hear, this, nullptr, 0};
    EXPECT_EQ(api().scene_create(&Door::hear, this, &scene_), ALABASTER_OK);
    set_quad({});
    EXPECT_EQ(set(scene_, "/dome", "domeLight"), ALABASTER_OK) << api().last_error();
    EXPECT_EQ(set(scene_, "/camera", "camera", camera(at(0, 6))), ALABASTER_OK) << api().last_error();
    EXPECT_EQ(api().delegate_create(&options, scene_, &delegate_), ALABASTER_OK) << api().last_error();
    set_samples(4);
    EXPECT_EQ(api().buffer_create(delegate_, kSide, kSide, ALABASTER_FLOAT32_4, &color_), ALABASTER_OK);
    EXPECT_EQ(api().pass_create(delegate_, &pass_), ALABASTER_OK);
  }
  ~Door() override {
    api().pass_destroy(pass_);
    api().buffer_destroy(color_);
    api().delegate_destroy(delegate_);
    api().scene_destroy(scene_);
  }

  static void hear(void* user, const AlabasterDiagnostic* diagnostic) {
    static_cast<Door*>(user)->heard_.push_back(diagnostic->code);
  }

  /// A camera that sees the quad, if it stands in front of it.
  static Fields camera(const std::array<double, 16>& place) {
    static constexpr float kFocal = 0.05f, kAperture = 0.036f;
    return {{"transform", matrix(place)},
            {"focalLength", number(kFocal)},
            {"horizontalAperture", number(kAperture)},
            {"verticalAperture", number(kAperture)}};
  }

  AlabasterStatus set_quad(AlabasterValue points, const char* instancer = "") {
    static constexpr int32_t kCounts[] = {4}, kIndices[] = {0, 1, 2, 3};
    static constexpr float kCorners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    if (points.type == ALABASTER_NONE) points = array(ALABASTER_FLOAT3, kCorners, 4);
    return set(scene_, "/quad", "mesh",
               {{"faceVertexCounts", array(ALABASTER_INT, kCounts, 1)},
                {"faceVertexIndices", array(ALABASTER_INT, kIndices, 4)},
                {"primvars:points", points},
                {"material", path("/wax")},
                {"instancer", path(instancer)}});
  }

  AlabasterStatus set_settings() {
    return set(scene_, "/settings", "renderSettings",
               {{"camera", path("/camera")}, {"width", whole(kSide)}, {"height", whole(kSide)}});
  }

  void set_samples(int32_t samples) {
    const AlabasterValue value = whole(samples);
    EXPECT_EQ(api().set_setting(delegate_, "samples", &value), ALABASTER_OK);
  }

  AlabasterStatus start() {
    const AlabasterBinding binding = {"color", color_};
    AlabasterFrame frame = frame_;
    frame.size = sizeof frame;
    frame.bindings = &binding, frame.binding_count = 1;
    frame.camera = "/camera";
    frame.width = frame.height = kSide;
    return api().pass_start(pass_, &frame);
  }

  std::vector<float> render() {
    std::vector<float> pixels(4 * kSide * kSide);
    EXPECT_EQ(start(), ALABASTER_OK) << api().last_error();
    int32_t over = 0;
    EXPECT_EQ(api().pass_wait(pass_, -1, &over), ALABASTER_OK) << api().last_error();
    EXPECT_EQ(over, 1);
    int32_t state = 0;
    EXPECT_EQ(api().pass_state(pass_, &state), ALABASTER_OK);
    EXPECT_EQ(state, ALABASTER_CONVERGED);
    EXPECT_EQ(api().buffer_read(color_, pixels.data(), pixels.size() * sizeof(float), 0), ALABASTER_OK);
    return pixels;
  }
  static std::array<float, 4> centre(const std::vector<float>& pixels) {
    std::array<float, 4> rgba;
    std::copy_n(&pixels[4 * (kSide / 2 * kSide + kSide / 2)], 4, rgba.begin());
    return rgba;
  }

  AlabasterScene* scene_ = nullptr;
  AlabasterDelegate* delegate_ = nullptr;
  AlabasterBuffer* color_ = nullptr;
  AlabasterPass* pass_ = nullptr;
  AlabasterFrame frame_ = {};
  std::vector<std::string> heard_;
};

}  // namespace alabaster::c_api_testing
