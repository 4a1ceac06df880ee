#include "core/texture/texture.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <optional>
#include <set>
#include <span>

#include "core/math/largest_half.h"
#include "core/texture/distinct_colors.h"
#include "core/texture/image_reader.h"
#include "core/texture/texel_packer.h"
#include "core/texture/texel_plane.h"
#include "core/texture/texel_pyramid.h"
#include "core/texture/udim.h"
#include "core/texture/udim_texture.h"

namespace alabaster {
namespace {

/// The two texels that a coordinate lies between, and the weight of the second. -1: outside a black border.
struct Taps {
  int i0 = 0, i1 = 0;
  float weight = 0;
};

/// The coordinate brought to the first period (or to just outside it), so that it fits an int after scaling.
float reduce(float u, Wrap wrap) {
  if (!std::isfinite(u)) return 0;
  switch (wrap) {
    case Wrap::repeat:
      return u - std::floor(u);
    case Wrap::mirror: {
      const float t = u - 2 * std::floor(u * 0.5f);
      return t > 1 ? 2 - t : t;
    }
    case Wrap::clamp:
    case Wrap::black:
      break;
  }
  return std::clamp(u, -1.0f, 2.0f);
}

int wrap_index(int i, int size, Wrap wrap) {
  if (wrap == Wrap::repeat) return i < 0 ? i + size : i >= size ? i - size : i;
  if (wrap == Wrap::black && (i < 0 || i >= size)) return -1;
  return std::clamp(i, 0, size - 1);  // mirror: the edge texel's mirror image is itself
}

Taps taps_of(float u, int size, Wrap wrap, TextureFilter filter) {
  const float x = reduce(u, wrap) * float(size) - 0.5f;
  if (filter == TextureFilter::nearest) {
    const int nearest = wrap_index(int(std::floor(x + 0.5f)), size, wrap);
    return {nearest, nearest, 0};
  }
  const float cell = std::floor(x);
  const int i = int(cell);
  return {wrap_index(i, size, wrap), wrap_index(i + 1, size, wrap), x - cell};
}

/// The texels of an image. `Element` and `kCount`: see TexelPlane.
template <class Element, int kCount>
struct StoredImage {
  using LevelElement = std::conditional_t<sizeof(Element) == sizeof(float), uint32_t, uint16_t>;
  using Level = TexelPlane<LevelElement, kCount>;  // of halves or floats: means are not in a palette

  /// `alpha`: without elements where all texels are opaque. False, with errno as the reason, if there is no place.
  bool keep(PackedTexels<Element> packed_colors, PackedTexels<Element> packed_alpha,
            const std::shared_ptr<TexelStore>& in) {
    store = in;
    return colors.keep(std::move(packed_colors), store) &&
           (packed_alpha.elements.empty() || alpha.keep(std::move(packed_alpha), store));
  }
  bool prepare_levels(const CancelToken& cancel) const {
    const std::scoped_lock lock(mutex);
    return !levels.empty() || make_levels(cancel);
  }
  size_t memory_bytes() const {
    const std::scoped_lock lock(mutex);
    size_t bytes = colors.memory_bytes() + alpha.memory_bytes();
    for (const auto& level : levels) bytes += level->memory_bytes();
    return bytes;
  }

  TexelPlane<Element, kCount> colors;
  TexelPlane<Element, 1> alpha;  // empty: 1
  std::shared_ptr<TexelStore> store;
  mutable std::mutex mutex;                                  // of making levels: no lookup filters before that
  mutable std::vector<std::unique_ptr<const Level>> levels;  // from half the size down to one texel

