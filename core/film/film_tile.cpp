#include "core/film/film_tile.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace alabaster {
namespace {

void accumulate(const std::array<float, 3>& value, std::array<UnitSum, 3>* sum) {
  for (size_t i = 0; i < 3; ++i) (*sum)[i].add(value[i]);
}

constexpr float kFar = std::numeric_limits<float>::infinity();

constexpr struct {
  Aov aov;
  float FilmSample::*member;
} kDepths[] = {{Aov::depth, &FilmSample::depth},
               {Aov::camera_depth, &FilmSample::camera_depth},
               {Aov::camera_distance, &FilmSample::camera_distance}};
constexpr struct {
  Aov aov;
  int32_t FilmSample::*member;
} kIds[] = {{Aov::prim_id, &FilmSample::prim_id},
            {Aov::instance_id, &FilmSample::instance_id},
            {Aov::element_id, &FilmSample::element_id},
            {Aov::material_id, &FilmSample::material_id}};

constexpr struct {
  Aov aov;
  Rgb (*light)(const LightLayers&);
} kLayers[] = {
    {Aov::diffuse, [](const LightLayers& l) { return l.diffuse(); }},
    {Aov::subsurface, [](const LightLayers& l) { return l.subsurface(); }},
    {Aov::subsurface_single, [](const LightLayers& l) { return l.single(); }},
    {Aov::subsurface_multiple, [](const LightLayers& l) { return l.multiple(); }},
    {Aov::subsurface_unscattered, [](const LightLayers& l) { return l.unscattered(); }},
    {Aov::specular, [](const LightLayers& l) { return l.specular(); }},
    {Aov::emission, [](const LightLayers& l) { return l[LightLayers::kSeen]; }},
    {Aov::direct_diffuse, [](const LightLayers& l) { return l[LightLayers::kDirectDiffuse]; }},
    {Aov::indirect_diffuse, [](const LightLayers& l) { return l[LightLayers::kIndirectDiffuse]; }},
    {Aov::direct_subsurface, [](const LightLayers& l) { return l.direct_subsurface(); }},
    {Aov::indirect_subsurface, [](const LightLayers& l) { return l.indirect_subsurface(); }},
    {Aov::direct_specular, [](const LightLayers& l) { return l[LightLayers::kDirectSpecular]; }},
    {Aov::indirect_specular, [](const LightLayers& l) { return l[LightLayers::kIndirectSpecular]; }},
    {Aov::transmission, [](const LightLayers& l) { return l[LightLayers::kTransmission]; }},
};

template <class Table>
constexpr AovSet aovs_of(const Table& table) {
  AovSet aovs = 0;
  for (const auto& row : table) aovs |= aov_bit(row.aov);
  return aovs;
}
static_assert(aovs_of(kLayers) == kLayerAovs, "a layer has no row");
static_assert((aovs_of(kDepths) | aovs_of(kIds) | kVectorAovs) == kClosestAovs, "a value of the first hit has no row");

template <class T>
T background(Aov aov) {
  return static_cast<T>(aov_info(aov).background);
}

template <class Table, class Plane>
void add_planes(const Table& table, AovSet aovs, size_t pixels, std::vector<Plane>* planes) {
  using T = typename decltype(Plane::values)::value_type;
  for (const auto& [aov, member] : table)
    if (aovs & aov_bit(aov)) planes->push_back({aov, member, std::vector<T>(pixels, background<T>(aov))});
}

// The plane of an AOV, or null.
template <class Plane>
const Plane* find_plane(const std::vector<Plane>& planes, Aov aov) {
  for (const Plane& plane : planes)
    if (plane.aov == aov) return &plane;
  return nullptr;
}

template <class Plane>
void append_plane(const Plane& from, Plane* to) {
  for (size_t i = 0; i < to->size(); ++i) {
    if constexpr (requires { (*to)[i].add(from[i]); })
      (*to)[i].add(from[i]);
    else
      for (size_t c = 0; c < 3; ++c) (*to)[i][c].add(from[i][c]);
  }
}

}  // namespace

