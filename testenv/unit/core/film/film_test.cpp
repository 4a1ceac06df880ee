#include "core/film/film.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <random>
#include <thread>

namespace alabaster {
namespace {

FilmSample sample(float value, float distance, int32_t id) {
  FilmSample s;
  s.color = Rgb(value);
  s.alpha = 1;
  s.distance = distance;
  s.camera_depth = distance;
  s.prim_id = id;
  return s;
}

// promise: pipeline.aov.color, pipeline.aov.sample_count
TEST(Film, AveragesColorAndKeepsTheClosestId) {
  Film film({0, 0, 2, 1}, ~AovSet{0});
  FilmTile tile = film.load_tile(0);
  tile.add(1, sample(1, 5, 7));
  tile.add(1, sample(3, 2, 9));
  tile.add(1, sample(5, 4, 8));
  film.store_tile(0, tile);
  EXPECT_EQ(film.resolve_float(Aov::color), (std::vector<float>{0, 0, 0, 0, 3, 3, 3, 1}));
  EXPECT_EQ(film.resolve_int(Aov::prim_id), (std::vector<int32_t>{-1, 9}));
  EXPECT_EQ(film.resolve_int(Aov::sample_count), (std::vector<int32_t>{0, 3}));
  EXPECT_EQ(film.resolve_float(Aov::camera_depth)[1], 2.0f);
  EXPECT_EQ(film.resolve_float(Aov::depth)[0], 1.0f);
}

// A film's tiles hold: 4 bytes of count, a sum of color (80 bytes) and of alpha (8), 6 floats of noise, 3 sums of
// normal (8 each), 3 of albedo and one of ambientOcclusion, 2 sums of shadow and a count, a sum of each of the 14
// layers, the distance to the closest sample, a word for each of its 7 values and 3 floats of each of its vectors (5
// and 8 primvars), a count of samples that were not finite; and the film 3 floats that are denoised. A part holds up to
// four more sums of color.
TEST(Film, BytesAreKnownBeforehand) {
  constexpr size_t kSum = 80, kLeast = 4 + kSum + 8 + 24;
  EXPECT_EQ(film_bytes({0, 0, 10, 7}, 0), 70u * kLeast);
  EXPECT_EQ(film_bytes({-5, 3, 5, 10}, aov_bit(Aov::depth) | aov_bit(Aov::prim_id)), 70u * (kLeast + 12));
  EXPECT_EQ(film_bytes({0, 0, 1 << 20, 1 << 20}, ~AovSet{0}),
            (size_t(1) << 40) * (kLeast + 24 + 24 + 8 + 4 + 2 * kSum + 4 + 28 + 14 * kSum + 13 * 12 + 4 + 12 + 2 * 12));
  EXPECT_EQ(film_bytes({0, 0, 10, 7}, aov_bit(Aov::specular) | aov_bit(Aov::emission)), 70u * (kLeast + 2 * kSum));
  EXPECT_EQ(film_bytes({4, 4, 0, 9}, ~AovSet{0}), 0u);
  EXPECT_EQ(film_bytes({0, 0, 10, 7}, 0, {false, {256, 511}}), 70u * kLeast);
  EXPECT_EQ(film_bytes({0, 0, 10, 7}, 0, {false, {256, 512}}), 70u * (kLeast + kSum));
  EXPECT_EQ(film_bytes({0, 0, 10, 7}, 0, {false, {1, 1 << 20}}), 70u * (kLeast + 4 * kSum));
}

// By the rule as film.h has it: the corner of the smallest block that has a sample.
// promise: embedding.first_sample
TEST(Film, PixelsWithoutASampleShowTheCornerOfTheirBlock) {
  const PixelRect window{3, -2, 48, 39};  // one whole tile, and parts of three
  std::mt19937 random(5);
  for (const uint32_t rarity : {2u, 9u, 70u, 5000u}) {
    Film film(window, ~AovSet{0});
    std::vector<float> values(static_cast<size_t>(window.width() * window.height()), 0.0f);
    std::vector<int32_t> ids(values.size(), -1);
    for (int t = 0; t < film.tile_count(); ++t) {
      const PixelRect r = film.tile_rect(t);
      const auto width = static_cast<size_t>(r.width()), height = static_cast<size_t>(r.height());
      FilmTile tile = film.load_tile(t);
      for (size_t pixel = 0; pixel < width * height; ++pixel)
        if (random() % rarity == 0)
          tile.add(pixel, sample(static_cast<float>(pixel) + 1, 1, static_cast<int32_t>(pixel)));
      film.store_tile(t, tile);
      for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x)
          for (size_t block = 1; block <= Film::kTileSize; block *= 2) {
            const size_t corner = y / block * block * width + x / block * block;
            if (tile.samples(corner) == 0) continue;
            const size_t at = (static_cast<size_t>(r.y0 + 2) + y) * static_cast<size_t>(window.width()) +
                              static_cast<size_t>(r.x0 - 3) + x;
            values[at] = static_cast<float>(corner) + 1, ids[at] = static_cast<int32_t>(corner);
            break;
          }
    }
    EXPECT_EQ(film.resolve_int(Aov::prim_id), ids);
    const std::vector<float> color = film.resolve_float(Aov::color);
    for (size_t i = 0; i < values.size(); ++i) ASSERT_EQ(color[4 * i], values[i]) << i << ", one in " << rarity;
  }
}

// Readers take a lower revision for an older picture.
TEST(Film, ItsRevisionNeverFalls) {
  Film film({0, 0, 64, 32}, 0);
  std::atomic<int> writing{2};
  const auto write = [&](int tile) {
    for (int i = 0; i < 300000; ++i) film.mark_changed(tile);
    --writing;
  };
  std::thread first(write, 0), second(write, 1);
  FilmRevision latest = 0;
  int falls = 0;
  while (writing > 0) {
    const FilmRevision now = film.revision();
    falls += now < latest;
    latest = now;
  }
  first.join(), second.join();
  EXPECT_EQ(falls, 0);
  for (const int tile : {0, 1}) EXPECT_LT(film.revision(tile, Aov::color), film.revision()) << "tiles come first";
}

TEST(Film, KeepsTheVectorsOfTheClosestSample) {
  const AovSet aovs = aov_bit(Aov::motion) | aov_bit(Aov::eye_point) | aov_bit(primvar_aov(7));
  Film film({0, 0, 2, 1}, aovs);
  FilmTile tile = film.load_tile(0), next = tile;
  HitVectors vectors;
  const auto add = [&](FilmTile* to, float distance) {
    for (const Aov aov : {Aov::motion, Aov::eye_point, primvar_aov(7)})
      vectors.set(aov, {distance, distance + float(size_t(aov)), 3});
    FilmSample s = sample(1, distance, 3);
    s.vectors = &vectors;
    to->add(0, s);
  };
  add(&tile, 5), add(&tile, 2), add(&tile, 4), add(&next, 1);
  film.store_tile(0, tile);
  const auto first = [](std::vector<float> values, size_t count) { return values.resize(count), values; };
  EXPECT_EQ(first(film.resolve_float(Aov::motion), 2), (std::vector<float>{2, 2 + float(size_t(Aov::motion))}));
  EXPECT_EQ(first(film.resolve_float(Aov::eye_point), 3),
            (std::vector<float>{2, 2 + float(size_t(Aov::eye_point)), 3}));
  EXPECT_EQ(first(film.resolve_float(primvar_aov(7)), 3),
            (std::vector<float>{2, 2 + float(size_t(primvar_aov(7))), 3}));
  EXPECT_EQ(film.resolve_float(Aov::eye_normal), std::vector<float>(6, 0.0f)) << "not asked for";
  tile.append(next);
  film.store_tile(0, tile);
  EXPECT_EQ(film.resolve_float(Aov::motion)[0], 1) << "of a closer part";
  EXPECT_EQ(FilmTile::bytes_per_pixel(aovs), FilmTile::bytes_per_pixel(0) + 4 + 3 * 12);
}

TEST(Aov, UnrequestedAovIsItsBackground) {
  Film film({0, 0, 1, 1}, aov_bit(Aov::color));
  for (const AovInfo& info : kAovs) {
    if (info.is_integer())
      EXPECT_EQ(static_cast<float>(film.resolve_int(info.aov)[0]), info.background) << info.name;
    else
      EXPECT_EQ(film.resolve_float(info.aov),
                std::vector<float>(static_cast<size_t>(info.components()), info.background))
          << info.name;
  }
}

// promise: embedding.viewport.stopped
TEST(Film, CountsPixelsWithoutASample) {
  Film film({-3, 2, 40, 30}, 0);
  EXPECT_EQ(film.pixels_without_sample(), 43u * 28u);
  film.change_tile(1, [](FilmTile& tile) {
    tile.add(0, {});
    tile.add(0, {});
    tile.add(5, {});
  });
  EXPECT_EQ(film.pixels_without_sample(), 43u * 28u - 2);
}

// take() copies every plane.
TEST(FilmTile, APixelIsTakenWithAllItsPlanes) {
  const FilmExtras extras{true, {4, 20}, 2};
  constexpr AovSet kAovs = ~AovSet{0} & ~aov_bit(Aov::denoised);
  HitVectors vectors;
  FilmTile from(2, kAovs, extras), to(2, kAovs, extras);
  for (uint32_t i = 0; i < 16; ++i) {
    FilmSample sample;
    sample.color = Rgb(float(i % 3)), sample.alpha = 1, sample.distance = float(20 - i), sample.normal = {0, 1, 0};
    sample.albedo = Rgb(0.5f), sample.matte = sample.material_id = int32_t(i % 5), sample.nonfinite = i % 2 == 0,
    sample.depth = 0.5f, sample.camera_distance = 3, sample.ambient_occlusion = 0.25f;
    for (auto& value : vectors.values) value = {1, 2, 3};
    sample.vectors = &vectors;
    const Rgb groups[] = {Rgb(float(i)), Rgb(1.0f)};
    sample.light_groups = groups;
    LightLayers layers;
    layers.parts.fill(Rgb(float(i)));
    for (const size_t pixel : {size_t(0), size_t(1)}) from.add(pixel, sample, &layers, 5);
  }
  to.take(0, from);
  to.take(1, from);
  const auto planes = to.planes(), expected = from.planes();
  ASSERT_EQ(planes.size(), expected.size());
  for (size_t i = 0; i < planes.size(); ++i)
    EXPECT_TRUE(std::equal(planes[i].begin(), planes[i].end(), expected[i].begin(), expected[i].end())) << i;
  from.take(0, to);  // over what is there
  for (size_t i = 0; i < to.ids().size(); ++i) EXPECT_EQ(to.ids()[i]->write(), from.ids()[i]->write());
}

}  // namespace
}  // namespace alabaster