 private:
  bool make_levels(const CancelToken& cancel) const {
    const auto texel = [this](int x, int y) {
      return TexelMeans::sum_of(colors.color(x, y), alpha.empty() ? 1.0f : alpha.number(x, y));
    };
    const auto texels = static_cast<size_t>(colors.width()) * static_cast<size_t>(colors.height());
    const MemoryReservation memory(  // the first level's means, those of the next, and one level packed
        store ? store->memory() : nullptr, MemoryUse::textures,
        texels / 4 * (sizeof(Vec4f) + sizeof(Vec4f) / 4 + kCount * sizeof(LevelElement)),
        "filtering an image of " + std::to_string(colors.width()) + " x " + std::to_string(colors.height()) +
            " pixels");
    std::vector<std::unique_ptr<const Level>> made;
    TexelMeans means;
    for (Vec2i size(colors.width(), colors.height()); std::max(size.x, size.y) > 1; size = means.size) {
      means = made.empty() ? halved(size, texel, cancel)
                           : halved(
                                 size, [held = std::move(means)](int x, int y) { return held.at(x, y); }, cancel);
      auto level = std::make_unique<Level>();
      if (!level->keep(packed<LevelElement>(means, kCount), store)) return false;
      made.push_back(std::move(level));
    }
    levels = std::move(made);
    return true;
  }
};

/// An image as one source asks for it; several may share it.
template <class Element, int kCount>
class StoredTexture final : public Texture {
 public:
  using Image = StoredImage<Element, kCount>;
  StoredTexture(const TextureSource& source, std::shared_ptr<const Image> image)
      : wrap_s_(source.wrap_s), wrap_t_(source.wrap_t), filter_(source.filter), image_(std::move(image)) {}

  Rgb rgb(const Vec2f& uv) const override { return color(image_->colors, uv, filter_); }
  Rgb filtered(const Vec2f& uv, float width) const override {
    const auto& levels = image_->levels;
    if (!(width > 1) || levels.empty() || filter_ == TextureFilter::nearest) return rgb(uv);
    const float level = std::min(std::log2(width), static_cast<float>(levels.size()));
    const auto finer = static_cast<size_t>(level);
    const Rgb fine = finer == 0 ? rgb(uv) : color(*levels[finer - 1], uv, TextureFilter::linear);
    const float share = level - static_cast<float>(finer);
    return share > 0 ? lerp(fine, color(*levels[finer], uv, TextureFilter::linear), share) : fine;
  }
  bool prepare_filtering(const CancelToken& cancel) const override {
    return filter_ == TextureFilter::nearest || image_->prepare_levels(cancel);
  }
  std::shared_ptr<const Texture> placed(const TextureSource& source) const override {
    return std::make_shared<StoredTexture>(source, image_);
  }
  const void* texels() const override { return image_.get(); }
  float alpha(const Vec2f& uv) const override {
    float sum = 0;
    for_each_tap(image_->colors, uv, filter_, [&](int x, int y, float weight) {
      sum += (image_->alpha.empty() ? 1.0f : image_->alpha.number(x, y)) * weight;
    });
    return sum;
  }
  int width() const override { return image_->colors.width(); }
  int height() const override { return image_->colors.height(); }
  size_t memory_bytes() const override { return image_->memory_bytes(); }
  Rgb texel(int x, int y) const override {
    return image_->colors.color(std::clamp(x, 0, width() - 1), std::clamp(y, 0, height() - 1));
  }
  void add_to(Digest* digest) const override {
    digest->add(wrap_s_);
    digest->add(wrap_t_);
    digest->add(filter_);
    image_->colors.add_to(digest);
    image_->alpha.add_to(digest);
  }

 private:
  template <class Plane>
  Rgb color(const Plane& plane, const Vec2f& uv, TextureFilter filter) const {
    Rgb sum;
    for_each_tap(plane, uv, filter, [&](int x, int y, float weight) { sum += plane.color(x, y) * weight; });
    return sum;
  }
  template <class Plane, class F>
  void for_each_tap(const Plane& plane, const Vec2f& uv, TextureFilter filter, const F& f) const {
    const Taps s = taps_of(uv.x, plane.width(), wrap_s_, filter);
    Taps t = taps_of(uv.y, plane.height(), wrap_t_, filter);  // counted from the bottom row
    for (int* row : {&t.i0, &t.i1})
      if (*row >= 0) *row = plane.height() - 1 - *row;
    const auto add = [&](int x, int y, float weight) {
      if (x >= 0 && y >= 0 && weight > 0) f(x, y, weight);
    };
    add(s.i0, t.i0, (1 - s.weight) * (1 - t.weight));
    add(s.i1, t.i0, s.weight * (1 - t.weight));
    add(s.i0, t.i1, (1 - s.weight) * t.weight);
    add(s.i1, t.i1, s.weight * t.weight);
  }

