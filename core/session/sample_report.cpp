#include "core/session/sample_report.h"

#include "core/diagnostics/plain_format.h"
#include "core/integrator/path_record.h"

namespace alabaster {
namespace {

std::string color_line(const SampleAddress& at, const Rgb& color) {
  return plain_format("sample %u of pixel %d,%d: colour (%.9g %.9g %.9g)\n", at.sample, at.x, at.y, double(color.r),
                      double(color.g), double(color.b));
}

class SampleReporter {
 public:
  explicit SampleReporter(const RenderRequest& request) : request_(request), renderer_(request) {}

  /// The colour of every sample of the pixel; answers the first that fails a check, else the first that is not finite,
  /// else the brightest.
  SampleAddress list_samples(int x, int y) {
    SampleAddress brightest{x, y, 0};
    float most = -1;
    for (uint32_t s = 0; s < request_.settings.samples; ++s) {
      const Rgb color = trace({x, y, s}, nullptr);
      if (max_component(color) > most) most = max_component(color), brightest.sample = s;
    }
    return failed_.value_or(counters_.first_nonfinite.value_or(brightest));
  }

  void write_path(const SampleAddress& at) {
    PathRecord record(request_.scene->origin);
    trace(at, &record);
  }

  const std::string& text() const { return text_; }

 private:
  Rgb trace(const SampleAddress& at, PathRecord* record) {
    const uint64_t nonfinite = counters_.nonfinite_samples;
    try {
      const Rgb color = renderer_.trace_sample(at, &counters_, &layers_, record).color;
      if (record) text_ += record->text();
      if (record && request_.camera.exposure != 0) text_ += "  the camera's exposure multiplies the sum\n";
      text_ += color_line(at, color);
      if (counters_.nonfinite_samples > nonfinite) text_ += "  not finite: the film takes black in its place\n";
      return color;
    } catch (const SampleFailure& failure) {
      if (record) record->end("a check failed");
      if (record) text_ += record->text();
      text_ += std::string(failure.what()) + "\n";
      if (!failed_) failed_ = at;
      return Rgb(0.0f);
    }
  }

  const RenderRequest& request_;
  TileRenderer renderer_;
  RenderCounters counters_;
  LightLayers layers_;
  std::optional<SampleAddress> failed_;
  std::string text_;
};

}  // namespace

std::string report_sample(const RenderRequest& request, int x, int y, std::optional<uint32_t> sample) {
  RenderRequest recorded = request;
  recorded.aovs |= kLayerAovs;  // integrators that split layers can record
  SampleReporter reporter(recorded);
  reporter.write_path(sample ? SampleAddress{x, y, *sample} : reporter.list_samples(x, y));
  return reporter.text();
}

}  // namespace alabaster
