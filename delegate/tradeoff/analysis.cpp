#include "delegate/tradeoff/analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "delegate/tradeoff/flip.h"
#include "delegate/tradeoff/pareto.h"
#include "delegate/tradeoff/study.h"

namespace alabaster::tradeoff {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct DisplayError {
  double rmse = kUnknown, flip = kUnknown;
};

/// The row's noise^2 with the uncertainty of its CPU seconds.
Estimate work_of(const Row& row, double timing_error) {
  const double noise = row.squared_noise.value, seconds = timing_error / std::sqrt(double(row.replicas));
  const double error = std::hypot(row.squared_noise.standard_error, noise * seconds);
  constexpr double kNormal95 = 1.959964;
  return {noise, std::max(0.0, noise - kNormal95 * error), noise + kNormal95 * error, error};
}

struct TileWindow {
  int x = 0, y = 0, width = 0, height = 0;
};

/// About a third of the frame each way, where the pictures differ most from the first.
TileWindow busiest_window(std::span<const Tile> tiles) {
  const Image& first = tiles.front().pixels;
  TileWindow best{0, 0, std::min(first.width, std::max(24, first.width / 3)),
                  std::min(first.height, std::max(24, first.height / 3))};
  std::vector<double> differences(first.pixels(), 0.0);
  for (const Tile& tile : tiles)
    for (size_t i = 0; i < first.rgb.size(); ++i)
      differences[i / 3] += std::abs(double(tile.pixels.rgb[i]) - double(first.rgb[i]));
  double most = -1;
  const int step = std::max(1, std::min(best.width, best.height) / 4);
  for (int y = 0; y + best.height <= first.height; y += step)
    for (int x = 0; x + best.width <= first.width; x += step) {
      double sum = 0;
      for (int row = y; row < y + best.height; ++row)
        for (int column = x; column < x + best.width; ++column)
          sum += differences[static_cast<size_t>(row) * static_cast<size_t>(first.width) + static_cast<size_t>(column)];
      if (sum > most) most = sum, best.x = x, best.y = y;
    }
  return best;
}

Image cut(const Image& image, const TileWindow& window) {
  Image part{window.width, window.height, {}};
  for (int y = window.y; y < window.y + window.height; ++y) {
    const auto begin = image.rgb.begin() + 3 * (std::ptrdiff_t(y) * image.width + window.x);
    part.rgb.insert(part.rgb.end(), begin, begin + 3 * std::ptrdiff_t(window.width));
  }
  return part;
}

/// Holds one configuration's pictures in memory at a time, besides the reference's mean.
class Analysis {
 public:
  Analysis(const StudyStore& store, const ConfigurationList& list, const DisplayFunction& display)
      : store_(store), list_(list), display_(display) {}

  bool run(StudyResult* result, std::string* problem) {
    if (!take_reference(result, problem)) return false;
    size_t last = 0;
    for (const bool denoised : {false, true}) {
      for (size_t c = 0; c < list_.measured.size(); ++c)
        if (!add_rows(static_cast<int>(c), denoised, result, problem)) return false;
      if (!denoised) result->timing_error = timing_error();
      const size_t first = std::exchange(last, result->rows.size());
      mark_front(std::span(result->rows).subspan(first), result->timing_error, like_the_base(*result));
    }
    return add_tiles(result, problem);
  }

 private:
  using BySamples = std::map<uint64_t, std::vector<const StoredRender*>>;

  BySamples renders_of(int configuration) const {
    BySamples renders;
    for (const StoredRender& render : store_.renders())
      if (find_configuration(list_, render) == configuration) renders[render.samples].push_back(&render);
    for (auto& [samples, replicas] : renders)  // sums must not depend on the order of rendering
      std::sort(replicas.begin(), replicas.end(),
                [](const StoredRender* a, const StoredRender* b) { return a->replica < b->replica; });
    return renders;
  }

  bool read(const std::vector<const StoredRender*>& renders, bool denoised, std::vector<Image>* images,
            std::string* problem) const {
    images->clear();
    for (const StoredRender* render : renders) {
      auto image = denoised ? store_.read_denoised(*render) : store_.read(*render);
      if (!image) {
        *problem = (denoised ? render->denoised_file : render->file) +
                   " is missing or damaged: run the command again to render it again.";
        return false;
      }
      images->push_back(std::move(*image));
    }
    return true;
  }