FilmTile::FilmTile(size_t pixels, AovSet aovs, const FilmExtras& extras)
    : begin_(extras.range.begin),
      marks_per_pixel_(count_marks(extras.range)),
      samples_(pixels, 0),
      color_(pixels),
      alpha_(pixels),
      halves_(pixels),
      marks_(pixels * marks_per_pixel_) {
  if (aovs & aov_bit(Aov::normal)) normal_.resize(pixels);
  if (aovs & aov_bit(Aov::albedo)) albedo_.resize(pixels);
  if (aovs & aov_bit(Aov::ambient_occlusion)) ambient_occlusion_.resize(pixels);
  if (aovs & aov_bit(Aov::shadow)) caught_.resize(pixels), shadowed_.resize(pixels), unshadowed_.resize(pixels);
  if (aovs & kClosestAovs) distance_.assign(pixels, kFar);
  add_planes(kDepths, aovs, pixels, &depths_);
  add_planes(kIds, aovs, pixels, &ids_);
  if (aovs & aov_bit(Aov::nonfinite)) nonfinite_.resize(pixels);
  for (const auto& [aov, light] : kLayers)
    if (aovs & aov_bit(aov)) layers_.push_back({aov, light, std::vector<RgbSum>(pixels)});
  light_groups_.resize(extras.light_groups, std::vector<RgbSum>(pixels));
  for (auto a = static_cast<size_t>(Aov::eye_point); a < kAovCount; ++a)
    if (const Aov aov = static_cast<Aov>(a); aovs & kVectorAovs & aov_bit(aov))
      vectors_.push_back({aov, std::vector<std::array<float, 3>>(pixels)});
  if (aovs & kPrimCountAovs) prims_.resize(pixels);
  if (aovs & aov_bit(Aov::crypto_material)) materials_.resize(pixels);
  if (extras.rays) rays_.resize(pixels);
}

void FilmTile::clear() {
  covered_ = 0;
  const auto blank = [](auto& plane) {
    std::fill(plane.begin(), plane.end(), typename std::decay_t<decltype(plane)>::value_type{});
  };
  blank(samples_), blank(color_), blank(alpha_), blank(normal_), blank(albedo_), blank(halves_), blank(rays_);
  blank(ambient_occlusion_), blank(caught_), blank(shadowed_), blank(unshadowed_), blank(nonfinite_), blank(marks_);
  std::fill(distance_.begin(), distance_.end(), kFar);
  for (auto& plane : depths_) std::fill(plane.values.begin(), plane.values.end(), background<float>(plane.aov));
  for (auto& plane : ids_) std::fill(plane.values.begin(), plane.values.end(), background<int32_t>(plane.aov));
  for (LayerPlane& layer : layers_) blank(layer.sums);
  for (auto& sums : light_groups_) blank(sums);
  for (VectorPlane& plane : vectors_) blank(plane.closest);
  prims_.clear(), materials_.clear();
}

uint32_t FilmTile::least_samples() const {
  return empty() ? 0 : *std::min_element(samples_.begin(), samples_.end());
}

uint32_t FilmTile::most_samples() const {
  return empty() ? 0 : *std::max_element(samples_.begin(), samples_.end());
}

size_t FilmTile::count_marks(const SampleRange& range) {
  if (range.begin == 0 || range.end <= range.begin) return 0;
  return std::min(kMostMarks, static_cast<size_t>(std::bit_width(range.end) - std::bit_width(range.begin)));
}

