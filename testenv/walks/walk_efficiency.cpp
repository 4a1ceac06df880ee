// Prints the gain of the walk's shortcuts as Markdown: variance times CPU seconds on real meshes, under uniform light
// and across the edge of a shadow; events and rays by albedo; the largest weight; the bias of sphere steps. This is not
// a test: it runs for minutes.
//   walk_efficiency [--walks N] [--weights N] [--bias N]
// Meshes: sss/*.glb in the folder that ALABASTER_TEST_ASSETS names.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "core/subsurface/random_walk.h"
#include "delegate/support/process_usage.h"
#include "testenv/support/analytic_bodies.h"
#include "testenv/support/lone_body.h"

namespace alabaster::testing {
namespace {

struct MediumCase {
  const char* name;
  Rgb albedo;
};
constexpr MediumCase kMedia[] = {{"skin (.9,.6,.45)", {.9f, .6f, .45f}},
                                 {"pale skin (.95,.75,.6)", {.95f, .75f, .6f}},
                                 {"white marble (.99,.97,.9)", {.99f, .97f, .9f}}};
const Rgb kDistanceRatio(1.0f, 0.35f, 0.2f);

struct Variant {
  const char* name;
  WalkSettings settings;
};

Variant variant(const char* name, bool guiding, bool sphere_steps) {
  Variant v{name, {}};
  v.settings.guiding = guiding;
  v.settings.sphere_steps = sphere_steps;
  return v;
}
const Variant kVariants[] = {variant("plain", false, false), variant("guided", true, false),
                             variant("sphere steps", false, true), variant("both (default)", true, true)};

/// Sums of one estimator's three channels.
struct Sums {
  double count = 0, first[3] = {}, second[3] = {};

  void add(const Rgb& value) {
    ++count;
    for (int c = 0; c < 3; ++c) {
      first[c] += value[c];
      second[c] += static_cast<double>(value[c]) * value[c];
    }
  }
  double mean(int c) const { return first[c] / count; }
  double variance(int c) const { return second[c] / count - mean(c) * mean(c); }
  double relative_variance() const {
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += variance(c) / (mean(c) * mean(c)) / 3;
    return sum;
  }
};

double largest_z(const Sums& a, const Sums& b) {
  double largest = 0;
  for (int c = 0; c < 3; ++c)
    largest = std::max(largest,
                       std::abs(a.mean(c) - b.mean(c)) / std::sqrt(a.variance(c) / a.count + b.variance(c) / b.count));
  return largest;
}

struct Measured {
  Sums uniform, edge;
  double seconds = 0;
  RenderCounters counters;
};

/// The first primitive of the first mesh of a .glb, with float positions and 16-bit indices. Null for anything else.
std::optional<Mesh> read_glb(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  uint32_t header[5] = {};
  if (!stream.read(reinterpret_cast<char*>(header), sizeof header)) return std::nullopt;
  std::string text(header[3], ' '), data(header[2] - 20 - header[3] - 8, ' ');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  stream.ignore(8);
  stream.read(data.data(), static_cast<std::streamsize>(data.size()));
  if (!stream) return std::nullopt;
  const auto json = nlohmann::json::parse(text);
  const auto& primitive = json["meshes"][0]["primitives"][0];
  const auto bytes = [&](const nlohmann::json& accessor) {
    return data.data() + accessor.value("byteOffset", 0) +
           json["bufferViews"][accessor["bufferView"].get<size_t>()].value("byteOffset", 0);
  };
  const auto& points = json["accessors"][primitive["attributes"]["POSITION"].get<size_t>()];
  const auto& indices = json["accessors"][primitive["indices"].get<size_t>()];
  if (indices["componentType"] != 5123) return std::nullopt;
  Mesh mesh;
  mesh.points.resize(points["count"].get<size_t>());
  std::memcpy(static_cast<void*>(mesh.points.data()), bytes(points), mesh.points.size() * sizeof(Vec3f));
  std::vector<uint16_t> corners(indices["count"].get<size_t>());
  std::memcpy(corners.data(), bytes(indices), corners.size() * sizeof(uint16_t));
  for (size_t i = 0; i + 2 < corners.size(); i += 3)
    mesh.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  for (const Vec3f& p : mesh.points) mesh.bounds.extend(p);
  return mesh;
}

/// A mesh with one scattering material, compiled as a scene, whose instance has the body for walks.
struct Body {
  SceneBuilder builder;
  std::shared_ptr<const MeshPrototype> prototype;
  std::shared_ptr<const SceneSnapshot> snapshot;
  double diagonal = 0;
  std::function<bool(const Vec3f&)> is_inner;  // of a mesh that overlaps itself: surface within the body; empty: none

