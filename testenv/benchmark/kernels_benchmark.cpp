// Kernels in isolation (Google Benchmark): tracing, one walk, one BSDF sample, random numbers, a look at a frame's
// error, a lookup in an image.
#include <benchmark/benchmark.h>

#include <tbb/task_arena.h>

#include <filesystem>
#include <fstream>

#include "core/convergence/group_stopping.h"
#include "core/material/disney_bsdf.h"
#include "core/sampling/warp.h"
#include "core/subsurface/random_walk.h"
#include "core/texture/texel_store.h"
#include "core/texture/texture.h"
#include "testenv/support/lone_body.h"

namespace alabaster {
namespace {

struct Sphere {
  testing::SceneBuilder builder;
  std::shared_ptr<const MeshPrototype> prototype = builder.prototype(testing::sphere_mesh(1, 256, false));
};
const Sphere& sphere() {
  static const Sphere s;
  return s;
}

void BM_Intersect(benchmark::State& state) {
  Rng rng(1, 2);
  TriangleHit hit;
  for (auto _ : state) {
    const Ray ray{Vec3f(0, 0, 0), sample_uniform_sphere({rng.uniform(), rng.uniform()})};
    benchmark::DoNotOptimize(sphere().prototype->object->intersect(ray, &hit));
  }
}
BENCHMARK(BM_Intersect);

void BM_SobolDraw(benchmark::State& state) {
  uint32_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(PixelSampler(7, i++).draw(Dimension::bsdf, 2));
}
BENCHMARK(BM_SobolDraw);

void BM_DisneySample(benchmark::State& state) {
  DisneyParameters p;
  p.sheen = 0.3f;
  p.clearcoat = 0.5f;
  Rng rng(1, 2);
  const Vec3f wo = normalize(Vec3f(0.3f, 0.2f, 0.8f));
  for (auto _ : state) {
    const DisneyBsdf bsdf(p, wo);
    benchmark::DoNotOptimize(bsdf.sample(rng.uniform(), {rng.uniform(), rng.uniform()}));
  }
}
BENCHMARK(BM_DisneySample);

// The argument is the albedo in per cent; the sphere is ten scatter distances wide.
void BM_Walk(benchmark::State& state) {
  const float albedo = static_cast<float>(state.range(0)) / 100;
  const WalkMedium medium = make_medium(Rgb(albedo), Rgb(0.2f), AlbedoInversion::exact);
  const SubsurfaceBody body = testing::lone_body(*sphere().prototype->object, sphere().prototype->mesh);
  const SubsurfaceEntry entry = testing::entry_at_point({0, 0.9999f, 0}, {0, 1, 0}, medium);
  RenderCounters counters;
  Rng rng(1, 2);
  for (auto _ : state) benchmark::DoNotOptimize(testing::carry(RandomWalk{}, body, entry, rng, counters));
  state.counters["segments/walk"] = static_cast<double>(counters.walk_rays) / static_cast<double>(counters.walks);
  state.counters["segments/s"] =
      benchmark::Counter(static_cast<double>(counters.walk_rays), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_Walk)->Arg(50)->Arg(80)->Arg(95)->Arg(99);

// Arguments: megapixels and threads. CPU time is the caller's, which with more threads has the serial share in it.
void BM_ErrorLook(benchmark::State& state) {
  const int width = 1024, height = 1024 * static_cast<int>(state.range(0));
  Film film({0, 0, width, height}, 0);
  Rng rng(1, 2);
  for (int t = 0; t < film.tile_count(); ++t) {
    FilmTile tile = film.load_tile(t);
    const auto pixels =
        static_cast<size_t>(film.tile_rect(t).width()) * static_cast<size_t>(film.tile_rect(t).height());
    for (size_t i = 0; i < pixels; ++i)
      for (int s = 0; s < 16; ++s) {
        FilmSample sample;
        sample.color = Rgb(rng.uniform());
        tile.add(i, sample);
      }
    film.store_tile(t, tile);
  }
  tbb::task_arena(static_cast<int>(state.range(1))).execute([&] {
    GroupStopping stopping;
    for (auto _ : state) {
      const NoiseImage noise = film_noise(film);
      benchmark::DoNotOptimize(estimate_frame_error(noise));
      stopping.update(film, noise, 1e-9);
    }
  });
}
BENCHMARK(BM_ErrorLook)->ArgsProduct({{1, 4}, {1, 2}})->Unit(benchmark::kMillisecond);

// A colour image of 2048 x 2048 bytes, 12 MiB, that comes second to a store of so many MiB.
std::shared_ptr<const Texture> second_image(int64_t mib) {
  const std::string file = (std::filesystem::temp_directory_path() / "alabaster_kernels.tga").string();
  std::string bytes("\0\0\2\0\0\0\0\0\0\0\0\0\0\10\0\10\30\40", 18);
  Rng rng(3, 4);
  for (int i = 0; i < 3 * 2048 * 2048; ++i) bytes += static_cast<char>(rng.uniform() * 255);
  std::ofstream(file, std::ios::binary) << bytes;
  const auto store = std::make_shared<TexelStore>();
  store->set_budget(static_cast<size_t>(mib) << 20);
  const auto colors = ColorConfig::load("built-in", {});
  const auto first = load_texture({file, nullptr, "auto"}, *colors, {}, {.store = store});
  return load_texture({file, nullptr, "auto"}, *colors, {}, {.store = store});
}

// Bilinear (width 0) or filtered lookups within a part of an image: its memory in MiB (64: texels are in memory; 30: a
// cache holds all tiles of a file; 1: it holds few), the part's share of each side in per cent, the footprint's width.
void BM_TextureLookup(benchmark::State& state) {
  const auto image = second_image(state.range(0));
  const float part = static_cast<float>(state.range(1)) / 100, width = static_cast<float>(state.range(2));
  if (width > 0) image->prepare_filtering();
  Rng rng(1, 2);
  for (auto _ : state) {
    const Vec2f uv(rng.uniform() * part, rng.uniform() * part);
    benchmark::DoNotOptimize(width > 0 ? image->filtered(uv, width) : image->rgb(uv));
  }
}
BENCHMARK(BM_TextureLookup)
    ->Args({64, 5, 0})
    ->Args({30, 5, 0})
    ->Args({1, 5, 0})
    ->Args({64, 5, 5})
    ->Args({64, 100, 0})
    ->Args({30, 100, 0})
    ->Args({1, 100, 0})
    ->Args({64, 100, 5});

}  // namespace
}  // namespace alabaster

BENCHMARK_MAIN();