std::vector<std::span<std::byte>> FilmTile::planes() {
  std::vector<std::span<std::byte>> all;
  const auto add = [&all](auto& plane) {
    if (!plane.empty()) all.push_back(std::as_writable_bytes(std::span(plane)));
  };
  add(samples_);
  add(color_);
  add(alpha_);
  add(halves_);
  add(normal_);
  add(albedo_);
  add(ambient_occlusion_);
  add(caught_);
  add(shadowed_);
  add(unshadowed_);
  add(distance_);
  for (auto& plane : depths_) add(plane.values);
  for (auto& plane : ids_) add(plane.values);
  for (LayerPlane& layer : layers_) add(layer.sums);
  for (auto& sums : light_groups_) add(sums);
  for (VectorPlane& plane : vectors_) add(plane.closest);
  add(rays_);
  add(nonfinite_);
  add(marks_);
  return all;
}

std::vector<IdCounts*> FilmTile::ids() {
  std::vector<IdCounts*> all;
  for (IdCounts* counts : {&prims_, &materials_})
    if (!counts->empty()) all.push_back(counts);
  return all;
}

bool FilmTile::accept_planes() {
  covered_ = samples_.size() - static_cast<size_t>(std::count(samples_.begin(), samples_.end(), 0u));
  const auto valid = [](const std::vector<RgbSum>& sums) {
    return std::all_of(sums.begin(), sums.end(), [](const RgbSum& sum) { return sum.is_valid(); });
  };
  return valid(color_) && valid(marks_) && valid(shadowed_) && valid(unshadowed_) &&
         std::all_of(layers_.begin(), layers_.end(), [&](const LayerPlane& layer) { return valid(layer.sums); }) &&
         std::all_of(light_groups_.begin(), light_groups_.end(), valid) &&
         std::all_of(samples_.begin(), samples_.end(), [](uint32_t n) { return n <= kMostSummedSamples; });
}

size_t FilmTile::bytes_per_pixel(AovSet aovs, const FilmExtras& extras) {
  FilmTile one(1, aovs, extras);
  size_t bytes = 0;
  for (const auto& plane : one.planes()) bytes += plane.size();
  return bytes + one.ids().size() * IdCounts::bytes_per_pixel();
}

void FilmTile::add(size_t pixel, const FilmSample& s, const LightLayers* layers, uint32_t rays) {
  const uint32_t samples = ++samples_[pixel];
  if (samples == 1) ++covered_;
  color_[pixel].add(s.color);
  alpha_[pixel].add(s.alpha);
  if (s.is_caught && !caught_.empty()) [[unlikely]] {
    ++caught_[pixel];
    shadowed_[pixel].add(s.shadowed);
    unshadowed_[pixel].add(s.unshadowed);
  }
  if (std::has_single_bit(samples)) compare_halves(pixel);
  if (marks_per_pixel_ > 0 && std::has_single_bit(begin_ + samples))
    marks_[mark(pixel, begin_ + samples)] = light_sum(pixel);
  if (!normal_.empty()) accumulate({s.normal.x, s.normal.y, s.normal.z}, &normal_[pixel]);
  if (!albedo_.empty()) accumulate({s.albedo.r, s.albedo.g, s.albedo.b}, &albedo_[pixel]);
  if (!ambient_occlusion_.empty()) ambient_occlusion_[pixel].add(s.ambient_occlusion);
  if (layers)
    for (LayerPlane& plane : layers_) plane.sums[pixel].add(plane.light(*layers));
  if (s.light_groups)
    for (size_t group = 0; group < light_groups_.size(); ++group)
      light_groups_[group][pixel].add(s.light_groups[group]);
  if (!rays_.empty()) rays_[pixel] += rays;
  if (!nonfinite_.empty() && s.nonfinite) ++nonfinite_[pixel];
  if (!distance_.empty() && s.distance < distance_[pixel]) {
    distance_[pixel] = s.distance;
    for (auto& plane : depths_) plane.values[pixel] = s.*plane.member;
    for (auto& plane : ids_) plane.values[pixel] = s.*plane.member;
    if (s.vectors)
      for (VectorPlane& plane : vectors_) plane.closest[pixel] = s.vectors->of(plane.aov);
  }
  if (s.is_held_out) return;
  if (!prims_.empty() && s.matte >= 0) prims_.add(pixel, s.matte);
  if (!materials_.empty() && s.material_id >= 0) materials_.add(pixel, s.material_id);
}

