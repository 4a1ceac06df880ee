#include "delegate/rendering/buffer_store.h"

#include <gtest/gtest.h>

#include <cstring>

namespace alabaster::hd::rendering {
namespace {

const RenderBufferDescriptor kTwoTiles{.dimensions = {64, 32, 1}, .format = Format::float32};

void draw(Film* film, int tile, float depth) {
  FilmSample sample;
  sample.distance = 1;
  sample.camera_depth = depth;
  film->change_tile(tile, [&](FilmTile& pixels) {
    for (size_t i = 0; i < 32 * 32; ++i) pixels.add(i, sample);
  });
}

std::shared_ptr<Film> film_of(std::initializer_list<float> depths) {
  auto film = std::make_shared<Film>(PixelRect{0, 0, 64, 32}, aov_bit(Aov::camera_depth));
  int tile = 0;
  for (const float depth : depths) draw(film.get(), tile++, depth);
  return film;
}

BufferSource source_of(std::shared_ptr<const Film> film) {
  BufferSource source;
  source.film = std::move(film);
  source.aov = Aov::camera_depth;
  return source;
}

// The values of two tiles, each of which shows one.
std::pair<float, float> shown(const BufferStore& store) {
  std::vector<float> values(64 * 32);
  std::memcpy(values.data(), store.pixels().data(), store.pixels().size());
  for (size_t i = 0; i < values.size(); ++i) EXPECT_EQ(values[i], values[i % 64 < 32 ? 0 : 63]) << i;
  return {values[0], values[63]};
}

using Pair = std::pair<float, float>;

// promise: embedding.viewport.old_picture
TEST(BufferStore, TheOldPictureStaysWhereNothingIsDrawnYet) {
  const BufferSource old = source_of(film_of({1, 1}));
  BufferStore first(kTwoTiles, old);
  EXPECT_TRUE(first.update(old, nullptr));
  EXPECT_EQ(shown(first), Pair(1, 1));

  const std::shared_ptr<Film> film = film_of({2});
  const BufferSource source = source_of(film);
  BufferStore second(kTwoTiles, source);
  ASSERT_TRUE(first.fits(kTwoTiles, source));
  EXPECT_TRUE(second.update(source, &first));
  EXPECT_EQ(shown(second), Pair(2, 1));

  film->set_ended(true);
  EXPECT_TRUE(first.update(source, &second)) << "stores take turns";
  EXPECT_EQ(shown(first), Pair(2, 0)) << "an ended render shows its own samples alone";
}

}  // namespace
}  // namespace alabaster::hd::rendering
