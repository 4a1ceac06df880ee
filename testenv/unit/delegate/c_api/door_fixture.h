// Shared by tests of the C door: a quad under a dome, and calls in short.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "delegate/c_api/alabaster.h"

namespace alabaster::door_testing {

inline const AlabasterApi& api() {
  return *alabaster_api(ALABASTER_API_VERSION);
}

inline AlabasterValue array(int32_t type, const void* data, size_t count) {
  return {type, 1, data, count, nullptr, nullptr};
}
inline AlabasterValue number(const float& value) {
  return {ALABASTER_FLOAT, 0, &value, 1, nullptr, nullptr};
}
inline AlabasterValue whole(const int32_t& value) {
  return {ALABASTER_INT, 0, &value, 1, nullptr, nullptr};
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
    const AlabasterLight dome = {sizeof dome, "domeLight", nullptr, nullptr, 0, 0};
    EXPECT_EQ(api().set_light(scene_, "/dome", &dome), ALABASTER_OK);
    const float focal = 0.05f, aperture = 0.036f;
    const AlabasterParameter lens[] = {{"focalLength", number(focal)},
                                       {"horizontalAperture", number(aperture)},
                                       {"verticalAperture", number(aperture)}};
    const double away[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 6, 1};
    const AlabasterCamera camera = {sizeof camera, away, lens, 3, {}};
    EXPECT_EQ(api().set_camera(scene_, "/camera", &camera), ALABASTER_OK);
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

  AlabasterStatus set_quad(AlabasterValue points, const char* instancer = nullptr) {
    static constexpr int32_t kCounts[] = {4}, kIndices[] = {0, 1, 2, 3};
    static constexpr float kCorners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    if (points.type == ALABASTER_NONE) points = array(ALABASTER_FLOAT3, kCorners, 4);
    const AlabasterPrimvar primvar = {"points", nullptr, ALABASTER_VERTEX, points, {}, {}};
    AlabasterMesh mesh = {};
    mesh.size = sizeof mesh;
    mesh.face_vertex_counts = array(ALABASTER_INT, kCounts, 1);
    mesh.face_vertex_indices = array(ALABASTER_INT, kIndices, 4);
    mesh.primvars = &primvar, mesh.primvar_count = 1;
    mesh.material = "/wax", mesh.instancer = instancer;
    return api().set_mesh(scene_, "/quad", &mesh);
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

}  // namespace alabaster::door_testing
