#include "delegate/rendering/buffer_store.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "core/math/float_environment.h"
#include "delegate/rendering/pixel_format.h"

namespace alabaster::hd::rendering {
namespace {

// Stands for a tile in which an ended render has drawn nothing.
constexpr FilmRevision kBackground = std::numeric_limits<FilmRevision>::max();

bool covers_buffer(const RenderBufferDescriptor& d, const BufferSource& source) {
  if (!source.film) return false;
  const PixelRect& window = source.film->data_window();
  return window.x0 + source.buffer_x <= 0 && window.y0 + source.buffer_y <= 0 &&
         window.x1 + source.buffer_x >= d.dimensions.x && window.y1 + source.buffer_y >= d.dimensions.y;
}

void clear_pixels(const Value& clear, Format format, std::vector<uint8_t>* pixels) {
  const size_t size = FormatSize(format);
  write_clear(clear, format, pixels->data());
  for (size_t at = size; at < pixels->size(); at += size) std::memcpy(pixels->data() + at, pixels->data(), size);
}

}  // namespace

BufferStore::BufferStore(const RenderBufferDescriptor& description, const BufferSource& source)
    : description_(description),
      aov_(source.aov),
      window_(source.film ? source.film->data_window() : PixelRect()),
      buffer_x_(source.buffer_x),
      buffer_y_(source.buffer_y),
      plane_(source.plane),
      clear_(source.clear),
      pixels_(static_cast<size_t>(description.dimensions.x) * static_cast<size_t>(description.dimensions.y) *
              FormatSize(description.format)),
      tiles_(source.film ? static_cast<size_t>(source.film->tile_count()) : 0),
      changed_(tiles_.size()),
      differs_(tiles_.size(), 1) {
  const PixelRect all{0, 0, description.dimensions.x, description.dimensions.y};
  for (int i = 0; i < static_cast<int>(tiles_.size()); ++i) {
    const PixelRect tile = source.film->tile_rect(i);
    rects_.push_back({std::max(tile.x0 + buffer_x_, 0), std::max(tile.y0 + buffer_y_, 0),
                      std::min(tile.x1 + buffer_x_, all.x1), std::min(tile.y1 + buffer_y_, all.y1)});
  }
  if (!pixels_.empty() && !covers_buffer(description, source)) clear_pixels(clear_, description.format, &pixels_);
}

bool BufferStore::fits(const RenderBufferDescriptor& description, const BufferSource& source) const {
  return description_ == description && source.film && window_ == source.film->data_window() && aov_ == source.aov &&
         buffer_x_ == source.buffer_x && buffer_y_ == source.buffer_y && plane_ == source.plane &&
         clear_ == source.clear;
}

bool BufferStore::update(const BufferSource& source, const BufferStore* before) {
  revision_ = source.film->revision();
  if (pixels_.empty()) return !before;
  std::atomic<bool> differs{!before};
  const auto update_one = [&](int tile) {
    const FloatEnvironment environment;
    const bool changes = update_tile(tile, source, before);
    differs_[static_cast<size_t>(tile)] = changes;
    if (changes) differs = true;
  };
  // Isolated: a thread that waits takes up no work of the host.
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(0, static_cast<int>(tiles_.size()), update_one); });
  return differs;
}

bool BufferStore::update_tile(int tile, const BufferSource& source, const BufferStore* before) {
  // Find out what the tile has to show.
  const auto i = static_cast<size_t>(tile);
  const FilmRevision old = before ? before->tiles_[i] : kBackground;
  FilmRevision wanted = source.film->revision(tile, aov_);
  if (wanted == 0) wanted = source.film->has_ended() ? kBackground : old;

  // Draw it unless it is there.
  if (tiles_[i] != wanted) {
    if (before && wanted == old)
      copy_tile(tile, *before);
    else
      convert_tile(tile, source);
    tiles_[i] = wanted;
  }
  return wanted != old;
}

void BufferStore::set_number(uint64_t number, const BufferStore* before) {
  number_ = number;
  first_number_ = before ? before->first_number_ : number;
  for (size_t i = 0; i < changed_.size(); ++i) changed_[i] = before && !differs_[i] ? before->changed_[i] : number;
}

std::vector<PixelRect> BufferStore::changes_since(uint64_t number) const {
  std::vector<PixelRect> changes;
  if (number != 0 && number >= first_number_) {
    for (size_t i = 0; i < rects_.size(); ++i)
      if (changed_[i] > number) changes.push_back(rects_[i]);
    return changes;
  }
  constexpr int kRows = 16;
  for (int y = 0; y < description_.dimensions.y; y += kRows)
    changes.push_back({0, y, description_.dimensions.x, std::min(y + kRows, description_.dimensions.y)});
  return changes;
}

size_t BufferStore::offset(int x, int y_down) const {
  const auto row = static_cast<size_t>(description_.dimensions.y - 1 - y_down);  // rows of a buffer run bottom-up
  return (row * static_cast<size_t>(description_.dimensions.x) + static_cast<size_t>(x)) *
         FormatSize(description_.format);
}

void BufferStore::copy_tile(int tile, const BufferStore& from) {
  const PixelRect& rect = rects_[static_cast<size_t>(tile)];
  if (rect.x0 >= rect.x1) return;
  for (int y = rect.y0; y < rect.y1; ++y)
    std::memcpy(pixel(rect.x0, y), from.pixels_.data() + offset(rect.x0, y),
                static_cast<size_t>(rect.x1 - rect.x0) * FormatSize(description_.format));
}

void BufferStore::convert_tile(int tile, const BufferSource& source) {
  const auto components = static_cast<size_t>(aov_info(aov_).components());
  // Takes a row of the film's pixels, which begins at (x, y), as far as it lies in the buffer.
  const auto take = [&](int x, int y, const auto& values) {
    const int row = y + buffer_y_, column = x + buffer_x_;
    const int first = std::max(column, 0);
    const int last = std::min(column + static_cast<int>(values.size() / components), description_.dimensions.x);
    if (row < 0 || row >= description_.dimensions.y || first >= last) return;
    const auto inside = values.subspan(static_cast<size_t>(first - column) * components,
                                       static_cast<size_t>(last - first) * components);
    if constexpr (std::is_same_v<std::decay_t<decltype(values)>, std::span<const int32_t>>)
      write_pixels(inside, description_.format, pixel(first, row));
    else
      write_pixels(inside, components, description_.format, pixel(first, row));
  };
  if (aov_info(aov_).is_integer())
    source.film->resolve_int(tile, aov_, take);
  else if (source.keys && (kIdsAovs & aov_bit(aov_)))
    source.film->resolve_ranks(tile, aov_, plane_, *source.keys, take);
  else if (aov_ == Aov::light_group)
    source.film->resolve_light_group(tile, static_cast<size_t>(plane_), take);
  else
    source.film->resolve_float(tile, aov_, take);
}

}  // namespace alabaster::hd::rendering
