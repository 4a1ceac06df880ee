// The energy models in a furnace: the light that each reflects, and how far it is from the published model.
#include <array>

#include "core/material/disney_bsdf.h"
#include "core/subsurface/medium.h"
#include "testenv/support/chi_square.h"
#include "testenv/walks/tables/tables.h"

namespace alabaster::testing {
namespace {

constexpr std::array kModels = {EnergyModel::burley2015, EnergyModel::bounded, EnergyModel::conserving};

struct Case {
  const char* name;
  DisneyParameters parameters;
};

DisneyParameters surface(float base_color, float roughness, float ior = 1.5f, float metallic = 0) {
  DisneyParameters p;
  p.base_color = Rgb(base_color);
  p.roughness = roughness;
  p.ior = ior;
  p.metallic = metallic;
  return p;
}

std::vector<Case> cases() {
  std::vector<Case> all = {{"white, roughness .5", surface(1, 0.5f)},
                           {"white, roughness 1", surface(1, 1)},
                           {"baseColor .8, roughness .5", surface(0.8f, 0.5f)},
                           {"baseColor .8, roughness .1", surface(0.8f, 0.1f)},
                           {"baseColor .8, ior 2.5", surface(0.8f, 0.5f, 2.5f)},
                           {"baseColor .8, ior 4", surface(0.8f, 0.5f, 4)},
                           {"baseColor .2, roughness .5", surface(0.2f, 0.5f)},
                           {"baseColor .8, sheen 1", surface(0.8f, 0.5f)},
                           {"baseColor .8, clearcoat 1", surface(0.8f, 0.5f)},
                           {"white metal, roughness .3", surface(1, 0.3f, 1.5f, 1)},
                           {"white metal, roughness 1", surface(1, 1, 1.5f, 1)}};
  all[7].parameters.sheen = 1;
  all[8].parameters.clearcoat = 1;
  return all;
}

Vec3f at(double cosine) {
  return {static_cast<float>(std::sqrt(1 - cosine * cosine)), 0, static_cast<float>(cosine)};
}

double reflected_of(const DisneyBsdf& bsdf, Rng& rng) {
  const auto sample = bsdf.sample(rng.uniform(), uniform2(rng));
  return sample ? static_cast<double>(sample->weight().g) : 0;
}

Estimate furnace(const Case& c, EnergyModel model, double cosine, const Report& report) {
  const DisneyBsdf bsdf(c.parameters, at(cosine), model);
  Rng rng(4711, 1);
  RunningStatistics statistics;
  const uint64_t samples = report.walks_for(0.1);
  for (uint64_t i = 0; i < samples; ++i) statistics.add(reflected_of(bsdf, rng));
  return statistics;
}

// The share of light from everywhere that the surface sends on: 1 or more, and light in a closed box never ends.
Estimate mean_furnace(const Case& c, EnergyModel model, const Report& report) {
  Rng rng(4711, 2);
  RunningStatistics statistics;
  const uint64_t samples = report.walks_for(0.1);
  for (uint64_t i = 0; i < samples; ++i) {
    const double cosine = std::sqrt(1 - static_cast<double>(rng.uniform()));
    statistics.add(reflected_of(DisneyBsdf(c.parameters, at(cosine), model), rng));
  }
  return statistics;
}

// Seen along the normal: the light of the local lobes, and that of the walk, which enters with Burley's factor of the
// viewer, brings out the albedo, and leaves with the factor of the light, whose mean is 1 - 1/42.
Estimate half_space(float albedo, float roughness, const Report& report) {
  DisneyParameters p = surface(albedo, roughness);
  p.specular = 0;
  p.scatter_distance = Rgb(1.0f);
  const DisneyBsdf bsdf(p, {0, 0, 1}, EnergyModel::bounded);
  const double walked = static_cast<double>(bsdf.subsurface_entry().g) *
                        static_cast<double>(obtained_albedo(albedo, AlbedoInversion::exact)) * (41.0 / 42);
  Rng rng(4711, 3);
  RunningStatistics statistics;
  const uint64_t samples = report.walks_for(0.1);
  for (uint64_t i = 0; i < samples; ++i) {
    const auto sample = bsdf.sample(rng.uniform(), uniform2(rng));
    const bool is_local = sample && sample->lobe != Lobe::subsurface;
    statistics.add(walked + (is_local ? static_cast<double>(sample->weight().g) : 0));
  }
  return statistics;
}

void print_half_space(Report& report) {
  report.heading("A half-space that scatters, in a white furnace, specular 0, seen along the normal");
  report.paragraph(
      "A walk brings out the albedo asked for, baseColor. The material shows another: Burley's diffuse factors weigh\n"
      "the light where it enters and where it leaves, and his retro-reflection, which grows with roughness, is added.");
  report.columns({"baseColor", "roughness 0", "roughness .5", "roughness 1"});
  for (const float albedo : {0.2f, 0.5f, 0.8f, 1.0f}) {
    std::vector<std::string> row = {text("%g", static_cast<double>(albedo))};
    for (const float roughness : {0.0f, 0.5f, 1.0f}) {
      const Estimate share = half_space(albedo, roughness, report);
      row.push_back(text("%.4f", share.mean));
      report.require(share.mean - 4 * share.sigma <= 1 + 1e-3, "a half-space reflects more than it receives");
    }
    report.row(row);
  }
}

}  // namespace

void print_energy(Report& report) {
  report.heading("Energy of the Disney BSDF in a white furnace, without subsurface");
  report.paragraph(
      "The share of light that is reflected, seen at an angle from the normal and from everywhere. `burley2015` is\n"
      "the published model; the difference of the others to it is how far they depart from it.");
  report.columns({"surface", "seen at", "burley2015", "bounded", "conserving"});
  for (const Case& c : cases())
    for (const double degrees : {0.0, 60.0, 85.0, -1.0}) {
      std::vector<std::string> row = {c.name, degrees < 0 ? "all angles" : text("%g°", degrees)};
      for (const EnergyModel model : kModels) {
        const double cosine = std::cos(degrees * std::acos(-1.0) / 180);
        const Estimate share = degrees < 0 ? mean_furnace(c, model, report) : furnace(c, model, cosine, report);
        row.push_back(text("%.3f", share.mean));
        if (model != EnergyModel::burley2015)
          report.require(share.mean - 4 * share.sigma <= 1 + 1e-3,
                         std::string(c.name) + " reflects more than it receives");
      }
      report.row(row);
    }
  print_half_space(report);
}

}  // namespace alabaster::testing