  bool take_reference(StudyResult* result, std::string* problem) {
    const BySamples renders = renders_of(kReference);
    const auto found = renders.find(store_.reference_samples);
    if (found == renders.end() || found->second.size() < 2) {
      *problem = "The reference has not been rendered twice yet: give it more time with --budget.";
      return false;
    }
    std::vector<Image> images;
    if (!read(found->second, false, &images, problem)) return false;
    ReferenceSummary& summary = result->reference;
    summary.samples = found->first;
    summary.replicas = static_cast<int>(images.size());
    for (const StoredRender* render : found->second) summary.cpu_seconds += render->cost.cpu_seconds;
    const Image mean = mean_image(images);
    scales_ = squared_scales(mean);
    if (scales_.empty()) {
      *problem =
          "The reference is black, so no error can be relative to it. Check that light reaches the visible surfaces.";
      return false;
    }
    ReplicaGroup group(found->first);
    for (const Image& image : images) group.add(image);
    reference_ = pool({&group, 1});
    summary.noise = std::sqrt(squared_noise(group, scales_).value / summary.replicas);
    displayed_ = display_(mean);
    const size_t half = images.size() / 2;
    if (displayed_) {
      const auto first = display_(mean_image(std::span(images).first(half)));
      const auto second = display_(mean_image(std::span(images).subspan(half, half)));
      if (first && second) {
        summary.display_rmse = rmse(*first, *second);
        summary.flip = flip_difference(*first, *second).mean;
      }
    }
    return true;
  }

  DisplayError display_error(const std::vector<Image>& images) const {
    if (!displayed_) return {};
    DisplayError sum{0, 0};
    for (const Image& image : images) {
      const auto shown = display_(image);
      if (!shown) return {};
      sum.rmse += rmse(*shown, *displayed_) / double(images.size());
      sum.flip += flip_difference(*displayed_, *shown).mean / double(images.size());
    }
    return sum;
  }

  bool add_rows(int c, bool denoised, StudyResult* result, std::string* problem) const {
    std::vector<ReplicaGroup> groups;
    const size_t first = result->rows.size();
    for (auto& [samples, renders] : renders_of(c)) {
      if (denoised) std::erase_if(renders, [](const StoredRender* render) { return render->denoised_file.empty(); });
      if (renders.size() < 2) continue;
      std::vector<Image> images;
      if (!read(renders, denoised, &images, problem)) return false;
      ReplicaGroup& group = groups.emplace_back(samples);
      for (const Image& image : images) group.add(image);
      result->rows.push_back(row_of(list_.measured[static_cast<size_t>(c)], denoised, renders, images, group));
    }
    const std::span<Row> rows = std::span(result->rows).subspan(first);
    if (denoised)
      for (size_t i = 0; i < rows.size(); ++i) set_bias(std::span(groups).subspan(i, 1), true, rows.subspan(i, 1));
    else if (!groups.empty())
      set_bias(groups, false, rows);
    return true;
  }

  PixelBlocks blocks(bool denoised) const {
    return denoised ? PixelBlocks{store_.identity.width, kDenoisedBlock} : PixelBlocks{};
  }

  /// Sets the bias of the mean of all `groups` in all `rows`.
  void set_bias(std::span<const ReplicaGroup> groups, bool denoised, std::span<Row> rows) const {
    const PooledMean pooled = pool(groups);
    const Estimate bias = squared_bias(pooled, reference_, scales_, blocks(denoised));
    const Estimate level = mean_level_bias(pooled, reference_, blocks(denoised));
    for (Row& row : rows) {
      row.squared_bias = bias;
      row.level_bias = level;
      const Estimate squared = squared_error_at({0, 1, row.squared_noise, bias}, 1);
      row.total = {std::sqrt(squared.value), std::sqrt(squared.low), std::sqrt(squared.high), 0};
    }
  }

