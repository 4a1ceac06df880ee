// Many samples and many walks: means keep converging.
#include "testenv/extremes/rows.h"
#include "testenv/support/path_tracer.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

// A square of radiance 1 fills a known share of each pixel of a box-filtered picture: independent samples would have
// the error sqrt(p (1 - p) / N).
void print_many_samples(Rows& rows, uint32_t most) {
  SceneBuilder b;
  // Square over the film's middle, turned so that no edge is parallel to a stratum.
  Matrix4d turned;
  turned.setAxisAngle(Vec3d(0, 1, 0), 0.3);
  b.add(b.prototype(plane_mesh(1)), b.material(glowing(1)), turned);
  for (uint32_t samples = 16; samples <= most; samples *= 16) {
    RenderRequest request = picture_of(&b, from_above(2), samples, 1);
    double squares = 0;
    constexpr int kPixels = 16;
    for (int i = 0; i < kPixels; ++i) {
      request.settings.seed = static_cast<uint32_t>(i);
      const double error = Picture(request).color[1] - 0.25;
      squares += error * error;
    }
    const double rms = std::sqrt(squares / kPixels), independent = std::sqrt(0.25 * 0.75 / samples);
    rows.require("square in a quarter of a pixel", text("%u samples", samples),
                 "rms error <= that of independent samples", text("%.2g, times 1.5: 16 seeds", independent),
                 text("%.2g, %.2f of it", rms, rms / independent), rms <= 1.5 * independent);
  }
}

// Light that is scattered below a surface has noise that no stratification takes away.
void print_long_convergence(Rows& rows, uint32_t most) {
  SceneBuilder b;
  b.add(b.prototype(sphere_mesh(1, 32, true)), b.material(medium_only(0.8f, 0.5f)));
  LightParameters key;
  key.type = LightType::sphere;
  key.intensity = 40;
  key.light_to_world = translation(3, 3, 1);
  b.add(key);
  PathTracer tracer(b.snapshot(), {0, 0, 4});
  RunningStatistics all;
  std::vector<RunningStatistics> quarters;
  uint32_t next = 0;
  for (uint32_t samples = most / 256; samples <= most; samples *= 16) {
    // The spread of the means of runs of this length, over that of single samples.
    const uint32_t runs = 16;
    RunningStatistics means;
    for (uint32_t r = 0; r < runs; ++r) {
      RunningStatistics run;
      for (uint32_t i = 0; i < samples / runs; ++i) {
        const double light = tracer.trace(next++).color.g;
        run.add(light), all.add(light);
      }
      means.add(run.mean());
    }
    const double ratio = std::sqrt(means.variance() * (samples / runs) / all.variance());
    rows.require("scattering ball, one pixel", text("runs of %u samples", samples / runs),
                 "spread of their means: 1 / sqrt(N), or less by stratification", "16 runs: a factor of 1.7",
                 text("%.2f of it", ratio), ratio < 1.7);
  }
  rows.require("scattering ball, one pixel", text("%u samples", next), "all are finite", "exact",
               text("%g not finite, %g rays dropped", double(tracer.counters.nonfinite_samples),
                    double(tracer.counters.rejected_rays)),
               tracer.counters.nonfinite_samples == 0 && tracer.counters.rejected_rays == 0);
}

void print_many_walks(Rows& rows, uint64_t walks) {
  for (const double albedo : {0.5, 0.9}) {
    const Medium medium = unit_medium(one_minus_alpha(albedo, AlbedoInversion::exact));
    const WalkTotals t = walk_bodies([] { return SlabTracer(); }, medium, plain_walk(), walks, 9000);
    rows.compare("half-space", text("A = %g, %g walks", albedo, double(walks)), "albedo", t.out[0], albedo, 3e-8,
                 "the inversion's error");
    rows.report().require(t.counters.walk_safety_cap == 0, "no walk of a grey half-space meets the cap");
  }
}

}  // namespace

void print_long_runs(Report& report) {
  const bool is_long = report.sigma() < 1e-3;
  Rows rows(report, "Long runs", "The short run takes 2^16 samples and 2e6 walks, the long one 2^20 and 1e9.");
  print_many_samples(rows, is_long ? 1u << 20 : 1u << 16);
  print_long_convergence(rows, is_long ? 1u << 20 : 1u << 16);
  print_many_walks(rows, is_long ? 1000000000 : 2000000);
}

}  // namespace alabaster::testing
