// The film of a part of the samples, appended to the film of those before, is the film of all.
#include <gtest/gtest.h>

#include <random>

#include "core/film/film.h"

namespace alabaster {
namespace {

int32_t int_of(const FilmTile& tile, size_t pixel, Aov aov) {
  int32_t value = 0;
  tile.resolve_int(pixel, aov, &value);
  return value;
}

constexpr size_t kPixels = 3;

// A sample by its number. Distances tie now and then.
FilmSample sample(size_t pixel, uint32_t number, LightLayers* layers) {
  std::mt19937 random(static_cast<unsigned>(pixel * 10007 + number));
  std::lognormal_distribution<float> light(static_cast<float>(pixel) * 20 - 20, 2);
  FilmSample s;
  s.color = {light(random), light(random), random() % 4 ? 0 : light(random)};
  s.alpha = random() % 3 ? 1.0f : 0.0f;
  s.distance = static_cast<float>(random() % 4 + 1);
  s.depth = s.camera_depth = s.camera_distance = static_cast<float>(number);
  s.ambient_occlusion = random() % 2 ? 1.0f : 0.0f;
  s.normal = {0.3f, -0.2f, static_cast<float>(random() % 1000) / 1000};
  s.albedo = {0.1f, static_cast<float>(random() % 1000) / 999, 0.5f};
  s.prim_id = s.instance_id = s.element_id = s.matte = static_cast<int32_t>(number);
  s.material_id = static_cast<int32_t>(random() % 3) - 1;
  s.is_held_out = random() % 5 == 0;
  s.is_caught = random() % 3 == 0;
  s.unshadowed = {light(random), light(random), random() % 3 ? light(random) : 0};
  s.shadowed = random() % 2 ? s.unshadowed : s.unshadowed * 0.3f;
  for (Rgb& part : layers->parts) part = {light(random), light(random), light(random)};
  return s;
}

FilmTile tile_of(const SampleRange& range) {
  FilmTile tile(kPixels, ~AovSet{0}, {false, range, 2});
  for (size_t pixel = 0; pixel < kPixels; ++pixel)
    for (uint32_t i = range.begin; i < range.end; ++i) {
      LightLayers layers;
      FilmSample s = sample(pixel, i, &layers);
      const Rgb groups[] = {layers.parts[0], layers.parts[1]};
      s.light_groups = groups;
      tile.add(pixel, s, &layers);
    }
  return tile;
}

// All that the tile holds, and all that it shows.
std::vector<std::byte> contents(FilmTile tile) {
  std::vector<std::byte> bytes;
  for (const auto& plane : tile.planes()) bytes.insert(bytes.end(), plane.begin(), plane.end());
  for (const IdCounts* ids : tile.ids()) {
    const std::vector<std::byte> written = ids->write();
    bytes.insert(bytes.end(), written.begin(), written.end());
  }
  for (size_t pixel = 0; pixel < kPixels; ++pixel)
    for (const AovInfo& info : kAovs) {
      float values[4] = {};
      if (info.is_integer())
        values[0] = static_cast<float>(int_of(tile, pixel, info.aov));
      else
        tile.resolve(pixel, info.aov, values);
      const auto* const raw = reinterpret_cast<const std::byte*>(values);
      bytes.insert(bytes.end(), raw, raw + sizeof values);
    }
  return bytes;
}

TEST(FilmAppend, TwoPartsGiveTheBytesOfTheWholeForAllSplits) {
  for (const uint32_t end : {1u, 2u, 3u, 7u, 8u, 9u, 33u, 64u, 100u}) {
    const std::vector<std::byte> whole = contents(tile_of({0, end}));
    for (uint32_t at = 1; at <= end; ++at) {
      FilmTile tile = tile_of({0, at});
      tile.append(tile_of({at, end}));
      ASSERT_TRUE(contents(tile) == whole) << at << " of " << end;
    }
  }
}

TEST(FilmTile, BytesThatNoIdsGiveAreRefused) {
  FilmTile from = tile_of({0, 40}), to = tile_of({0, 7});
  ASSERT_EQ(from.ids().size(), 2u) << "of prims and of materials";
  for (size_t i = 0; i < 2; ++i) {
    const std::vector<std::byte> bytes = from.ids()[i]->write();
    EXPECT_LE(bytes.size(), IdCounts::most_bytes(from.samples()));
    EXPECT_FALSE(to.ids()[i]->read(std::span(bytes).first(bytes.size() - 1), from.samples())) << "cut off";
    EXPECT_FALSE(to.ids()[i]->read(bytes, {1, 1, 1})) << "more than the samples";
    std::vector<std::byte> turned(bytes.rbegin(), bytes.rend());
    EXPECT_FALSE(to.ids()[i]->read(turned, from.samples()));
  }
}

TEST(FilmTile, CountsRaysWhereItIsAskedTo) {
  FilmTile counting(kPixels, 0, {true, {}}), other(kPixels, 0);
  counting.add(1, {}, nullptr, 5);
  counting.add(1, {}, nullptr, 6);
  other.add(1, {}, nullptr, 5);
  EXPECT_EQ(counting.rays(0), 0u);
  EXPECT_EQ(counting.rays(1), 11u);
  EXPECT_EQ(FilmTile::bytes_per_pixel(0, {true, {}}), FilmTile::bytes_per_pixel(0) + 4);
}

}  // namespace
}  // namespace alabaster
