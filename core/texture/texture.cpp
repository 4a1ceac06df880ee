#include "core/texture/texture.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <span>

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

/// `Element` and `kCount`: see TexelPlane.
template <class Element, int kCount>
class StoredTexture final : public Texture {
 public:
  explicit StoredTexture(const TextureSource& source)
      : wrap_s_(source.wrap_s), wrap_t_(source.wrap_t), filter_(source.filter) {}
  /// `alpha`: without elements where all texels are opaque. False, with errno as the reason, if there is no place.
  bool keep(PackedTexels<Element> colors, PackedTexels<Element> alpha, const std::shared_ptr<TexelStore>& store) {
    store_ = store;
    return colors_.keep(std::move(colors), store) && (alpha.elements.empty() || alpha_.keep(std::move(alpha), store));
  }

  Rgb rgb(const Vec2f& uv) const override { return color(colors_, uv, filter_); }
  Rgb filtered(const Vec2f& uv, float width) const override {
    if (!(width > 1) || levels_.empty()) return rgb(uv);
    const float level = std::min(std::log2(width), static_cast<float>(levels_.size()));
    const auto finer = static_cast<size_t>(level);
    const Rgb fine = finer == 0 ? rgb(uv) : color(*levels_[finer - 1], uv, TextureFilter::linear);
    const float share = level - static_cast<float>(finer);
    return share > 0 ? lerp(fine, color(*levels_[finer], uv, TextureFilter::linear), share) : fine;
  }
  bool prepare_filtering() const override {
    const std::scoped_lock lock(mutex_);
    return filter_ == TextureFilter::nearest || !levels_.empty() || make_levels();
  }
  float alpha(const Vec2f& uv) const override {
    float sum = 0;
    for_each_tap(colors_, uv, filter_,
                 [&](int x, int y, float weight) { sum += (alpha_.empty() ? 1.0f : alpha_.number(x, y)) * weight; });
    return sum;
  }
  int width() const override { return colors_.width(); }
  int height() const override { return colors_.height(); }
  size_t memory_bytes() const override {
    const std::scoped_lock lock(mutex_);
    size_t bytes = colors_.memory_bytes() + alpha_.memory_bytes();
    for (const auto& level : levels_) bytes += level->memory_bytes();
    return bytes;
  }
  Rgb texel(int x, int y) const override {
    return colors_.color(std::clamp(x, 0, width() - 1), std::clamp(y, 0, height() - 1));
  }
  void add_to(Digest* digest) const override {
    digest->add(wrap_s_);
    digest->add(wrap_t_);
    digest->add(filter_);
    colors_.add_to(digest);
    alpha_.add_to(digest);
  }

 private:
  using Level = TexelPlane<uint16_t, kCount>;  // of halves: means are not in a palette

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

  bool make_levels() const {
    const auto texel = [this](int x, int y) {
      return TexelMeans::sum_of(colors_.color(x, y), alpha_.empty() ? 1.0f : alpha_.number(x, y));
    };
    std::vector<std::unique_ptr<const Level>> levels;
    TexelMeans means;
    for (Vec2i size(width(), height()); std::max(size.x, size.y) > 1; size = means.size) {
      means = levels.empty() ? halved(size, texel)
                             : halved(size, [held = std::move(means)](int x, int y) { return held.at(x, y); });
      auto level = std::make_unique<Level>();
      if (!level->keep(packed(means, kCount), store_)) return false;
      levels.push_back(std::move(level));
    }
    levels_ = std::move(levels);
    return true;
  }

  Wrap wrap_s_, wrap_t_;
  TextureFilter filter_;
  TexelPlane<Element, kCount> colors_;
  TexelPlane<Element, 1> alpha_;  // empty: 1
  std::shared_ptr<TexelStore> store_;
  mutable std::mutex mutex_;                                  // of making levels: no lookup filters before that
  mutable std::vector<std::unique_ptr<const Level>> levels_;  // from half the size down to one texel
};

template <class Element, int kCount>
std::shared_ptr<const Texture> store(PackedTexels<Element> colors, PackedTexels<Element> alpha,
                                     const TextureSource& source, const std::shared_ptr<TexelStore>& store) {
  const auto texture = std::make_shared<StoredTexture<Element, kCount>>(source);
  return texture->keep(std::move(colors), std::move(alpha), store) ? texture : nullptr;
}