void FilmTile::append(const FilmTile& next) {
  for (size_t pixel = 0; pixel < samples_.size(); ++pixel) {
    append_halves(pixel, next);
    samples_[pixel] += next.samples_[pixel];
    if (!distance_.empty() && next.distance_[pixel] < distance_[pixel]) take_closest(pixel, next);
    if (!rays_.empty()) rays_[pixel] += next.rays_[pixel];
    if (!caught_.empty()) caught_[pixel] += next.caught_[pixel];
    if (!nonfinite_.empty()) nonfinite_[pixel] += next.nonfinite_[pixel];
  }
  append_plane(next.color_, &color_);
  append_plane(next.alpha_, &alpha_);
  append_plane(next.normal_, &normal_);
  append_plane(next.albedo_, &albedo_);
  append_plane(next.ambient_occlusion_, &ambient_occlusion_);
  append_plane(next.shadowed_, &shadowed_);
  append_plane(next.unshadowed_, &unshadowed_);
  for (size_t i = 0; i < layers_.size(); ++i) append_plane(next.layers_[i].sums, &layers_[i].sums);
  for (size_t i = 0; i < light_groups_.size(); ++i) append_plane(next.light_groups_[i], &light_groups_[i]);
  prims_.append(next.prims_), materials_.append(next.materials_);
}

void FilmTile::take_closest(size_t pixel, const FilmTile& from) {
  if (!distance_.empty()) distance_[pixel] = from.distance_[pixel];
  for (size_t i = 0; i < depths_.size(); ++i) depths_[i].values[pixel] = from.depths_[i].values[pixel];
  for (size_t i = 0; i < ids_.size(); ++i) ids_[i].values[pixel] = from.ids_[i].values[pixel];
  for (size_t i = 0; i < vectors_.size(); ++i) vectors_[i].closest[pixel] = from.vectors_[i].closest[pixel];
}

// Compares the halves at each power of two that the part reaches, as if its samples came one by one.
void FilmTile::append_halves(size_t pixel, const FilmTile& next) {
  if (next.marks_per_pixel_ == 0) return;
  const uint32_t samples = samples_[pixel];
  const RgbSum color = color_[pixel];
  const uint32_t last = std::bit_floor(samples + next.samples_[pixel]);
  const auto known =
      std::min(next.marks_per_pixel_, static_cast<size_t>(std::bit_width(last) - std::bit_width(samples)));
  for (size_t before = known; before-- > 0;) {
    samples_[pixel] = last >> before;
    color_[pixel].add(next.marks_[next.mark(pixel, last >> before)]);
    compare_halves(pixel);
    color_[pixel] = color;
  }
  samples_[pixel] = samples;
}

namespace {

// Difference between the means of the `first` samples and of the `rest`: the root of its mean square over red, green
// and blue.
float mean_difference(const std::array<double, 3>& all, const std::array<float, 3>& some, double first, double rest) {
  double squares = 0;
  for (size_t c = 0; c < 3; ++c) {
    const double difference = some[c] / first - (all[c] - some[c]) / rest;
    squares += difference * difference / 3;
  }
  return static_cast<float>(std::sqrt(squares));
}

}  // namespace

RgbSum FilmTile::light_sum(size_t pixel) const {
  RgbSum sum = color_[pixel];
  if (!shadowed_.empty()) sum.add(shadowed_[pixel]);
  return sum;
}

namespace {

// The share of the unshadowed light that does not arrive. The sums are those of the same samples, so that it is exact
// where nothing casts a shadow, or all.
double shadow_of(double shadowed, double unshadowed) {
  return unshadowed > 0 ? 1 - std::clamp(shadowed / unshadowed, 0.0, 1.0) : 0;
}

}  // namespace