  Row row_of(const Configuration& configuration, bool denoised, const std::vector<const StoredRender*>& renders,
             const std::vector<Image>& images, const ReplicaGroup& group) const {
    Row row;
    row.configuration = configuration.name + (denoised ? std::string(" ") + kDenoised : "");
    row.group = denoised ? kDenoised : configuration.group;
    row.denoised = denoised;
    row.samples = group.samples();
    row.replicas = group.count();
    const auto n = double(renders.size());
    double reported = 0;
    row.cpu_seconds = std::numeric_limits<double>::infinity();
    for (const StoredRender* render : renders) {
      row.cpu_seconds = std::min(row.cpu_seconds, render->cost.cpu_seconds);
      row.wall_seconds += render->cost.wall_seconds / n;
      if (denoised) {
        row.denoise_cpu_seconds += render->cost.denoise_cpu_seconds / n;
        row.wall_seconds += render->cost.denoise_wall_seconds / n;
      }
      const double error = render->cost.reported_error;
      reported += error < 0 ? kUnknown : error * error / n;
    }
    row.cpu_seconds += row.denoise_cpu_seconds;
    row.reported_error = std::sqrt(reported);
    row.squared_noise = squared_noise(group, scales_, blocks(denoised));
    const DisplayError error = display_error(images);
    row.display_rmse = error.rmse;
    row.flip = error.flip;
    return row;
  }

  /// From pairs of replicas, of renders that take long enough to be timed.
  double timing_error() const {
    constexpr double kLeastSeconds = 0.02;
    std::map<std::pair<std::string, uint64_t>, std::vector<double>> seconds;
    for (const StoredRender& render : store_.renders())
      if (render.cost.cpu_seconds > kLeastSeconds)
        seconds[{render.fingerprint, render.samples}].push_back(render.cost.cpu_seconds);
    double squares = 0, degrees = 0;
    for (const auto& [key, all] : seconds) {
      double mean = 0;
      for (const double s : all) mean += s / double(all.size());
      for (const double s : all) squares += (s / mean - 1) * (s / mean - 1);
      degrees += double(all.size() - 1);
    }
    constexpr double kUnmeasured = 0.1;
    return degrees > 0 ? std::sqrt(squares / degrees) : kUnmeasured;
  }

  /// The configurations without a measurable effect.
  static std::set<std::string> like_the_base(const StudyResult& result) {
    std::set<std::string> names;
    for (const ConfigurationSummary& summary : summarize(result))
      if (!summary.has_effect && summary.best->group != "base") names.insert(summary.best->configuration);
    return names;
  }

  /// The base stands for those of `like_base`: by chance one of them may be better at one place.
  static void mark_front(std::span<Row> rows, double timing_error, const std::set<std::string>& like_base) {
    std::vector<CurvePoint> points;
    std::vector<Row*> compared;
    size_t configuration = 0;
    for (Row& row : rows) {
      if (like_base.contains(row.configuration)) continue;
      if (!compared.empty() && row.configuration != compared.back()->configuration) ++configuration;
      points.push_back({configuration, row.cpu_seconds, work_of(row, timing_error), row.squared_bias});
      compared.push_back(&row);
    }
    const std::vector<bool> front = on_front(points);
    for (size_t i = 0; i < compared.size(); ++i) compared[i]->pareto = front[i];
  }

  /// The pictures of one replica each, cut to the part that differs most between configurations.
  bool add_tiles(StudyResult* result, std::string* problem) const {
    if (!displayed_) return true;
    std::vector<Tile> whole{{"reference", 0, *displayed_}};
    std::vector<ConfigurationSummary> shown = summarize(*result);
    std::erase_if(shown, [](const auto& s) { return s.best->group != "base" && !s.has_effect; });
    uint64_t common = shown.empty() ? 1 : shown.front().best->samples;  // where every one has rows
    for (const ConfigurationSummary& summary : shown)
      if (summary.compared_at > 0) common = std::min(common, summary.compared_at);
    for (const ConfigurationSummary& summary : shown) {
      const std::string& name = summary.best->configuration;
      const bool has_common = std::any_of(result->rows.begin(), result->rows.end(), [&](const Row& row) {
        return row.configuration == name && row.samples == common;
      });
      if (!add_tile(name, has_common ? common : summary.best->samples, false, &whole, problem)) return false;
    }
    if (!add_tile(list_.measured.front().name, common, true, &whole, problem)) return false;
    const TileWindow window = busiest_window(whole);
    for (Tile& tile : whole) tile.pixels = cut(tile.pixels, window);
    if (whole.size() > 1) result->tiles = std::move(whole);
    return true;
  }