  Wrap wrap_s_, wrap_t_;
  TextureFilter filter_;
  std::shared_ptr<const Image> image_;
};

template <class Element, int kCount>
std::shared_ptr<const Texture> store(PackedTexels<Element> colors, PackedTexels<Element> alpha,
                                     const TextureSource& source, const std::shared_ptr<TexelStore>& store) {
  auto image = std::make_shared<StoredImage<Element, kCount>>();
  if (!image->keep(std::move(colors), std::move(alpha), store)) return nullptr;
  return std::make_shared<StoredTexture<Element, kCount>>(source, std::move(image));
}

/// Null, with errno as the reason, if there is no place for it.
std::shared_ptr<const Texture> make_texture(PackedImage image, const TextureSource& source,
                                            const std::shared_ptr<TexelStore>& held) {
  if (!image.bytes.elements.empty())
    return (image.is_grey ? store<uint8_t, 1> : store<uint8_t, 3>)(std::move(image.bytes), std::move(image.alpha_bytes),
                                                                   source, held);
  if (!image.floats.elements.empty())
    return (image.is_grey ? store<uint32_t, 1> : store<uint32_t, 3>)(std::move(image.floats),
                                                                     std::move(image.alpha_floats), source, held);
  return (image.is_grey ? store<uint16_t, 1> : store<uint16_t, 3>)(std::move(image.halves),
                                                                   std::move(image.alpha_halves), source, held);
}

/// Replaces the infinities of an image by its largest value, or that of a half if it is larger.
struct Infinity {
  float value = kLargestHalf;
  bool is_used = false;
  float largest = 0;  // of the finite values so far

  void replace_in(std::vector<float>* values) {
    for (float& v : *values) {
      const float size = std::abs(v);
      if (size <= std::numeric_limits<float>::max())
        largest = std::max(largest, size);
      else if (std::isinf(v))
        v = std::copysign(value, v), is_used = true;
    }
  }
};

/// Reads, converts and packs the rows of images.
class RowPacker {
 public:
  RowPacker(const TextureSource& source, const TextureLoading& loading, const DiagnosticSink& sink)
      : source_(source), loading_(loading), sink_(sink) {}

  /// Nothing, after a report, if the image cannot be read. `floats`: as of TexelPacker.
  std::optional<PackedImage> pack(const ColorConfig& colors, bool floats) {
    Infinity infinity;
    auto packed = pack(colors, floats, &infinity);
    if (!packed || !infinity.is_used || infinity.largest <= infinity.value) return packed;
    infinity.value = infinity.largest;  // which is known at the end
    return pack(colors, floats, &infinity);
  }
  /// After MemoryRefused: halves would have taken less.
  bool needs_floats() const { return needs_floats_; }

 private:
  std::optional<PackedImage> pack(const ColorConfig& colors, bool floats, Infinity* infinity) {
    MemoryReservation memory(loading_.store ? loading_.store->memory() : nullptr, MemoryUse::textures);
    ImageReader reader;
    if (!reader.open(source_, {loading_.max_pixels, &memory}, sink_)) return std::nullopt;
    const ImageLayout& layout = reader.layout();
    const std::string space = source_.color_space == "auto" && layout.low_precision ? "sRGB" : source_.color_space;
    const auto transform = colors.to_rendering_space(space, [&](const Diagnostic& d) {
      report(sink_, d.severity, d.code, source_.path, "colour space of the image: " + d.text);
    });
    if (!transform) return std::nullopt;
    memory.resize(memory.bytes() + layout.working_bytes * 2,
                  "decoding an image of " + std::to_string(layout.width) + " pixels a row");
    const auto own_colors = own_colors_of(reader, colors);
    TexelPacker packer(layout, &memory, floats);
    ImageRows rows;
    for (int y = 0; y < layout.height;) {
      loading_.cancel.check();
      const int count = reader.read_rows(y, rows, sink_);
      if (count == 0) return std::nullopt;
      if (source_.is_straight && layout.associated) divide_by_alpha(layout, &rows);
      add(rows, size_t(count) * size_t(layout.width), layout, {*transform, own_colors, infinity}, &packer);
      y += count;
    }
    return packer.take();
  }

