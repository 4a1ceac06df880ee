// The rows of the suite: each is a scene made in code, an extreme of it, the answer or the invariant, the tolerance
// with its reason, and what the renderer gave.
#pragma once

#include <cmath>
#include <string>

#include "testenv/support/medium_bodies.h"
#include "testenv/support/table_report.h"

namespace alabaster::testing {

class Rows {
 public:
  /// Prints the heading of a class of extremes.
  Rows(Report& report, const std::string& title, const std::string& words) : report_(report) {
    report.heading(title);
    report.paragraph(words);
    report.columns({"scene", "extreme", "answer or invariant", "tolerance", "given", "verdict"});
  }

  /// A measured mean against the answer. `slack` bounds the error of the answer, for the reason `why`; empty: none.
  void compare(const std::string& scene, const std::string& extreme, const std::string& answer,
               const Estimate& measured, double expected, double slack = 0, const std::string& why = "") {
    const std::string z = report_.z(measured, expected, slack);
    const std::string tolerance = slack > 0 ? text("noise and %g: ", slack) + why : "noise";
    report_.row({scene, extreme, answer + text(" = %.6g", expected), tolerance,
                 text("%.6g ± %.1g", measured.mean, measured.sigma), "z = " + z});
  }
  /// The same of something that may be below the answer.
  void compare_most(const std::string& scene, const std::string& extreme, const std::string& answer,
                    const Estimate& measured, double most) {
    const std::string z = report_.z(measured, 0, most);
    report_.row({scene, extreme, answer + text(" <= %.6g", most), "noise",
                 text("%.6g ± %.1g", measured.mean, measured.sigma), "z = " + z});
  }
  /// A fact that holds or does not, within the tolerance and for the reason `why`.
  void require(const std::string& scene, const std::string& extreme, const std::string& invariant,
               const std::string& why, const std::string& given, bool holds) {
    report_.row({scene, extreme, invariant, why, given, holds ? "holds" : "**FAILED**"});
    report_.require(holds, scene + ", " + extreme + ": " + invariant);
  }
  Report& report() { return report_; }

 private:
  Report& report_;
};

// ---- pictures

/// Small and square: `samples` a pixel.
inline RenderRequest picture_of(SceneBuilder* b, const CameraParameters& camera, uint32_t samples, int size = 16) {
  return request_of(b, camera, samples, size);
}

/// Straight down onto the plane y = 0 from a height of 5, all rays parallel, `size` wide.
inline CameraParameters from_above(float size, double height = 5) {
  CameraParameters camera = look_at({0, height, 0}, {0, 0, 0}, 30);
  camera.orthographic = true;
  camera.horizontal_aperture = camera.vertical_aperture = size;
  return camera;
}

inline Matrix4d translation(double x, double y, double z) {
  return Matrix4d().setTranslation(Vec3d(x, y, z));
}

inline Matrix4d scaling(double x, double y, double z) {
  return Matrix4d().setScale(Vec3d(x, y, z));
}

/// A black surface that shines.
inline DisneyParameters glowing(float radiance) {
  DisneyParameters p = medium_only(0, 0);
  p.emission = Rgb(radiance);
  return p;
}

/// A picture as rows judge it.
struct Picture {
  std::vector<float> color;  // RGBA
  Estimate mean{0, 0};       // of green
  RenderCounters counters;
  bool finite = false;  // and nowhere negative, and no sample had to be dropped
  bool sound = false;   // and no ray, for being not finite or beginning beyond 1e17

  explicit Picture(const RenderRequest& request) {
    RenderSession session;
    session.start(request);
    EXPECT_TRUE(session.wait(600));
    const RenderProgress progress = session.progress();
    // A frame of which no ray can be traced is an error, and has a picture.
    const bool traced = progress.counters.rejected_rays < progress.counters.camera_rays;
    EXPECT_EQ(progress.state, traced ? SessionState::finished : SessionState::failed) << progress.error;
    const auto film = session.film();
    color = film->resolve_float(Aov::color);
    const MeanError m = film_mean(*film, 1);
    mean = {m.mean, m.standard_error};
    counters = progress.counters;
    finite = counters.nonfinite_samples == 0;
    for (const float v : color) finite = finite && std::isfinite(v) && v >= 0;
    sound = finite && counters.rejected_rays == 0;
  }
  std::string said() const {
    return text("mean %.6g, not finite %g, rays dropped %g", mean.mean, double(counters.nonfinite_samples),
                double(counters.rejected_rays));
  }
};

inline size_t different_values(const Picture& a, const Picture& b) {
  size_t count = a.color.size() == b.color.size() ? 0 : 1;
  for (size_t i = 0; i < std::min(a.color.size(), b.color.size()); ++i) count += a.color[i] != b.color[i];
  return count;
}

/// The difference of the means of two pictures whose noise is independent.
inline Estimate difference(const Picture& a, const Picture& b) {
  return {a.mean.mean - b.mean.mean, std::hypot(a.mean.sigma, b.mean.sigma)};
}

void print_parameters(Report& report);
void print_subsurface(Report& report);
void print_geometry(Report& report);
void print_lights(Report& report);
void print_cameras(Report& report);
void print_long_runs(Report& report);
void print_precision(Report& report);

}  // namespace alabaster::testing