// The sum over the pixel's samples.
double FilmTile::shadow_alpha(size_t pixel) const {
  if (caught_.empty() || caught_[pixel] == 0) return 0;
  const auto some = shadowed_[pixel].value(), all = unshadowed_[pixel].value();
  return caught_[pixel] * shadow_of(some[0] + some[1] + some[2], all[0] + all[1] + all[2]);
}

// The pixel has just reached a power of two.
void FilmTile::compare_halves(size_t pixel) {
  Halves& h = halves_[pixel];
  const auto sums = light_sum(pixel).value();
  const uint32_t n = samples_[pixel];
  if (n > 1) {
    h.earlier = h.previous;
    h.previous = h.latest;
    h.latest = mean_difference(sums, h.first, n / 2, n / 2);
  }
  h.first = {static_cast<float>(sums[0]), static_cast<float>(sums[1]), static_cast<float>(sums[2])};
}

PixelNoise FilmTile::noise(size_t pixel) const {
  const uint32_t n = samples_[pixel];
  if (n == 0) return {};
  const auto sums = light_sum(pixel).value();
  const Halves& h = halves_[pixel];
  const uint32_t m = std::bit_floor(n);
  return {n,         static_cast<float>((sums[0] + sums[1] + sums[2]) / (3.0 * n)), h.latest, h.previous,
          h.earlier, n > m ? mean_difference(sums, h.first, m, n - m) : 0.0f};
}

void FilmTile::take(size_t pixel, const FilmTile& from) {
  covered_ += size_t(from.samples_[pixel] > 0) - size_t(samples_[pixel] > 0);
  samples_[pixel] = from.samples_[pixel];
  color_[pixel] = from.color_[pixel];
  alpha_[pixel] = from.alpha_[pixel];
  halves_[pixel] = from.halves_[pixel];
  if (!normal_.empty()) normal_[pixel] = from.normal_[pixel];
  if (!albedo_.empty()) albedo_[pixel] = from.albedo_[pixel];
  if (!ambient_occlusion_.empty()) ambient_occlusion_[pixel] = from.ambient_occlusion_[pixel];
  if (!caught_.empty()) {
    caught_[pixel] = from.caught_[pixel];
    shadowed_[pixel] = from.shadowed_[pixel];
    unshadowed_[pixel] = from.unshadowed_[pixel];
  }
  take_closest(pixel, from);
  if (!rays_.empty()) rays_[pixel] = from.rays_[pixel];
  if (!nonfinite_.empty()) nonfinite_[pixel] = from.nonfinite_[pixel];
  for (size_t i = 0; i < layers_.size(); ++i) layers_[i].sums[pixel] = from.layers_[i].sums[pixel];
  for (size_t i = 0; i < light_groups_.size(); ++i) light_groups_[i][pixel] = from.light_groups_[i][pixel];
  if (!prims_.empty()) prims_.take(pixel, from.prims_);
  if (!materials_.empty()) materials_.take(pixel, from.materials_);
  for (size_t i = pixel * marks_per_pixel_; i < (pixel + 1) * marks_per_pixel_; ++i) marks_[i] = from.marks_[i];
}

namespace {

void average(const RgbSum& sum, double scale, float* out) {
  const auto sums = sum.value();
  for (size_t i = 0; i < 3; ++i) out[i] = static_cast<float>(sums[i] * scale);
}

void average(const UnitSum& sum, double scale, float* out) {
  *out = static_cast<float>(sum.value() * scale);
}

void average(const std::array<UnitSum, 3>& sums, double scale, float* out) {
  for (size_t i = 0; i < 3; ++i) out[i] = static_cast<float>(sums[i].value() * scale);
}

}  // namespace

namespace {

// Asks for a sum that the next rows need: processors look ahead within a page of memory, which is 51 sums of color.
template <class Sums>
void look_ahead(const Sums& sums, size_t pixel) {
  constexpr size_t kAhead = 64;
  __builtin_prefetch(sums.data() + std::min(pixel + kAhead, sums.size() - 1));
}

}  // namespace

