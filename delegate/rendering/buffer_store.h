// The pixels of a host's buffer, with a note of what each tile shows: a Resolve converts those that have changed.
#pragma once

#include "core/film/film.h"
#include "delegate/api/scene_types.h"

namespace alabaster::hd::rendering {

/// The AOV of a film that a buffer shows.
struct BufferSource {
  std::shared_ptr<const Film> film;
  Aov aov = Aov::color;
  int buffer_x = 0, buffer_y = 0;  // of the film's pixel (0, 0), y-down
  Value clear;
  std::function<void()> complete = {};      // called by each Resolve before it reads the film; may be empty
  std::shared_ptr<const IdKeys> keys = {};  // of an AOV of ids
  int plane = 0;                            // of those the pair of ranks, of light groups the group
};

class BufferStore {
 public:
  /// All pixels are `source.clear`; the source's film may be null.
  BufferStore(const RenderBufferDescriptor& description, const BufferSource& source);

  const RenderBufferDescriptor& description() const { return description_; }
  const std::vector<uint8_t>& pixels() const { return pixels_; }  // bottom-up
  /// True if it is of no film.
  bool is_blank() const { return tiles_.empty(); }
  /// The film's, when update() began.
  FilmRevision revision() const { return revision_; }
  /// True if update() of this store may take `source`: the same pixels of the buffer show the same AOV.
  bool fits(const RenderBufferDescriptor& description, const BufferSource& source) const;
  /// Shows the film as it is now, on all threads of the caller's TBB arena. Tiles in which nothing was drawn yet show
  /// what `before`, a store that fits or null, does, unless the render has ended. True: it shows something else than
  /// `before`.
  bool update(const BufferSource& source, const BufferStore* before);

  /// Says that it is picture `number` of its buffer, numbers rising, and what has changed since `before`, the picture
  /// that update() was given; null: everything.
  void set_number(uint64_t number, const BufferStore* before);
  uint64_t number() const { return number_; }
  /// The pixels of the buffer, y-down, that may differ from those of picture `number`, an older one. 0: all pixels.
  std::vector<PixelRect> changes_since(uint64_t number) const;
  /// Where a pixel lies in pixels().
  size_t offset(int x, int y_down) const;

 private:
  bool update_tile(int tile, const BufferSource& source, const BufferStore* before);
  void copy_tile(int tile, const BufferStore& from);
  void convert_tile(int tile, const BufferSource& source);
  uint8_t* pixel(int x, int y_down) { return pixels_.data() + offset(x, y_down); }

  RenderBufferDescriptor description_;
  Aov aov_;
  PixelRect window_;  // of the film
  int buffer_x_, buffer_y_;
  int plane_;
  Value clear_;
  std::vector<uint8_t> pixels_;
  std::vector<FilmRevision> tiles_;  // what each shows; 0: nothing yet
  FilmRevision revision_ = 0;
  uint64_t number_ = 0, first_number_ = 0;  // first: of the picture since which only tiles have changed
  std::vector<uint64_t> changed_;           // the number of the picture in which each tile did
  std::vector<uint8_t> differs_;            // by tile, as of the last update()
  std::vector<PixelRect> rects_;            // of the tiles in the buffer; may be empty
};

}  // namespace alabaster::hd::rendering