  // Where nothing is covered a colour is added light, and stays.
  static void divide_by_alpha(const ImageLayout& layout, ImageRows* rows) {
    const std::set<size_t> colors(layout.rgb.begin(), layout.rgb.end());  // grey has one
    const auto divide = [&](auto* values, const auto& over) {
      for (size_t texel = 0; texel < values->size(); texel += layout.channels)
        for (const size_t c : colors)
          if (c != ImageLayout::kNoChannel)
            (*values)[texel + c] = over((*values)[texel + c], (*values)[texel + *layout.alpha]);
    };
    if (layout.bytes)
      divide(&rows->bytes, [](unsigned color, unsigned alpha) {
        return uint8_t(alpha == 0 ? color : std::min(255u, (color * 255 + alpha / 2) / alpha));
      });
    else
      divide(&rows->floats, [](float color, float alpha) { return alpha > 0 && alpha < 1 ? color / alpha : color; });
  }

  using Matrix = std::array<std::array<float, 3>, 3>;
  struct Conversion {
    const ColorTransform& transform;
    const std::optional<Matrix>& own_colors;
    Infinity* infinity;
  };

  /// From the values that the file holds to those that its header says they are; in "auto", of its primaries.
  std::optional<Matrix> own_colors_of(const ImageReader& reader, const ColorConfig& colors) {
    Matrix matrix{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const Matrix none = matrix;
    if (const auto& own = reader.chromaticities(); own && source_.color_space == "auto") {
      const Chromaticities rendering = colors.chromaticities(colors.rendering_space());
      const auto is_near = [](float a, float b) { return std::abs(a - b) < 1e-4f; };
      if (!std::equal(own->begin(), own->end(), rendering.begin(), is_near)) {
        const auto converted = rgb_to_rgb(*own, rendering);
        if (!converted && !std::exchange(reported_colors_, true))  // the image may be packed several times
          report(
              sink_, Severity::warning, "texture.chromaticities", source_.path,
              "the chromaticities of its header are those of no colour space, and are ignored; name its colour space");
        matrix = converted.value_or(none);
      }
    }
    for (auto& row : matrix)
      for (size_t i = 0; i < 3; ++i) row[i] *= reader.scale()[i];
    return matrix == none ? std::nullopt : std::optional(matrix);
  }

  static void apply(const Matrix& matrix, std::vector<float>* rgba) {
    constexpr float kMost = std::numeric_limits<float>::max();  // no product becomes an infinity
    for (size_t i = 0; i < rgba->size(); i += 4) {
      float* const c = &(*rgba)[i];
      const std::array<float, 3> in{c[0], c[1], c[2]};
      for (size_t row = 0; row < 3; ++row)
        c[row] = std::clamp(matrix[row][0] * in[0] + matrix[row][1] * in[1] + matrix[row][2] * in[2], -kMost, kMost);
    }
  }

  void add(const ImageRows& rows, size_t texels, const ImageLayout& layout, const Conversion& to, TexelPacker* packer) {
    for (size_t first = 0; first < texels; first += DistinctColors::kMostTexels) {
      colors_->find(rows, layout, first, std::min(DistinctColors::kMostTexels, texels - first));
      if (!layout.bytes) to.infinity->replace_in(&colors_->rgba());
      if (to.own_colors) apply(*to.own_colors, &colors_->rgba());
      to.transform.apply(colors_->rgba().data(), colors_->rgba().size() / 4);
      try {
        packer->add(*colors_, rows, first);
      } catch (const MemoryRefused&) {
        needs_floats_ = packer->needs_floats();
        throw;
      }
    }
  }

  const TextureSource& source_;
  const TextureLoading& loading_;
  const DiagnosticSink& sink_;
  bool reported_colors_ = false, needs_floats_ = false;
  const std::unique_ptr<DistinctColors> colors_ = std::make_unique<DistinctColors>();
};

/// As halves, after a warning, where the memory limit leaves no place for floats.
std::optional<PackedImage> pack_image(const TextureSource& source, const ColorConfig& colors,
                                      const DiagnosticSink& sink, const TextureLoading& loading) {
  RowPacker packer(source, loading, sink);
  try {
    return packer.pack(colors, true);
  } catch (const MemoryRefused&) {
    if (!packer.needs_floats()) throw;
    auto packed = packer.pack(colors, false);
    if (packed)
      report(sink, Severity::warning, "texture.precision", source.path,
             "the memory limit leaves no place for its texels as floats, so they are halves (11 bits, at most 65504); "
             "raise memoryLimit");
    return packed;
  }
}

}  // namespace

void Texture::add_to(Digest* digest) const {
  digest->add(width());
  digest->add(height());
  for (int y = 0; y < height(); ++y)
    for (int x = 0; x < width(); ++x) digest->add(texel(x, y));
}

static std::vector<UdimTile> tiles_of(const TextureSource& source) {
  if (!source.may_be_set) return {};
  return source.bytes ? udim_tiles(source.path, *source.bytes) : udim_tiles(source.path);
}

bool is_image(const TextureSource& source, const DiagnosticSink& sink) {
  if (const auto tiles = tiles_of(source); !tiles.empty())
    return std::all_of(tiles.begin(), tiles.end(), [&](const UdimTile& tile) {
      TextureSource one;
      one.path = tile.path, one.bytes = tile.bytes, one.within = source.within, one.layer = source.layer;
      return is_image(one, sink);
    });
  return ImageReader().open(source, {std::numeric_limits<size_t>::max()}, sink);
}

std::optional<Vec2i> whole_image_size(const std::string& path) {
  ImageReader reader;
  TextureSource source;
  source.path = path;
  if (!reader.open(source, {std::numeric_limits<size_t>::max()}, {})) return {};
  const Vec2i size(reader.layout().width, reader.layout().height);
  ImageRows rows;
  for (int y = 0; y < size.y;) {
    const int count = reader.read_rows(y, rows, {});
    if (count == 0) return {};
    y += count;
  }
  return size;
}

// `load`: of one image. Null if one cannot be loaded.
template <class Load>
static std::shared_ptr<const Texture> load_set(const TextureSource& source, const std::vector<UdimTile>& tiles,
                                               const Load& load) {
  std::map<std::pair<int, int>, std::shared_ptr<const Texture>> images;
  for (const UdimTile& tile : tiles) {
    TextureSource one = source;
    one.path = tile.path, one.bytes = tile.bytes, one.wrap_s = one.wrap_t = Wrap::clamp, one.may_be_set = false;
    auto image = load(one);
    if (!image) return nullptr;
    images[{tile.place.x, tile.place.y}] = std::move(image);
  }
  return std::make_shared<UdimTexture>(std::move(images));
}

std::shared_ptr<const Texture> load_texture(const TextureSource& source, const ColorConfig& colors,
                                            const DiagnosticSink& sink, const TextureLoading& loading) {
  const std::shared_ptr<TexelStore>& store = loading.store;
  try {
    if (const std::vector<UdimTile> tiles = tiles_of(source); !tiles.empty())
      return load_set(source, tiles,
                      [&](const TextureSource& one) { return load_texture(one, colors, sink, loading); });
    std::optional<PackedImage> packed = pack_image(source, colors, sink, loading);
    if (!packed) return nullptr;
    if (auto texture = make_texture(*std::move(packed), source, store)) return texture;
    report(sink, Severity::error, "texture.memory", source.path,
           std::string("textureMemory is spent, and the image cannot be written to a temporary file: ") +
               std::strerror(errno) + "; free disk space, set TMPDIR to another folder, or raise textureMemory");
  } catch (const MemoryRefused& e) {
    report(sink, Severity::error, "texture.memory", source.path, e.what());
  } catch (const std::bad_alloc&) {
    report(sink, Severity::error, "texture.memory", source.path, "not enough memory for this image; make it smaller");
  } catch (const std::exception& e) {
    report(sink, Severity::error, "texture.unreadable", source.path,
           std::string(e.what()) + "; export the image again");
  }
  return nullptr;
}

}  // namespace alabaster