void FilmTile::resolve(size_t pixel, Aov aov, float* out, size_t count) const {
  const auto components = static_cast<size_t>(aov_info(aov).components());
  const auto each = [&](const auto& write) {
    for (size_t i = pixel; i < pixel + count; ++i, out += components)
      write(i, samples_[i] > 0 ? 1.0 / samples_[i] : 0.0, out);
  };
  const auto each_average = [&](const auto& sums) {
    if (sums.empty())
      std::fill_n(out, components * count, 0.0f);
    else
      each([&](size_t i, double scale, float* to) {
        look_ahead(sums, i);
        average(sums[i], scale, to);
      });
  };
  switch (aov) {
    case Aov::color:
      return each([&](size_t i, double scale, float* to) {
        look_ahead(color_, i);
        average(color_[i], scale, to);
        to[3] = static_cast<float>((alpha_[i].value() + shadow_alpha(i)) * scale);
      });
    case Aov::alpha:
      return each([&](size_t i, double scale, float* to) {
        *to = static_cast<float>((alpha_[i].value() + shadow_alpha(i)) * scale);
      });
    case Aov::shadow:
      return each([&](size_t i, double scale, float* to) {
        for (size_t c = 0; c < 3; ++c)
          to[c] = caught_.empty() ? 0
                                  : static_cast<float>(caught_[i] * scale *
                                                       shadow_of(shadowed_[i].value()[c], unshadowed_[i].value()[c]));
      });
    case Aov::error:
      return each([&](size_t i, double, float* to) { *to = noise(i).deviation(); });
    case Aov::normal:
      return each_average(normal_);
    case Aov::albedo:
      return each_average(albedo_);
    case Aov::ambient_occlusion:
      return each_average(ambient_occlusion_);
    default:
      if (const auto* layer = find_plane(layers_, aov)) return each_average(layer->sums);
      if (const auto* depth = find_plane(depths_, aov)) {
        std::copy_n(depth->values.data() + pixel, count, out);
        return;
      }
      if (const auto* vector = find_plane(vectors_, aov))
        return each([&](size_t i, double, float* to) { std::copy_n(vector->closest[i].begin(), components, to); });
      std::fill_n(out, components * count, background<float>(aov));
  }
}

void FilmTile::resolve_light_group(size_t pixel, size_t group, float* out, size_t count) const {
  for (size_t i = pixel; i < pixel + count; ++i, out += 3) {
    if (group >= light_groups_.size() || samples_[i] == 0) {
      std::fill_n(out, 3, 0.0f);
      continue;
    }
    look_ahead(light_groups_[group], i);
    average(light_groups_[group][i], 1.0 / samples_[i], out);
  }
}

void FilmTile::resolve_ranks(size_t pixel, Aov aov, int pair, const IdKeys& keys, float* out, size_t count) const {
  const IdCounts& counts = aov == Aov::crypto_material ? materials_ : prims_;
  if (counts.empty())
    std::fill_n(out, 4 * count, 0.0f);
  else
    counts.rank(pixel, count, pair, keys.of(aov), samples_, out);
}

void FilmTile::resolve_int(size_t pixel, Aov aov, int32_t* out, size_t count) const {
  if (aov == Aov::sample_count || aov == Aov::nonfinite) {
    const std::vector<uint32_t>& counts = aov == Aov::nonfinite ? nonfinite_ : samples_;
    for (size_t i = 0; i < count; ++i) out[i] = counts.empty() ? 0 : static_cast<int32_t>(counts[pixel + i]);
  } else if (const auto* ids = find_plane(ids_, aov)) {
    std::copy_n(ids->values.data() + pixel, count, out);
  } else {
    std::fill_n(out, count, background<int32_t>(aov));
  }
}

}  // namespace alabaster
