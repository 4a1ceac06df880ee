// Texels as they are kept, in memory or in a store's file. Internal to this room.
#pragma once

#include <half.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "core/color/rgb.h"
#include "core/digest/digest.h"
#include "core/math/vector.h"
#include "core/texture/texel_store.h"

namespace alabaster {

/// Bytes, which stand for entries of a palette, or the bits of halves, or those of floats.
template <class Element>
struct PackedTexels {
  Vec2i size{0, 0};
  std::vector<Element> elements;  // 1 or 3 per texel, rows from the top
  /// The values of bytes: 256 values for each element, three times 256 where one element is a colour. Empty for others.
  std::vector<float> palette;
};

/// Immutable. `kCount` elements per texel, 1 or 3.
template <class Element, int kCount>
class TexelPlane {
 public:
  /// In memory if there is no store, or it lends the memory; else in its file. False, with errno as the reason, if that
  /// cannot be written.
  bool keep(PackedTexels<Element> texels, std::shared_ptr<TexelStore> store);
  TexelPlane() = default;
  ~TexelPlane();
  TexelPlane(const TexelPlane&) = delete;
  TexelPlane& operator=(const TexelPlane&) = delete;

  bool empty() const { return texels_.size.x == 0; }
  int width() const { return texels_.size.x; }
  int height() const { return texels_.size.y; }
  /// Without the tiles in the store's cache.
  size_t memory_bytes() const {
    return texels_.elements.capacity() * sizeof(Element) + texels_.palette.capacity() * sizeof(float) +
           tile_count_ * sizeof(std::atomic<uint32_t>);
  }

  Rgb color(int x, int y) const {
    constexpr int g = kCount == 3 ? 1 : 0, b = kCount == 3 ? 2 : 0;
    return with(x, y, [this](const Element* t) { return Rgb(value(t[0], 0), value(t[g], 1), value(t[b], 2)); });
  }
  /// Adds all texels, which are the same in memory and in the store.
  void add_to(Digest* digest) const {
    digest->add(width());
    digest->add(height());
    digest->add(texels_.palette);
    if (!slots_) return digest->add_bytes(std::as_bytes(std::span(texels_.elements)));
    std::vector<Element> row(kCount * static_cast<size_t>(width()));
    for (int y = 0; y < height(); ++y) {
      for (int x = 0; x < width(); ++x)
        with(x, y, [&](const Element* t) { std::copy_n(t, kCount, &row[kCount * static_cast<size_t>(x)]); });
      digest->add_bytes(std::as_bytes(std::span(row)));
    }
  }
  float number(int x, int y) const {
    return with(x, y, [this](const Element* t) { return value(t[0], 0); });
  }

 private:
  static constexpr bool kBytes = sizeof(Element) == 1;
  // The size of a tile that fits one of the store's.
  static constexpr uint32_t kTileWidth = kBytes && kCount == 1 ? 128 : 64;
  static constexpr uint32_t kTileHeight = TexelStore::kTileBytes / (sizeof(Element) * kTileWidth * kCount);

  float value(Element e, [[maybe_unused]] size_t row) const {
    if constexpr (kBytes) {
      return texels_.palette[256 * row + e];
    } else if constexpr (sizeof(Element) == sizeof(float)) {
      return std::bit_cast<float>(e);
    } else {
      Imath::half h;
      h.setBits(e);
      return h;
    }
  }
  template <class F>
  auto with(int x, int y, const F& f) const {
    const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(y);
    if (!slots_) return f(&texels_.elements[kCount * (size_t(row) * size_t(texels_.size.x) + column)]);
    Element t[kCount];
    const size_t tile = size_t(row / kTileHeight) * columns_ + column / kTileWidth;
    const size_t within = row % kTileHeight * kTileWidth + column % kTileWidth;
    store_->read(first_tile_ + tile, &slots_[tile], within * kCount, t, kCount);
    return f(t);
  }
  bool write_tiles();

  PackedTexels<Element> texels_;  // without elements: in the file
  std::shared_ptr<TexelStore> store_;
  size_t lent_ = 0;  // bytes
  uint64_t first_tile_ = 0;
  size_t tile_count_ = 0;
  uint32_t columns_ = 0;                            // of tiles
  std::unique_ptr<std::atomic<uint32_t>[]> slots_;  // one for each tile in the file
};

template <class Element, int kCount>
bool TexelPlane<Element, kCount>::keep(PackedTexels<Element> texels, std::shared_ptr<TexelStore> store) {
  texels_ = std::move(texels);
  store_ = std::move(store);
  const size_t bytes = texels_.elements.size() * sizeof(Element);
  if (!store_) return true;
  if (store_->reserve(bytes)) return lent_ = bytes, true;
  return write_tiles();
}

template <class Element, int kCount>
TexelPlane<Element, kCount>::~TexelPlane() {
  if (lent_ > 0) store_->release(lent_);
  if (tile_count_ > 0) store_->discard(first_tile_, tile_count_);
}

template <class Element, int kCount>
bool TexelPlane<Element, kCount>::write_tiles() {
  const auto w = static_cast<uint32_t>(width()), h = static_cast<uint32_t>(height());
  columns_ = (w + kTileWidth - 1) / kTileWidth;
  const uint32_t rows = (h + kTileHeight - 1) / kTileHeight;
  tile_count_ = size_t(columns_) * rows;
  first_tile_ = store_->allocate(tile_count_);
  std::vector<std::byte> strip(columns_ * TexelStore::kTileBytes);  // a row of tiles
  constexpr size_t kTexel = kCount * sizeof(Element);
  for (uint32_t row = 0; row < rows; ++row) {
    for (uint32_t y = row * kTileHeight; y < std::min(h, (row + 1) * kTileHeight); ++y)
      for (uint32_t column = 0; column < columns_; ++column) {
        const uint32_t x = column * kTileWidth;
        std::memcpy(&strip[column * TexelStore::kTileBytes + size_t(y % kTileHeight) * kTileWidth * kTexel],
                    &texels_.elements[kCount * (size_t(y) * w + x)], std::min(kTileWidth, w - x) * kTexel);
      }
    if (!store_->write(first_tile_ + size_t(row) * columns_, strip)) return false;
  }
  std::vector<Element>().swap(texels_.elements);
  slots_ = std::make_unique<std::atomic<uint32_t>[]>(tile_count_);
  return true;
}

}  // namespace alabaster
