#include "delegate/tradeoff/analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "delegate/tradeoff/display_error.h"
#include "delegate/tradeoff/flip.h"
#include "delegate/tradeoff/pareto.h"
#include "delegate/tradeoff/study.h"

namespace alabaster::tradeoff {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

struct DisplayError {
  double rmse = kUnknown, flip = kUnknown;
};

/// Holds one configuration's pictures in memory at a time, besides the reference's mean.
class Analysis {
 public:
  Analysis(const StudyStore& store, const ConfigurationList& list, const DisplayFunction& display)
      : store_(store), list_(list), display_(display) {}

  bool run(StudyResult* result, std::string* problem) {
    if (!take_reference(result, problem)) return false;
    for (const bool denoised : {false, true}) {
      const size_t first = result->rows.size();
      for (size_t c = 0; c < list_.measured.size(); ++c)
        if (!add_rows(static_cast<int>(c), denoised, result, problem)) return false;
      mark_front(std::span(result->rows).subspan(first));
    }
    return true;
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
      row.total = std::sqrt(std::max(0.0, bias.value) + row.squared_noise.value);
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
    for (const StoredRender* render : renders) {
      row.cpu_seconds += render->cost.cpu_seconds / n;
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

  static void mark_front(std::span<Row> rows) {
    std::vector<CostError> points;
    for (const Row& row : rows) points.push_back({row.cpu_seconds, row.total});
    for (const size_t i : pareto_front(points)) rows[i].pareto = true;
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

std::vector<ConfigurationSummary> summarize(const StudyResult& result) {
  std::map<uint64_t, const Row*> base;
  for (const Row& row : result.rows)
    if (row.group == "base") base[row.samples] = &row;
  std::vector<ConfigurationSummary> summaries;
  for (const Row& row : result.rows) {
    if (row.denoised) continue;
    if (summaries.empty() || summaries.back().best->configuration != row.configuration)
      summaries.push_back({&row, kUnknown, 0});
    ConfigurationSummary& summary = summaries.back();
    summary.best = &row;  // rows rise
    const auto other = base.find(row.samples);
    if (other == base.end()) continue;
    const double work = other->second->squared_noise.value * other->second->cpu_seconds;
    if (!(work > 0)) continue;
    summary.cost_ratio = row.squared_noise.value * row.cpu_seconds / work;
    summary.compared_at = row.samples;
  }
  return summaries;
}

}  // namespace alabaster::tradeoff