  Body(const Mesh& mesh, const MediumCase& medium, double distance_share) : prototype(builder.prototype(mesh)) {
    diagonal = length(mesh.bounds.extent());
    DisneyParameters p;
    p.base_color = medium.albedo;
    p.scatter_distance = distances(distance_share);
    builder.add(prototype, builder.material(p));
    snapshot = builder.snapshot();
  }
  Rgb distances(double share) const { return kDistanceRatio * static_cast<float>(share * diagonal); }
};

/// Walks from random points of the surface. The shadow's edge is the plane through the body's centre at right angles to
/// x, with light only on the far side, and entries on the near side up to one red scatter distance away.
class MeshRun {
 public:
  MeshRun(const Body& body, const MediumCase& medium, double distance_share)
      : body_(body),
        instance_(body.snapshot->instances[0]),
        medium_(make_medium(medium.albedo, body.distances(distance_share), AlbedoInversion::exact)),
        edge_(body.prototype->mesh.bounds.center().x) {
    const Mesh& mesh = body.prototype->mesh;
    const float reach = body.distances(distance_share).r;
    const auto is_outer = [&](size_t triangle) { return !body.is_inner || !body.is_inner(centroid(mesh, triangle)); };
    const auto is_near_edge = [&](size_t triangle) {
      const float x = centroid(mesh, triangle).x;
      return is_outer(triangle) && x < edge_ && x > edge_ - reach;
    };
    entries_ = points_of(SurfaceSampler(mesh, is_outer), 1);
    edge_entries_ = points_of(SurfaceSampler(mesh, is_near_edge), 2);
  }

  void run(const WalkSettings& settings, int walks, uint64_t seed, Measured* out) const {
    Rng rng(seed, 3);
    const double start = hd::support::process_cpu_seconds();
    for (int i = 0; i < walks; ++i) {
      const auto exit = walk(entries_[static_cast<size_t>(i) % entries_.size()], settings, rng, out);
      out->uniform.add(exit ? exit->throughput : Rgb(0.0f));
    }
    for (int i = 0; i < walks; ++i) {
      const auto exit = walk(edge_entries_[static_cast<size_t>(i) % edge_entries_.size()], settings, rng, out);
      const bool lit = exit && exit_x(*exit) > edge_;
      out->edge.add(lit ? exit->throughput : Rgb(0.0f));
    }
    out->seconds += hd::support::process_cpu_seconds() - start;
  }