  bool add_tile(const std::string& name, uint64_t samples, bool denoised, std::vector<Tile>* tiles,
                std::string* problem) const {
    for (const StoredRender& render : store_.renders()) {
      const auto found = find_configuration(list_, render);
      if (!found || *found == kReference || render.configuration != name || render.samples != samples) continue;
      if (denoised && render.denoised_file.empty()) continue;
      std::vector<Image> image;
      if (!read({&render}, denoised, &image, problem)) return false;
      if (auto shown = display_(image[0]))
        tiles->push_back({name + (denoised ? std::string(" ") + kDenoised : ""), samples, std::move(*shown)});
      return true;
    }
    return true;
  }

  const StudyStore& store_;
  const ConfigurationList& list_;
  const DisplayFunction& display_;
  PooledMean reference_;
  std::vector<double> scales_;
  std::optional<Image> displayed_;  // the reference's mean
};

}  // namespace

std::optional<StudyResult> analyse(const StudyStore& store, const ConfigurationList& list,
                                   const DisplayFunction& display, std::string* problem) {
  StudyResult result;
  if (!Analysis(store, list, display).run(&result, problem)) return std::nullopt;
  return result;
}

namespace {

/// The ratio of the row's noise^2 x CPU seconds to the base's.
Estimate cost_ratio(const Row& row, const Row& base, double timing_error) {
  const Estimate own = work_of(row, timing_error), other = work_of(base, timing_error);
  const double ratio = own.value * row.cpu_seconds / (other.value * base.cpu_seconds);
  const double sigma = std::hypot(own.standard_error / own.value, other.standard_error / other.value);
  constexpr double kNormal95 = 1.959964;
  return {ratio, ratio * std::exp(-kNormal95 * sigma), ratio * std::exp(kNormal95 * sigma), ratio * sigma};
}

/// The cost beyond its interval and by more than a twentieth, or a bias, or a level other than the base's by four
/// standard errors: the base has the same reference, whose noise is in both.
bool has_effect(const ConfigurationSummary& summary, const Row& base) {
  const Row& row = *summary.best;
  const Estimate& cost = summary.cost_ratio;
  if ((cost.low > 1 || cost.high < 1) && std::abs(std::log(cost.value)) > std::log(1.05)) return true;
  if (is_certain(row.squared_bias) && row.squared_bias.value > base.squared_bias.high) return true;
  if (!std::isfinite(cost.value)) return true;  // not compared
  const double level = row.level_bias.value - base.level_bias.value;
  return row.samples == base.samples &&
         std::abs(level) > 4 * std::hypot(row.level_bias.standard_error, base.level_bias.standard_error);
}

}  // namespace

std::vector<ConfigurationSummary> summarize(const StudyResult& result) {
  std::map<uint64_t, const Row*> base;
  for (const Row& row : result.rows)
    if (row.group == "base") base[row.samples] = &row;
  std::vector<ConfigurationSummary> summaries;
  for (const Row& row : result.rows) {
    if (row.denoised) continue;
    if (summaries.empty() || summaries.back().best->configuration != row.configuration)
      summaries.push_back({&row, {kUnknown, kUnknown, kUnknown, kUnknown}, 0});
    ConfigurationSummary& summary = summaries.back();
    summary.best = &row;  // rows rise
    const auto other = base.find(row.samples);
    if (other == base.end()) continue;
    if (!(other->second->squared_noise.value * other->second->cpu_seconds > 0)) continue;
    summary.cost_ratio = cost_ratio(row, *other->second, result.timing_error);
    summary.compared_at = row.samples;
  }
  for (ConfigurationSummary& summary : summaries)
    if (summary.best->group == "base")
      summary.cost_ratio = {1, 1, 1, 0}, summary.has_effect = false;
    else if (!base.empty())
      summary.has_effect = has_effect(summary, *base.rbegin()->second);
  return summaries;
}

}  // namespace alabaster::tradeoff
