// Where samples are kept. Rows run down (y-down, as data windows do); RenderBuffer::Resolve turns them bottom-up.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "core/diagnostics/cancel.h"
#include "core/film/film_tile.h"
#include "core/memory/memory_budget.h"

namespace alabaster {

/// Rectangle of pixels, y-down, half open.
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  bool empty() const { return x1 <= x0 || y1 <= y0; }
  bool operator==(const PixelRect&) const = default;
};

/// Bytes that a Film of this window will take, but for a few per tile.
size_t film_bytes(const PixelRect& data_window, AovSet aovs, const FilmExtras& extras = {});

/// Tells contents apart: each change makes a new one, and no two films give out the same.
using FilmRevision = uint64_t;

/// Accumulators of a data window, in tiles, each of which takes its memory when something is drawn into it. Workers add
/// samples in place and readers resolve a tile at a time, both under the lock of that tile only. All const functions,
/// change_tile() and add() may be called from any thread.
class Film {
 public:
  static constexpr int kTileSize = 32;
  /// `aovs`: bits of Aov. Color and alpha are always there.
  Film(const PixelRect& data_window, AovSet aovs, const FilmExtras& extras = {});
  /// Takes over the memory of a film of the same window and AOVs, whose samples are lost. Nobody uses that one, and
  /// this has no sample yet; it may be read meanwhile.
  void take_memory(Film* old);
  /// Counts there what grows with the ids that samples meet, beyond film_bytes(): add() throws MemoryRefused.
  void count_ids_in(const std::shared_ptr<MemoryBudget>& memory);

  const PixelRect& data_window() const { return window_; }
  AovSet aovs() const { return aovs_; }
  const FilmExtras& extras() const { return extras_; }
  int tile_count() const { return tiles_x_ * tiles_y_; }
  PixelRect tile_rect(int tile) const;

  /// Adds a sample to a pixel (row-major within the tile). Readers may miss it until mark_changed(). See FilmWriter.
  void add(int tile, size_t pixel, const FilmSample& sample, const LightLayers* layers, uint32_t rays);
  void mark_changed(int tile);
  /// Not for the time while another thread changes the tile.
  uint32_t next_sample(int tile, size_t pixel) const;
  FilmTile load_tile(int tile) const;
  /// Calls change(FilmTile&) under the tile's lock.
  template <class Change>
  void change_tile(int tile, const Change& change);
  void store_tile(int tile, const FilmTile& pixels);
  /// Sets the red, green and blue of AOV `denoised`, row-major. Until then, and if it is empty, they are those of
  /// color.
  void store_denoised(std::vector<float> rgb);

  /// As long as it stays the same, so do the pixels. 0: nothing was drawn.
  FilmRevision revision() const { return revision_.load(); }
  /// The same for a tile and an AOV.
  FilmRevision revision(int tile, Aov aov) const;
  /// The least and the most samples of a pixel. Not for the time while a thread changes the film.
  uint32_t least_samples() const;
  uint32_t most_samples() const;
  /// Not for the time while a thread changes the film.
  uint64_t pixels_without_sample() const;
  /// True if every tile shows something.
  bool is_covered() const { return empty_tiles_.load() == 0; }
  /// True if the render that fills it has ended.
  bool has_ended() const { return ended_; }
  void set_ended(bool ended) { ended_ = ended; }

  /// Takes a row of a tile: the resolved values of the pixels from (x, y) rightwards, component by component.
  template <class T>
  using TakeRow = std::function<void(int x, int y, std::span<const T> values)>;
  /// Resolves a tile, without a copy of it. `take` is called under its lock. A pixel that has no sample yet shows the
  /// corner of the smallest block of pixels (of 2, 4, ... on a side) that has one, but for AOV sampleCount. An AOV that
  /// is not requested resolves to its background value.
  void resolve_float(int tile, Aov aov, const TakeRow<float>& take) const;
  void resolve_int(int tile, Aov aov, const TakeRow<int32_t>& take) const;
  /// Of Aov::light_group: a group.
  void resolve_light_group(int tile, size_t group, const TakeRow<float>& take) const;
  /// Of an AOV of ids: a pair of ranks.
  void resolve_ranks(int tile, Aov aov, int pair, const IdKeys& keys, const TakeRow<float>& take) const;
  /// A frame, row-major, y-down.
  std::vector<float> resolve_float(Aov aov) const;
  std::vector<float> resolve_light_group(size_t group) const;
  std::vector<int32_t> resolve_int(Aov aov) const;
  // These run on all threads of the caller's TBB arena.
  std::vector<PixelNoise> noise(const CancelToken& cancel = {}) const;  // throws BuildCancelled
  /// The rays that each pixel has cost, for a film that counts them.
  std::vector<uint32_t> rays() const;

 private:
  template <class T, class Resolve>
  void resolve_rows(int tile, Aov aov, const Resolve& resolve, const TakeRow<T>& take) const;
  void resolve_denoised(int tile, const TakeRow<float>& take) const;
  template <class T, class Read>
  std::vector<T> read_pixels(const Read& read, const CancelToken& cancel) const;
  template <class T>
  TakeRow<T> copy_to(std::vector<T>* frame, int components) const;
  FilmTile new_tile(int tile) const;
  FilmTile& drawn_tile(size_t tile);
  const FilmTile* find_drawn(size_t tile) const { return drawn_[tile] ? &tiles_[tile] : nullptr; }

  PixelRect window_;
  AovSet aovs_ = 0;
  FilmExtras extras_;
  int tiles_x_ = 0, tiles_y_ = 0;
  std::atomic<int> empty_tiles_{0};
  std::atomic<bool> ended_{false};
  std::atomic<FilmRevision> revision_{0}, denoised_revision_{0};
  FilmTile background_;          // one pixel without samples
  std::vector<FilmTile> tiles_;  // those that are not drawn may hold what an earlier film left
  std::vector<uint8_t> drawn_;   // guarded by the tile's lock
  std::vector<std::atomic<FilmRevision>> tile_revisions_;
  std::vector<MemoryReservation> held_;  // by tile, for its ids; empty: not counted
  mutable std::vector<std::mutex> locks_;
  mutable std::mutex denoised_lock_;
  std::shared_ptr<const std::vector<float>> denoised_;
};

/// A tile of a film, for the one thread that adds samples to it at a time.
class FilmWriter {
 public:
  FilmWriter(Film* film, int tile) : film_(film), tile_(tile) {}
  ~FilmWriter() {
    if (changed_) film_->mark_changed(tile_);
  }
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;
  uint32_t next_sample(size_t pixel) const { return film_->next_sample(tile_, pixel); }
  void add(size_t pixel, const FilmSample& sample, const LightLayers* layers, uint32_t rays) {
    film_->add(tile_, pixel, sample, layers, rays);
    changed_ = true;
  }

 private:
  Film* film_;
  int tile_;
  bool changed_ = false;
};

template <class Change>
void Film::change_tile(int tile, const Change& change) {
  {
    const auto i = static_cast<size_t>(tile);
    const std::lock_guard lock(locks_[i]);
    change(drawn_tile(i));
  }
  mark_changed(tile);
}

}  // namespace alabaster
