#include "core/light/ies_profile.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/files/input_file.h"

namespace alabaster {
namespace {

constexpr size_t kMostBytes = size_t(16) << 20;
constexpr double kRadians = std::numbers::pi / 180;
constexpr const char* kExport = "export the profile again as LM-63";

// The interval of ascending angles that holds `angle`, and the place in it, 0 to 1.
struct Between {
  size_t low, high;
  double share;
};
Between find(const std::vector<double>& angles, double angle) {
  const auto above = std::upper_bound(angles.begin(), angles.end(), angle);
  const size_t high = std::clamp<size_t>(static_cast<size_t>(above - angles.begin()), 1, angles.size()) - 1;
  if (high + 1 == angles.size()) return {high, high, 0};
  return {high, high + 1, (angle - angles[high]) / (angles[high + 1] - angles[high])};
}

}  // namespace

// Goes through a file's lines, then through its numbers.
class IesReader {
 public:
  IesReader(std::string_view text, const std::string& name, const DiagnosticSink& sink)
      : text_(text), name_(name), sink_(sink) {}

  std::shared_ptr<const IesProfile> read() {
    if (!find_tilt()) return nullptr;
    auto profile = std::shared_ptr<IesProfile>(new IesProfile());
    return read_numbers(profile.get()) ? profile : nullptr;
  }

 private:
  bool fail(const std::string& text) {
    report(sink_, Severity::error, "ies.invalid", name_ + ":" + std::to_string(line_), text);
    return false;
  }

  std::string_view next_line() {
    const size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view line = text_.substr(at_, end - at_);
    at_ = std::min(end + 1, text_.size());
    ++line_;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
    return line;
  }

  // Labels and keywords, which come before the line TILT=, are skipped.
  bool find_tilt() {
    while (at_ < text_.size()) {
      const std::string_view line = next_line();
      if (line.substr(0, 5) != "TILT=") continue;
      if (line == "TILT=NONE") return true;
      return fail("'" + std::string(line.substr(0, 40)) +
                  "' is not supported, only TILT=NONE; export the profile for one position of the lamp");
    }
    return fail(std::string("no line 'TILT=NONE': this is no IES profile; ") + kExport);
  }

  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ','; }

  std::optional<double> next_number() {
    for (; at_ < text_.size() && is_blank(text_[at_]); ++at_) line_ += text_[at_] == '\n' ? 1 : 0;
    if (at_ < text_.size() && text_[at_] == '+') ++at_;
    double value = 0;
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value);
    if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
    at_ += static_cast<size_t>(end - begin);
    return value;
  }

  bool number(const char* what, double least, double most, double* out) {
    const auto value = next_number();
    if (!value) return fail(std::string("expected a number, the ") + what + "; " + kExport);
    if (!(*value >= least && *value <= most)) return fail(std::string("the ") + what + " is out of range; " + kExport);
    *out = *value;
    return true;
  }

  bool read_numbers(IesProfile* profile) {
    ++line_;
    constexpr double kLarge = 1e12;
    double lamps = 0, verticals = 0, horizontals = 0, type = 0, ignored = 0, scale = 1, factor = 1;
    if (!number("number of lamps", 1, kLarge, &lamps) || !number("lumens of a lamp", -1, kLarge, &ignored) ||
        !number("candela multiplier", 0, kLarge, &scale) || !number("number of vertical angles", 2, 1e6, &verticals) ||
        !number("number of horizontal angles", 1, 1e6, &horizontals) || !number("photometric type", 1, 3, &type))
      return false;
    if (type != 1)
      return fail(std::string("photometry of type ") + (type == 2 ? "B" : "A") +
                  " is not supported, only type C; export the profile as type C");
    if (!number("unit of length", 1, 2, &ignored)) return false;
    for (const char* what : {"width", "length", "height"})  // negative where the luminaire is round
      if (!number(what, -kLarge, kLarge, &ignored)) return false;
    for (const char* what : {"ballast factor", "ballast-lamp factor"}) {
      if (!number(what, 0, kLarge, &factor)) return false;
      scale *= factor;
    }
    if (!number("input watts", 0, kLarge, &ignored)) return false;
    if (!angles("vertical angle", verticals, 180, &profile->verticals_) ||
        !angles("horizontal angle", horizontals, 360, &profile->horizontals_))
      return false;
    const double first = profile->horizontals_.front(), last = profile->horizontals_.back();
    const bool whole = first == 0 && (last == 0 || last == 90 || last == 180 || last == 360);
    if (!whole && !(first == 90 && last == 270))
      return fail(std::string("horizontal angles must go from 0 to 0, 90, 180 or 360, or from 90 to 270; ") + kExport);
    return candela(scale, profile);
  }

  bool angles(const char* what, double count, double most, std::vector<double>* out) {
    if (count != std::floor(count)) return fail(std::string("a number of angles is not whole; ") + kExport);
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      double angle = 0;
      if (!number(what, 0, most, &angle)) return false;
      if (!out->empty() && !(angle > out->back())) return fail(std::string(what) + "s do not ascend; " + kExport);
      out->push_back(angle);
    }
    return true;
  }

  bool candela(double scale, IesProfile* profile) {
    const size_t count = profile->verticals_.size() * profile->horizontals_.size();
    if (count > text_.size()) return fail(std::string("the file ends before its candela values; ") + kExport);
    profile->candela_.reserve(count);
    for (size_t i = 0; i < count; ++i) {
      double value = 0;
      if (!number("candela value", 0, 1e12, &value)) return false;
      profile->candela_.push_back(value * scale);
    }
    if (next_number()) return fail(std::string("more numbers than the file announces; ") + kExport);
    profile->finish();
    return true;
  }

  std::string_view text_;
  const std::string& name_;
  const DiagnosticSink& sink_;
  size_t at_ = 0, line_ = 0;
};

