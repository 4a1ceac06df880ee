// Normalized diffusion by the probes that render, compared with its formula.
#include "testenv/support/diffusion_profile.h"
#include "core/subsurface/normalized_diffusion.h"
#include "testenv/support/lone_body.h"
#include "testenv/walks/tables/tables.h"
#include "testenv/walks/tables/walks.h"

namespace alabaster::testing {
namespace {

constexpr int kDecades = 5;  // of r/d: below 0.01, then up to 100

/// Half the box's width in d_red. The profile's tail beyond is 1e-9, and floats still resolve distances below 0.01 d.
constexpr float kHalf = 60;

/// The energy that leaves, per channel: total, and by decades of r/d.
struct ProfileTotals {
  RunningStatistics all[3], decade[3][kDecades];

  void merge(const ProfileTotals& o) {
    for (size_t c = 0; c < 3; ++c) {
      all[c].merge(o.all[c]);
      for (size_t i = 0; i < kDecades; ++i) decade[c][i].merge(o.decade[c][i]);
    }
  }
};

double decade_end(int decade) {
  return 1e-2 * std::pow(10.0, decade);
}

ProfileTotals probe(const BodyInWorld& body, const SubsurfaceEntry& entry, uint64_t probes, uint32_t seed) {
  const Vec3d start = to_double(body.position(entry.triangle));
  return run_chunks<ProfileTotals>(probes, seed, [&](Rng& rng, ProfileTotals& totals) {
    RenderCounters counters;
    const auto exit = carry(NormalizedDiffusion{}, body.body(), entry, rng, counters);
    const double r = exit ? length(to_double(body.position(exit->hit)) - start) : 0;
    for (int c = 0; c < 3; ++c) {
      const double weight = exit ? static_cast<double>(exit->throughput[c]) : 0;
      const double x = r / static_cast<double>(entry.medium->medium.scatter_distance[c]);
      totals.all[c].add(weight);
      for (int i = 0; i < kDecades; ++i)
        totals.decade[c][i].add(x < decade_end(i) && (i == 0 || x >= decade_end(i - 1)) ? weight : 0);
    }
  });
}

}  // namespace

void print_diffusion_profile(Report& report) {
  struct Case {
    const char* name;
    Rgb albedo;
    Rgb distance;
  };
  const Case cases[] = {{"A = .2, .5, .95", {0.2f, 0.5f, 0.95f}, {1.0f, 1.0f, 1.0f}},
                        {"skin", {0.9f, 0.6f, 0.45f}, {1.0f, 0.35f, 0.2f}}};
  constexpr const char* kChannels[] = {"red", "green", "blue"};
  report.heading("Normalized diffusion on a plane: probed / formula");
  report.paragraph(
      "R = A (e^(-r/d) + e^(-r/3d)) / (8 pi d r). Energy by decades of r/d, probed on a box 120 d wide, with z. All\n"
      "the energy that leaves must be A.");
  report.columns({"medium", "channel", "below .01", "z", "[.01,.1)", "z", "[.1,1)", "z", "[1,10)", "z", "[10,100)", "z",
                  "all", "A", "z"});
  uint32_t seed = 2500;
  const BodyInWorld box(box_mesh({kHalf, kHalf, kHalf}));
  for (const Case& k : cases) {
    const WalkMedium medium = make_medium(k.albedo, k.distance, AlbedoInversion::exact);
    const SubsurfaceEntry entry = box.entry({3, 2 * kHalf, 5}, {0, -1, 0}, medium);
    const ProfileTotals t = probe(box, entry, report.walks_for(0.25), ++seed);
    for (size_t c = 0; c < 3; ++c) {
      const int channel = static_cast<int>(c);
      const auto albedo = static_cast<double>(k.albedo[channel]);
      std::vector<std::string> cells = {k.name, kChannels[c]};
      double from = 0;
      for (int i = 0; i < kDecades; ++i) {
        const double to = diffusion_profile_cdf(decade_end(i), 1);
        const double expected = albedo * (to - from);
        cells.push_back(text("%.5f / %.5f", t.decade[c][i].mean(), expected));
        // The energy that an error of 4e-5 in radius shifts across a decade's end.
        cells.push_back(report.z(t.decade[c][i], expected, 1e-4));
        from = to;
      }
      cells.push_back(Estimate(t.all[c]).text());
      cells.push_back(text("%g", albedo));
      cells.push_back(report.z(t.all[c], albedo, 1e-5));
      report.row(cells);
    }
  }
}

}  // namespace alabaster::testing
