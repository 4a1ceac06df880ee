#include "core/texture/texture.h"

#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "core/texture/image_reader.h"

namespace alabaster {
namespace {

using Imath::half;

constexpr float kLargestHalf = 65504.0f;

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

class HalfTexture final : public Texture {
 public:
  /// `alpha`: empty, or one for each texel.
  HalfTexture(const Vec2i& size, std::vector<half> texels, std::vector<half> alpha, const TextureSource& source)
      : width_(size.x),
        height_(size.y),
        wrap_s_(source.wrap_s),
        wrap_t_(source.wrap_t),
        filter_(source.filter),
        texels_(std::move(texels)),
        alpha_(std::move(alpha)) {}

  Rgb rgb(const Vec2f& uv) const override {
    Rgb sum;
    for_each_tap(uv, [&](size_t i, float weight) {
      const half* t = &texels_[3 * i];
      sum += Rgb(t[0], t[1], t[2]) * weight;
    });
    return sum;
  }
  float alpha(const Vec2f& uv) const override {
    float sum = 0;
    for_each_tap(uv, [&](size_t i, float weight) { sum += (alpha_.empty() ? 1.0f : float(alpha_[i])) * weight; });
    return sum;
  }
  int width() const override { return width_; }
  int height() const override { return height_; }
  size_t memory_bytes() const override { return (texels_.capacity() + alpha_.capacity()) * sizeof(half); }
  Rgb texel(int x, int y) const override {
    const half* t = &texels_[3 * index(std::clamp(x, 0, width_ - 1), std::clamp(y, 0, height_ - 1))];
    return {t[0], t[1], t[2]};
  }

 private:
  size_t index(int x, int y) const { return size_t(y) * size_t(width_) + size_t(x); }

  template <class F>
  void for_each_tap(const Vec2f& uv, const F& f) const {
    const Taps s = taps_of(uv.x, width_, wrap_s_, filter_);
    Taps t = taps_of(uv.y, height_, wrap_t_, filter_);  // counted from the bottom row
    for (int* row : {&t.i0, &t.i1})
      if (*row >= 0) *row = height_ - 1 - *row;
    const auto add = [&](int x, int y, float weight) {
      if (x >= 0 && y >= 0 && weight > 0) f(index(x, y), weight);
    };
    add(s.i0, t.i0, (1 - s.weight) * (1 - t.weight));
    add(s.i1, t.i0, s.weight * (1 - t.weight));
    add(s.i0, t.i1, (1 - s.weight) * t.weight);
    add(s.i1, t.i1, s.weight * t.weight);
  }

  int width_, height_;
  Wrap wrap_s_, wrap_t_;
  TextureFilter filter_;
  std::vector<half> texels_, alpha_;  // RGB, and alpha where a texel is not opaque; rows from the top
};

/// The alpha of an image, kept from the first texel on that is not opaque.
class AlphaPlane {
 public:
  /// `pixels`: the next rows, as the layout has them.
  void add(std::span<const float> pixels, const ImageLayout& layout) {
    const size_t count = pixels.size() / layout.channels;
    if (layout.alpha)
      for (size_t i = 0; i < count; ++i) set(seen_ + i, pixels[i * layout.channels + *layout.alpha], layout);
    seen_ += count;
  }
  std::vector<half> take() { return std::move(alpha_); }

 private:
  void set(size_t texel, float alpha, const ImageLayout& layout) {
    if (alpha_.empty()) {
      if (alpha == 1) return;
      alpha_.assign(size_t(layout.width) * size_t(layout.height), half(1.0f));
    }
    alpha_[texel] = half(std::isfinite(alpha) ? std::clamp(alpha, 0.0f, 1.0f) : 1.0f);
  }

  size_t seen_ = 0;  // texels
  std::vector<half> alpha_;
};

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

bool is_image(const TextureSource& source, const DiagnosticSink& sink) {
  return ImageReader().open(source, std::numeric_limits<size_t>::max(), sink);
}

std::shared_ptr<const Texture> load_texture(const TextureSource& source, const ColorConfig& colors,
                                            const DiagnosticSink& sink, size_t max_pixels) {
  try {
    ImageReader reader;
    if (!reader.open(source, max_pixels, sink)) return nullptr;
    const std::string space =
        source.color_space == "auto" && reader.layout().low_precision ? "sRGB" : source.color_space;
    const auto transform = colors.to_rendering_space(space, [&](const Diagnostic& d) {
      report(sink, d.severity, d.code, source.path, "colour space of the image: " + d.text);
    });
    if (!transform) return nullptr;

    // Memory is reserved at once but touched only as rows arrive: a small file that claims to be huge costs nothing.
    const ImageLayout& layout = reader.layout();
    std::vector<half> texels;
    texels.reserve(3 * size_t(layout.width) * size_t(layout.height));
    AlphaPlane alpha;
    std::vector<float> pixels, rgba;
    for (int y = 0; y < layout.height;) {
      const int rows = reader.read_rows(y, pixels, sink);
      if (rows == 0) return nullptr;
      alpha.add(pixels, layout);
      to_rgba(pixels, layout, rgba);
      transform->apply(rgba.data(), rgba.size() / 4);
      for (size_t i = 0; i < rgba.size(); ++i)
        if (i % 4 < 3) texels.emplace_back(std::clamp(rgba[i], -kLargestHalf, kLargestHalf));
      y += rows;
    }
    return std::make_shared<HalfTexture>(Vec2i(layout.width, layout.height), std::move(texels), alpha.take(), source);
  } catch (const std::bad_alloc&) {
    report(sink, Severity::error, "texture.memory", source.path, "not enough memory for this image; make it smaller");
  } catch (const std::exception& e) {
    report(sink, Severity::error, "texture.unreadable", source.path,
           std::string(e.what()) + "; export the image again");
  }
  return nullptr;
}

}  // namespace alabaster