/// Null, with errno as the reason, if there is no place for it.
std::shared_ptr<const Texture> make_texture(PackedImage image, const TextureSource& source,
                                            const std::shared_ptr<TexelStore>& held) {
  if (!image.bytes.elements.empty())
    return (image.is_grey ? store<uint8_t, 1> : store<uint8_t, 3>)(std::move(image.bytes), std::move(image.alpha_bytes),
                                                                   source, held);
  return (image.is_grey ? store<uint16_t, 1> : store<uint16_t, 3>)(std::move(image.halves),
                                                                   std::move(image.alpha_halves), source, held);
}

/// Grey to RGB; opaque, as ColorTransform takes RGBA.
void to_rgba(std::span<const float> pixels, const ImageLayout& layout, std::vector<float>& rgba) {
  const size_t count = pixels.size() / layout.channels;
  rgba.resize(4 * count);
  for (size_t i = 0; i < count; ++i) {
    const float* p = &pixels[i * layout.channels];
    for (size_t c = 0; c < 3; ++c) rgba[4 * i + c] = p[layout.rgb[c]];
    rgba[4 * i + 3] = 1;
  }
}

}  // namespace

void Texture::add_to(Digest* digest) const {
  digest->add(width());
  digest->add(height());
  for (int y = 0; y < height(); ++y)
    for (int x = 0; x < width(); ++x) digest->add(texel(x, y));
}

bool is_image(const TextureSource& source, const DiagnosticSink& sink) {
  if (source.may_be_set)
    if (const auto tiles = udim_tiles(source.path); !tiles.empty())
      return std::all_of(tiles.begin(), tiles.end(), [&](const UdimTile& tile) {
        TextureSource one;
        one.path = tile.path;
        return is_image(one, sink);
      });
  return ImageReader().open(source, std::numeric_limits<size_t>::max(), sink);
}

// `load`: of one image. Null if one cannot be loaded.
template <class Load>
static std::shared_ptr<const Texture> load_set(const TextureSource& source, const std::vector<UdimTile>& tiles,
                                               const Load& load) {
  std::map<std::pair<int, int>, std::shared_ptr<const Texture>> images;
  for (const UdimTile& tile : tiles) {
    TextureSource one = source;
    one.path = tile.path, one.wrap_s = one.wrap_t = Wrap::clamp, one.may_be_set = false;
    auto image = load(one);
    if (!image) return nullptr;
    images[{tile.place.x, tile.place.y}] = std::move(image);
  }
  return std::make_shared<UdimTexture>(std::move(images));
}

std::shared_ptr<const Texture> load_texture(const TextureSource& source, const ColorConfig& colors,
                                            const DiagnosticSink& sink, const std::shared_ptr<TexelStore>& store,
                                            size_t max_pixels) {
  try {
    if (source.may_be_set)
      if (const std::vector<UdimTile> tiles = udim_tiles(source.path); !tiles.empty())
        return load_set(source, tiles,
                        [&](const TextureSource& one) { return load_texture(one, colors, sink, store, max_pixels); });
    ImageReader reader;
    if (!reader.open(source, max_pixels, sink)) return nullptr;
    const std::string space =
        source.color_space == "auto" && reader.layout().low_precision ? "sRGB" : source.color_space;
    const auto transform = colors.to_rendering_space(space, [&](const Diagnostic& d) {
      report(sink, d.severity, d.code, source.path, "colour space of the image: " + d.text);
    });
    if (!transform) return nullptr;

    const ImageLayout& layout = reader.layout();
    TexelPacker packer(layout);
    std::vector<float> pixels, rgba;
    for (int y = 0; y < layout.height;) {
      const int rows = reader.read_rows(y, pixels, sink);
      if (rows == 0) return nullptr;
      to_rgba(pixels, layout, rgba);
      transform->apply(rgba.data(), rgba.size() / 4);
      packer.add(pixels, rgba);
      y += rows;
    }
    if (auto texture = make_texture(packer.take(), source, store)) return texture;
    report(sink, Severity::error, "texture.memory", source.path,
           std::string("textureMemory is spent, and the image cannot be written to a temporary file: ") +
               std::strerror(errno) + "; free disk space, set TMPDIR to another folder, or raise textureMemory");
  } catch (const std::bad_alloc&) {
    report(sink, Severity::error, "texture.memory", source.path, "not enough memory for this image; make it smaller");
  } catch (const std::exception& e) {
    report(sink, Severity::error, "texture.unreadable", source.path,
           std::string(e.what()) + "; export the image again");
  }
  return nullptr;
}

}  // namespace alabaster