 private:
  static Vec3f centroid(const Mesh& mesh, size_t triangle) {
    const auto& t = mesh.triangles[triangle];
    return (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3;
  }

  std::vector<SubsurfaceEntry> points_of(const SurfaceSampler& sampler, uint64_t seed) const {
    constexpr int kPoints = 4096;
    const Mesh& mesh = body_.prototype->mesh;
    std::vector<SubsurfaceEntry> entries;
    Rng rng(seed, 4);
    for (int i = 0; i < kPoints; ++i) {
      const TriangleHit on = sampler.sample({rng.uniform(), rng.uniform(), rng.uniform()});
      SubsurfaceEntry entry;
      entry.triangle = on;
      entry.hit = surface_hit(mesh, on, instance_.object_to_world, instance_.world_to_object);
      entry.ns = entry.hit.ng;
      entry.medium = &medium_;
      entries.push_back(entry);
    }
    return entries;
  }

  std::optional<SubsurfaceExit> walk(const SubsurfaceEntry& entry, const WalkSettings& settings, Rng& rng,
                                     Measured* out) const {
    return carry(RandomWalk{settings}, *instance_.body, entry, rng, out->counters);
  }

  float exit_x(const SubsurfaceExit& exit) const {
    const Mesh& mesh = body_.prototype->mesh;
    return surface_hit(mesh, exit.hit, instance_.object_to_world, instance_.world_to_object).p_object.x;
  }

  const Body& body_;
  const Instance& instance_;
  WalkMedium medium_;
  float edge_;
  std::vector<SubsurfaceEntry> entries_, edge_entries_;
};

void print_mesh_table(const Mesh& mesh, const std::string& name, double distance_share, int walks,
                      const std::function<bool(const Vec3f&)>& is_inner = {}) {
  std::printf("\n### %s, red scatter distance %g %% of the diagonal\n\n", name.c_str(), 100 * distance_share);
  std::printf(
      "| medium | walk | gain, uniform | gain, edge | rel. variance, uniform | edge | us/walk | rays | events |");
  std::printf(" sphere steps | largest weight | largest z of the means, uniform / edge |\n");
  std::printf("|--|--|--|--|--|--|--|--|--|--|--|--|\n");
  for (const MediumCase& medium : kMedia) {
    Body body(mesh, medium, distance_share);
    body.is_inner = is_inner;
    const MeshRun run(body, medium, distance_share);
    Measured measured[std::size(kVariants)];
    // Interleaved, so that other work of the machine affects all alike.
    constexpr int kRounds = 20;
    for (int round = 0; round < kRounds; ++round)
      for (size_t v = 0; v < std::size(kVariants); ++v)
        run.run(kVariants[v].settings, walks / kRounds, uint64_t(round) * 16 + v, &measured[v]);
    for (size_t v = 0; v < std::size(kVariants); ++v) {
      const Measured &m = measured[v], &faithful = measured[0];
      const auto cost = [](const Measured& of, const Sums& sums) {
        return sums.relative_variance() * of.seconds / static_cast<double>(of.counters.walks);
      };
      const double n = static_cast<double>(m.counters.walks);
      std::printf("| %s | %s | %.2f | %.2f | %.3f | %.2f | %.2f | %.1f | %.1f | %.2f | %.2f | %.1f / %.1f |\n",
                  v == 0 ? medium.name : "", kVariants[v].name, cost(faithful, faithful.uniform) / cost(m, m.uniform),
                  cost(faithful, faithful.edge) / cost(m, m.edge), m.uniform.relative_variance(),
                  m.edge.relative_variance(), 1e6 * m.seconds / n, static_cast<double>(m.counters.walk_rays) / n,
                  static_cast<double>(m.counters.walk_events) / n,
                  static_cast<double>(m.counters.walk_sphere_steps) / n, m.counters.max_walk_weight,
                  v ? largest_z(m.uniform, faithful.uniform) : 0.0, v ? largest_z(m.edge, faithful.edge) : 0.0);
      std::fflush(stdout);
    }
  }
}

template <class MakeTracer>
RenderCounters walk_bodies(const MakeTracer& make_tracer, const Medium& medium, const WalkSettings& settings,
                           long walks, uint64_t seed, Sums* out) {
  RenderCounters counters;
  Rng rng(seed, 5);
  for (long i = 0; i < walks; ++i) {
    auto tracer = make_tracer();
    const auto end = walk_body_with_shortcuts(tracer, medium, settings, rng, counters);
    Rgb value(0.0f);
    for (size_t c = 0; end && c < 3; ++c) value[static_cast<int>(c)] = static_cast<float>(end->throughput[c]);
    if (out) out->add(value);
  }
  return counters;
}

void print_lengths(long walks) {
  std::printf(
      "\n## Walk length by albedo, grey half-space\n\n| A | events, plain | events + sphere steps, default | rays, "
      "plain | rays, default |\n|--|--|--|--|--|\n");
  WalkSettings plain;
  plain.guiding = plain.sphere_steps = false;
  const auto half_space = [] { return SlabTracer(); };
  for (const float albedo : {0.2f, 0.5f, 0.8f, 0.9f, 0.95f, 0.99f, 0.999f}) {
    const Medium medium = make_medium(Rgb(albedo), Rgb(1.0f), AlbedoInversion::exact);
    const RenderCounters before = walk_bodies(half_space, medium, plain, walks, 1, nullptr);
    const RenderCounters after = walk_bodies(half_space, medium, {}, walks, 2, nullptr);
    const auto mean = [](const RenderCounters& c, uint64_t count) {
      return static_cast<double>(count) / static_cast<double>(c.walks);
    };
    std::printf("| %g | %.2f | %.2f + %.2f | %.2f | %.2f |\n", albedo, mean(before, before.walk_events),
                mean(after, after.walk_events), mean(after, after.walk_sphere_steps), mean(before, before.walk_rays),
                mean(after, after.walk_rays));
    std::fflush(stdout);
  }
}

void print_weights(long walks) {
  std::printf("\n## Largest weight, default walk (bound: %g)\n\n| body | medium | walks | largest |\n|--|--|--|--|\n",
              WalkGuide::kLargestSum);
  for (const MediumCase& medium : kMedia) {
    const Medium m = make_medium(medium.albedo, kDistanceRatio, AlbedoInversion::exact);
    const auto row = [&](const char* body, const auto& make_tracer, uint64_t seed) {
      const RenderCounters counters = walk_bodies(make_tracer, m, {}, walks, seed, nullptr);
      std::printf("| %s | %s | %.3g | %.2f |\n", body, medium.name, static_cast<double>(walks),
                  counters.max_walk_weight);
      std::fflush(stdout);
    };
    row(
        "half-space", [] { return SlabTracer(); }, 11);
    row(
        "slab of 4 red mean free paths", [] { return SlabTracer(4.1); }, 12);
    row(
        "edge, 1 away", [] { return EdgeTracer(1); }, 13);
  }
}

void print_bias(long walks) {
  std::printf("\n## Bias of sphere steps (margin %g mean free paths), grey half-space, unguided\n\n", kSphereMargin);
  std::printf("| A | obtained - A | standard error | rays | sphere steps |\n|--|--|--|--|--|\n");
  WalkSettings settings;
  settings.guiding = false;
  for (const float albedo : {0.75f, 0.8f, 0.9f, 0.95f, 0.99f}) {
    Medium medium = make_medium(Rgb(albedo), {1, 0, 0}, AlbedoInversion::exact);
    Sums sums;
    const RenderCounters counters = walk_bodies([] { return SlabTracer(); }, medium, settings, walks, 21, &sums);
    std::printf("| %g | %+.6f | %.6f | %.2f | %.2f |\n", albedo, sums.mean(0) - albedo,
                std::sqrt(sums.variance(0) / sums.count), static_cast<double>(counters.walk_rays) / sums.count,
                static_cast<double>(counters.walk_sphere_steps) / sums.count);
    std::fflush(stdout);
  }
}

/// Two balls that overlap in one mesh: walks in a union, where they pass the surfaces within.
void print_union(int walks) {
  const Vec3f shift(0.7f, 0, 0);
  Mesh balls = sphere_mesh(1, 64, false);
  const auto first = static_cast<uint32_t>(balls.points.size());
  const size_t triangles = balls.triangles.size();
  for (uint32_t i = 0; i < first; ++i) balls.points.push_back(balls.points[i] + shift);
  for (size_t i = 0; i < triangles; ++i) {
    const auto t = balls.triangles[i];
    balls.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  for (const Vec3f& p : balls.points) balls.bounds.extend(p);
  const auto is_inner = [=](const Vec3f& p) { return std::min(length(p), length(p - shift)) < 0.99f; };
  for (const double share : {0.0025, 0.005, 0.01})
    print_mesh_table(balls, "two balls, a union", share, walks, is_inner);
}

void print_meshes(int walks) {
  const char* assets = std::getenv("ALABASTER_TEST_ASSETS");
  if (!assets) {
    std::printf("skipped the meshes: ALABASTER_TEST_ASSETS is not set\n");
    return;
  }
  std::printf(
      "## Variance x CPU seconds on meshes: gain over the faithful walk\n\nExact inversion throughout, so all "
      "means are equal; scatter distances in the ratio (1, .35, .2). %d walks each.\n",
      2 * walks);
  for (const char* name : {"bunny_marble", "dragon_wax"}) {
    const auto mesh = read_glb(std::string(assets) + "/sss/" + name + ".glb");
    if (!mesh) {
      std::printf("skipped %s.glb: it could not be read\n", name);
      continue;
    }
    for (const double share : {0.0025, 0.005, 0.01}) print_mesh_table(*mesh, name, share, walks);
  }
}

}  // namespace
}  // namespace alabaster::testing

int main(int argc, char** argv) {
  long walks = 100000, weights = 1000000, bias = 1000000;
  for (int i = 1; i < argc; i += 2) {
    const std::string flag = argv[i];
    long* const count = flag == "--walks"     ? &walks
                        : flag == "--weights" ? &weights
                        : flag == "--bias"    ? &bias
                                              : nullptr;
    if (count && i + 1 < argc) *count = std::strtol(argv[i + 1], nullptr, 10);
    if (!count || i + 1 == argc || *count < 0) {
      std::fprintf(stderr, "usage: walk_efficiency [--walks N] [--weights N] [--bias N]   (0 skips a part)\n");
      return 2;
    }
  }
  using namespace alabaster::testing;
  if (walks > 0) print_meshes(static_cast<int>(walks));
  if (walks > 0) print_union(static_cast<int>(walks));
  if (walks > 0) print_lengths(walks / 10);
  if (weights > 0) print_weights(weights);
  if (bias > 0) print_bias(bias);
  return 0;
}
