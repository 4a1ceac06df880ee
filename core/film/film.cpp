#include "core/film/film.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include <tbb/parallel_for.h>

#include "core/math/float_environment.h"

namespace alabaster {
namespace {

// All films take theirs from here.
FilmRevision next_revision() {
  static std::atomic<FilmRevision> latest{0};
  return ++latest;
}

// To a new revision, unless another thread has raised it further.
void raise(std::atomic<FilmRevision>* held) {
  const FilmRevision revision = next_revision();
  for (FilmRevision now = *held; now < revision && !held->compare_exchange_weak(now, revision);) continue;
}

}  // namespace

size_t film_bytes(const PixelRect& data_window, AovSet aovs, const FilmExtras& extras) {
  if (data_window.empty()) return 0;
  const size_t denoised = aovs & aov_bit(Aov::denoised) ? 3 * sizeof(float) : 0;
  return static_cast<size_t>(data_window.width()) * static_cast<size_t>(data_window.height()) *
         (FilmTile::bytes_per_pixel(aovs, extras) + denoised);
}

Film::Film(const PixelRect& data_window, AovSet aovs, const FilmExtras& extras)
    : window_(data_window),
      aovs_(aovs),
      extras_(extras),
      tiles_x_((std::max(0, data_window.width()) + kTileSize - 1) / kTileSize),
      tiles_y_((std::max(0, data_window.height()) + kTileSize - 1) / kTileSize),
      empty_tiles_(tile_count()),
      background_(1, aovs),
      tiles_(static_cast<size_t>(tile_count())),
      drawn_(tiles_.size()),
      tile_revisions_(tiles_.size()),
      locks_(tiles_.size()) {}

// A tile's memory is taken, or blanked, by the worker that draws into it first.
void Film::take_memory(Film* old) {
  if (window_ == old->window_ && aovs_ == old->aovs_ && extras_ == old->extras_) tiles_.swap(old->tiles_);
}

void Film::count_ids_in(const std::shared_ptr<MemoryBudget>& memory) {
  held_.clear();
  if (memory && (aovs_ & kIdsAovs))
    for (int i = 0; i < tile_count(); ++i) held_.emplace_back(memory, MemoryUse::frames);
}

PixelRect Film::tile_rect(int tile) const {
  const int x = window_.x0 + (tile % tiles_x_) * kTileSize, y = window_.y0 + (tile / tiles_x_) * kTileSize;
  return {x, y, std::min(x + kTileSize, window_.x1), std::min(y + kTileSize, window_.y1)};
}

FilmTile Film::new_tile(int tile) const {
  const PixelRect r = tile_rect(tile);
  return {static_cast<size_t>(r.width()) * static_cast<size_t>(r.height()), aovs_, extras_};
}

// Under the tile's lock.
FilmTile& Film::drawn_tile(size_t tile) {
  FilmTile& pixels = tiles_[tile];
  if (drawn_[tile]) return pixels;
  if (pixels.empty())
    pixels = new_tile(static_cast<int>(tile));
  else
    pixels.clear();
  drawn_[tile] = 1;
  --empty_tiles_;
  return pixels;
}

void Film::add(int tile, size_t pixel, const FilmSample& sample, const LightLayers* layers, uint32_t rays) {
  const auto i = static_cast<size_t>(tile);
  const std::lock_guard lock(locks_[i]);
  FilmTile& drawn = drawn_tile(i);
  drawn.add(pixel, sample, layers, rays);
  if (!held_.empty() && drawn.more_id_bytes() > held_[i].bytes()) [[unlikely]]
    held_[i].resize(drawn.more_id_bytes(), "the ids of a tile of Cryptomatte");
}

// Revisions rise after the change, and the film's after the tile's: a reader that sees the new one sees the change,
// too.
void Film::mark_changed(int tile) {
  tile_revisions_[static_cast<size_t>(tile)] = next_revision();
  raise(&revision_);
}

uint32_t Film::next_sample(int tile, size_t pixel) const {
  const FilmTile* const drawn = find_drawn(static_cast<size_t>(tile));
  return drawn ? drawn->next_sample(pixel) : extras_.range.begin;
}

uint32_t Film::least_samples() const {
  uint32_t least = tiles_.empty() ? 0 : std::numeric_limits<uint32_t>::max();
  for (size_t i = 0; i < tiles_.size(); ++i) least = std::min(least, drawn_[i] ? tiles_[i].least_samples() : 0);
  return least;
}

uint32_t Film::most_samples() const {
  uint32_t most = 0;
  for (size_t i = 0; i < tiles_.size(); ++i) most = std::max(most, drawn_[i] ? tiles_[i].most_samples() : 0);
  return most;
}

uint64_t Film::pixels_without_sample() const {
  uint64_t pixels = 0;
  for (int t = 0; t < tile_count(); ++t) {
    const PixelRect r = tile_rect(t);
    const FilmTile* const drawn = find_drawn(static_cast<size_t>(t));
    pixels +=
        drawn ? drawn->pixels_without_sample() : static_cast<uint64_t>(r.width()) * static_cast<uint64_t>(r.height());
  }
  return pixels;
}

FilmTile Film::load_tile(int tile) const {
  const auto i = static_cast<size_t>(tile);
  const std::lock_guard lock(locks_[i]);
  return drawn_[i] ? tiles_[i] : new_tile(tile);
}

void Film::store_tile(int tile, const FilmTile& pixels) {
  change_tile(tile, [&](FilmTile& drawn) { drawn = pixels; });
}

FilmRevision Film::revision(int tile, Aov aov) const {
  const FilmRevision own = tile_revisions_[static_cast<size_t>(tile)];
  return aov == Aov::denoised && own ? std::max(own, denoised_revision_.load()) : own;
}

namespace {

// By pixel of a tile: itself, or the corner of the smallest block with a sample. Each corner comes before its block.
using ShownPixels = std::array<uint16_t, size_t(Film::kTileSize) * Film::kTileSize>;
ShownPixels shown_pixels(const FilmTile& tile, size_t width, size_t height) {
  ShownPixels shown;
  for (size_t y = 0; y < height; ++y)
    for (size_t x = 0; x < width; ++x) {
      const size_t pixel = y * width + x, lowest_bit = (x | y) & (~(x | y) + 1);
      const bool shows_itself = tile.samples(pixel) > 0 || pixel == 0;
      shown[pixel] = shows_itself ? static_cast<uint16_t>(pixel) : shown[(y & ~lowest_bit) * width + (x & ~lowest_bit)];
    }
  return shown;
}

// Resolves the pixels of a row one by one run of neighbours after the other.
template <class T, class Resolve>
void resolve_shown(std::span<const uint16_t> row, const FilmTile& tile, size_t n, const Resolve& resolve, T* values) {
  for (size_t x = 0, run = 1; x < row.size(); x += run) {
    for (run = 1; x + run < row.size() && row[x + run] == row[x] + run;) ++run;
    if (x > 0 && row[x] == row[x - 1]) {
      std::copy_n(values + (x - 1) * n, n, values + x * n);
      run = 1;
    } else {
      resolve(tile, row[x], values + x * n, run);
    }
  }
}

}  // namespace

template <class T, class Resolve>
void Film::resolve_rows(int tile, Aov aov, const Resolve& resolve, const TakeRow<T>& take) const {
  constexpr size_t kMostComponents = 4;
  std::array<T, kTileSize * kMostComponents> values;
  const auto n = static_cast<size_t>(aov_info(aov).components());
  const PixelRect r = tile_rect(tile);
  const auto width = static_cast<size_t>(r.width()), height = static_cast<size_t>(r.height());
  const std::lock_guard lock(locks_[static_cast<size_t>(tile)]);
  const FilmTile* const drawn = find_drawn(static_cast<size_t>(tile));
  const bool fills = drawn && drawn->pixels_without_sample() > 0 && aov != Aov::sample_count;
  const ShownPixels shown = fills ? shown_pixels(*drawn, width, height) : ShownPixels();
  if (!drawn)
    for (size_t x = 0; x < width; ++x) resolve(background_, 0, values.data() + x * n, 1);
  for (size_t y = 0; y < height; ++y) {
    const std::span row(shown.data() + y * width, width);
    if (drawn && !fills)
      resolve(*drawn, y * width, values.data(), width);
    else if (drawn && (y == 0 || !std::equal(row.begin(), row.end(), row.data() - width)))  // else as the row before
      resolve_shown(row, *drawn, n, resolve, values.data());
    take(r.x0, r.y0 + static_cast<int>(y), {values.data(), width * n});
  }
}

template <class T>
Film::TakeRow<T> Film::copy_to(std::vector<T>* frame, int components) const {
  const auto width = static_cast<size_t>(window_.width()), n = static_cast<size_t>(components);
  frame->resize(width * static_cast<size_t>(window_.height()) * n);
  return [=, this](int x, int y, std::span<const T> values) {
    const size_t pixel = static_cast<size_t>(y - window_.y0) * width + static_cast<size_t>(x - window_.x0);
    std::copy(values.begin(), values.end(), frame->data() + pixel * n);
  };
}

void Film::store_denoised(std::vector<float> rgb) {
  std::shared_ptr<const std::vector<float>> stored;
  if (!rgb.empty()) stored = std::make_shared<const std::vector<float>>(std::move(rgb));
  {
    const std::lock_guard lock(denoised_lock_);
    denoised_.swap(stored);
  }
  denoised_revision_ = next_revision();
  raise(&revision_);
}

void Film::resolve_denoised(int tile, const TakeRow<float>& take) const {
  std::shared_ptr<const std::vector<float>> rgb;
  {
    const std::lock_guard lock(denoised_lock_);
    rgb = denoised_;
  }
  if (!rgb) return resolve_float(tile, Aov::color, take);
  resolve_float(tile, Aov::color, [&](int x, int y, std::span<const float> color) {
    std::array<float, size_t(kTileSize) * 4> row;
    const size_t first = static_cast<size_t>(y - window_.y0) * static_cast<size_t>(window_.width()) +
                         static_cast<size_t>(x - window_.x0);
    for (size_t i = 0; i < color.size(); ++i) row[i] = i % 4 < 3 ? (*rgb)[3 * (first + i / 4) + i % 4] : color[i];
    take(x, y, {row.data(), color.size()});
  });
}

void Film::resolve_float(int tile, Aov aov, const TakeRow<float>& take) const {
  if (aov == Aov::denoised) return resolve_denoised(tile, take);
  resolve_rows<float>(
      tile, aov,
      [aov](const FilmTile& from, size_t pixel, float* out, size_t count) { from.resolve(pixel, aov, out, count); },
      take);
}

void Film::resolve_int(int tile, Aov aov, const TakeRow<int32_t>& take) const {
  resolve_rows<int32_t>(
      tile, aov,
      [aov](const FilmTile& from, size_t pixel, int32_t* out, size_t count) {
        from.resolve_int(pixel, aov, out, count);
      },
      take);
}

void Film::resolve_light_group(int tile, size_t group, const TakeRow<float>& take) const {
  resolve_rows<float>(
      tile, Aov::light_group,
      [group](const FilmTile& from, size_t pixel, float* out, size_t count) {
        from.resolve_light_group(pixel, group, out, count);
      },
      take);
}

void Film::resolve_ranks(int tile, Aov aov, int pair, const IdKeys& keys, const TakeRow<float>& take) const {
  resolve_rows<float>(
      tile, aov,
      [&](const FilmTile& from, size_t pixel, float* out, size_t count) {
        from.resolve_ranks(pixel, aov, pair, keys, out, count);
      },
      take);
}

std::vector<float> Film::resolve_float(Aov aov) const {
  std::vector<float> frame;
  const auto take = copy_to(&frame, aov_info(aov).components());
  for (int t = 0; t < tile_count(); ++t) resolve_float(t, aov, take);
  return frame;
}

std::vector<float> Film::resolve_light_group(size_t group) const {
  std::vector<float> frame;
  const auto take = copy_to(&frame, aov_info(Aov::light_group).components());
  for (int t = 0; t < tile_count(); ++t) resolve_light_group(t, group, take);
  return frame;
}

std::vector<int32_t> Film::resolve_int(Aov aov) const {
  std::vector<int32_t> frame;
  const auto take = copy_to(&frame, 1);
  for (int t = 0; t < tile_count(); ++t) resolve_int(t, aov, take);
  return frame;
}

template <class T, class Read>
std::vector<T> Film::read_pixels(const Read& read, const CancelToken& cancel) const {
  if (window_.empty()) return {};
  const auto width = static_cast<size_t>(window_.width());
  std::vector<T> frame(width * static_cast<size_t>(window_.height()));
  tbb::parallel_for(0, tile_count(), [&](int t) {
    if (cancel.is_cancelled()) return;
    const FloatEnvironment environment;
    const PixelRect r = tile_rect(t);
    const std::lock_guard lock(locks_[static_cast<size_t>(t)]);
    const FilmTile* const drawn = find_drawn(static_cast<size_t>(t));
    if (!drawn) return;
    size_t pixel = 0;
    for (int y = r.y0; y < r.y1; ++y) {
      T* row = frame.data() + static_cast<size_t>(y - window_.y0) * width + (r.x0 - window_.x0);
      for (int x = r.x0; x < r.x1; ++x) *row++ = read(*drawn, pixel++);
    }
  });
  cancel.check();
  return frame;
}

std::vector<PixelNoise> Film::noise(const CancelToken& cancel) const {
  return read_pixels<PixelNoise>([](const FilmTile& tile, size_t pixel) { return tile.noise(pixel); }, cancel);
}

std::vector<uint32_t> Film::rays() const {
  return read_pixels<uint32_t>([](const FilmTile& tile, size_t pixel) { return tile.rays(pixel); }, {});
}

}  // namespace alabaster