std::shared_ptr<const IesProfile> IesProfile::parse(std::string_view text, const std::string& name,
                                                    const DiagnosticSink& sink) {
  return IesReader(text, name, sink).read();
}

std::shared_ptr<const IesProfile> IesProfile::load(const std::string& path, const DiagnosticSink& sink,
                                                   const std::string& within) {
  const InputFile file(path, within);
  std::string text, fault = file.reason();
  if (file && file.size() > kMostBytes)
    fault = "the file is larger than 16 MiB: this is no IES profile; check its name";
  else if (file && (!file.read(&text) || text.empty()))
    fault = "the file cannot be read or is empty; check its name";
  if (fault.empty()) return parse(text, path, sink);
  report(sink, Severity::error, "ies.unreadable", path, fault);
  return nullptr;
}

// Within an interval of vertical angles the profile is linear, and the integral of (a + b t) sin t is
// -(a + b t) cos t + b sin t; across horizontal angles the trapezoidal rule is exact.
void IesProfile::finish() {
  const size_t n = verticals_.size(), m = horizontals_.size();
  largest_.assign(n, 0);
  double sum = 0;
  for (size_t h = 0; h < m; ++h) {
    const double* row = &candela_[h * n];
    double along = 0;
    for (size_t v = 0; v < n; ++v) {
      largest_[v] = std::max(largest_[v], row[v]);
      if (v == 0) continue;
      const double t0 = verticals_[v - 1] * kRadians, t1 = verticals_[v] * kRadians;
      const double slope = (row[v] - row[v - 1]) / (t1 - t0);
      along += row[v - 1] * std::cos(t0) - row[v] * std::cos(t1) + slope * (std::sin(t1) - std::sin(t0));
    }
    const double width = m == 1 ? 1
                                : 0.5 * (horizontals_[std::min(h + 1, m - 1)] - horizontals_[h > 0 ? h - 1 : 0]) /
                                      (horizontals_.back() - horizontals_.front());
    sum += along * width;
  }
  mean_ = 0.5 * sum;
}

// Horizontal angles that the file leaves out mirror those that it has.
double IesProfile::intensity(double vertical, double horizontal) const {
  if (!(vertical >= verticals_.front() && vertical <= verticals_.back())) return 0;
  double h = horizontal - 360 * std::floor(horizontal / 360);
  const double first = horizontals_.front(), last = horizontals_.back();
  if (first == 90)
    h = h < 90 ? 180 - h : h > 270 ? 540 - h : h;
  else if (last < 360 && h > 180)
    h = 360 - h;
  if (last == 90 && h > 90) h = 180 - h;
  const Between v = find(verticals_, vertical), across = find(horizontals_, h);
  const auto row = [&](size_t i) {
    const double* values = &candela_[i * verticals_.size()];
    return values[v.low] + v.share * (values[v.high] - values[v.low]);
  };
  const double low = row(across.low);
  return low + across.share * (row(across.high) - low);
}

double IesProfile::largest(double from_vertical, double to_vertical) const {
  if (to_vertical < verticals_.front() || from_vertical > verticals_.back()) return 0;
  const size_t begin = find(verticals_, from_vertical).low, end = find(verticals_, to_vertical).high;
  return *std::max_element(&largest_[begin], &largest_[end] + 1);
}

}  // namespace alabaster
