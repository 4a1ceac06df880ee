// How many of a pixel's samples hit each thing, for Cryptomatte: none is left out, however many there are. Ranks are
// cut when the pixels are read, so that parts of a frame add up to the frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/film/aov.h"

namespace alabaster {

/// What the ids stand for in files: cryptomatte_hash() of the name of each. Ids beyond a list have none, and are left
/// out.
struct IdKeys {
  std::vector<uint32_t> objects, assets;  // by FilmSample::matte
  std::vector<uint32_t> materials;        // by materialId
  const std::vector<uint32_t>& of(Aov aov) const {
    return aov == Aov::crypto_object ? objects : aov == Aov::crypto_asset ? assets : materials;
  }
};

/// Ids of the samples of a tile's pixels, with their counts. Without pixels it counts nothing.
class IdCounts {
 public:
  void resize(size_t pixels) { first_.resize(pixels); }
  bool empty() const { return first_.empty(); }
  /// Takes all counts away, but keeps the memory.
  void clear();
  /// `id` >= 0.
  void add(size_t pixel, int32_t id, uint32_t count = 1);
  /// Adds those of another tile of the same shape.
  void append(const IdCounts& next);
  /// Replaces a pixel by that of another tile of the same shape.
  void take(size_t pixel, const IdCounts& from);
  /// Bytes for each pixel, and those beside: most pixels have one id.
  static constexpr size_t bytes_per_pixel() { return sizeof(Entry); }
  size_t more_bytes() const { return more_.capacity() * sizeof(Entry); }

  /// Writes for each of `count` pixels ranks 2 * pair and 2 * pair + 1 of its keys: the bits of the key as a float, and
  /// the share of the pixel's samples. The most frequent comes first, and the smaller key of two alike. `samples`: of
  /// each pixel of the tile.
  void rank(size_t pixel, size_t count, int pair, const std::vector<uint32_t>& keys,
            const std::vector<uint32_t>& samples, float* out) const;

  /// For a checkpoint: the same bytes for the same counts.
  std::vector<std::byte> write() const;
  /// False, with the counts lost, if the bytes are none that write() gives for pixels with so many samples.
  bool read(std::span<const std::byte> bytes, const std::vector<uint32_t>& samples);
  /// More than the bytes of any counts of these samples.
  static size_t most_bytes(const std::vector<uint32_t>& samples);

 private:
  // A pixel's entries are a list: those without samples are at its end.
  struct Entry {
    int32_t id = 0;
    uint32_t count = 0;
    uint32_t next = 0;  // in more_, from 1; 0: the last
  };
  // As in a checkpoint.
  struct Stored {
    uint32_t pixel;
    int32_t id;
    uint32_t count;
  };
  template <class Visit>
  void visit(size_t pixel, const Visit& visit) const {
    for (const Entry* entry = &first_[pixel]; entry->count > 0; entry = &more_[entry->next - 1]) {
      visit(entry->id, entry->count);
      if (entry->next == 0) return;
    }
  }

  std::vector<Entry> first_;  // of each pixel
  std::vector<Entry> more_;
};

}  // namespace alabaster
