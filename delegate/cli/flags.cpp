#include "delegate/cli/flags.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <iostream>
#include <sstream>

#include "delegate/cli/console.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/shell_word.h"
#include "delegate/host/product_writer.h"

namespace alabaster::cli {
namespace {

// Parses numbers with one of `separators` between them. Empty if `text` holds anything else or a number does not fit.
template <class Number>
std::vector<Number> parse_numbers(const std::string& text, const std::string& separators) {
  std::vector<Number> numbers;
  const char *at = text.data(), *end = at + text.size();
  while (true) {
    const auto [next, error] = std::from_chars(at, end, numbers.emplace_back());
    if (error != std::errc()) return {};
    if (next == end) return numbers;
    if (separators.find(*next) == std::string::npos) return {};
    at = next + 1;
  }
}

// A finite number from `low` to `high`.
std::optional<double> parse_number(const std::string& text, double low, double high) {
  const auto numbers = parse_numbers<double>(text, "");
  const bool fits = numbers.size() == 1 && numbers[0] >= low && numbers[0] <= high && std::isfinite(numbers[0]);
  return fits ? std::optional(numbers[0]) : std::nullopt;
}

constexpr uint64_t kMostFrames = 100'000;
constexpr double kLeast = std::numeric_limits<double>::denorm_min(), kMost = std::numeric_limits<double>::max();

}  // namespace

void add_read(CLI::App* command, const char* flag, const std::function<bool(const std::string&)>& read,
              const char* fault, const char* type, const char* help) {
  const auto take = [=](const std::string& text) {
    if (!read(text)) throw CLI::ValidationError(flag, "'" + text + "' " + fault);
  };
  command->add_option_function<std::string>(flag, take, help)->type_name(type);
}

void add_repeated(CLI::App* command, const char* flags, std::vector<std::string>* values, const char* type,
                  const char* help) {
  command->add_option(flags, *values, help)
      ->type_name(type)
      ->expected(1)
      ->allow_extra_args(false)  // or "--" after a value would end the values alone, and not the options
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_size(CLI::App* command, std::optional<hd::Vec2i>* size, const char* help) {
  add_parsed(command, "--size", size, parse_size, "is not a resolution: write for example 1280x720, up to 65536x65536.",
             "WxH", help);
}

int parse_fault(const CLI::ParseError& error, const CLI::App& app, const std::string& fault) {
  const bool is_help = error.get_exit_code() == 0, is_value = error.get_name() == "ValidationError";
  if (is_value || (!is_help && !fault.empty())) {
    Console(false).error("", is_value ? error.what() : fault);
    return kUsage;
  }
  std::ostringstream errors;  // it may repeat the name of any file
  const int code = app.exit(error, std::cout, errors);
  std::cerr << without_control_characters(errors.str(), "\n");
  return code == 0 ? kDone : kUsage;
}

std::optional<double> parse_nonnegative(const std::string& text) {
  return parse_number(text, 0, kMost);
}
std::optional<double> parse_positive(const std::string& text) {
  return parse_number(text, kLeast, kMost);
}
std::optional<double> parse_minutes(const std::string& text) {
  return parse_number(text, kLeast, 10080);
}
std::optional<double> parse_target_error(const std::string& text) {
  return parse_number(text, kLeast, 1);
}
std::optional<float> parse_stops(const std::string& text) {
  return parse_number(text, -64, 64);
}

std::optional<hd::Vec2i> parse_size(const std::string& text) {
  const auto numbers = parse_numbers<int>(text, "xX");
  if (numbers.size() != 2) return std::nullopt;
  for (const int side : numbers)
    if (side < 1 || side > 65536) return std::nullopt;
  return hd::Vec2i(numbers[0], numbers[1]);
}

std::optional<hd::Rect2i> parse_crop(const std::string& text) {
  const auto numbers = parse_numbers<int>(text, ",");
  if (numbers.size() != 4) return std::nullopt;
  return hd::Rect2i{numbers[0], numbers[1], numbers[2], numbers[3]};
}

std::optional<PixelChoice> parse_pixel(const std::string& text) {
  const auto numbers = parse_numbers<int>(text, ",");
  if (numbers.size() == 2) return PixelChoice{numbers[0], numbers[1], {}};
  if (numbers.size() != 3 || numbers[2] < 0) return std::nullopt;
  return PixelChoice{numbers[0], numbers[1], static_cast<uint32_t>(numbers[2])};
}

std::optional<std::pair<double, double>> parse_interval(const std::string& text) {
  const auto numbers = parse_numbers<double>(text, ":");
  if (numbers.size() != 2 || !std::isfinite(numbers[0]) || !std::isfinite(numbers[1]) || numbers[1] < numbers[0])
    return std::nullopt;
  return std::pair(numbers[0], numbers[1]);
}

std::optional<std::pair<uint32_t, uint32_t>> parse_samples(const std::string& text) {
  const auto numbers = parse_numbers<uint32_t>(text, ":");
  if (numbers.size() != 2 || numbers[0] >= numbers[1] || numbers[1] > 1048576) return std::nullopt;
  return std::pair(numbers[0], numbers[1]);
}

std::optional<FrameList> parse_frames(const std::string& text) {
  FrameList all;
  std::istringstream specs(text + ",");
  for (std::string spec; std::getline(specs, spec, ',');) {
    if (const size_t by = spec.find('x'); by != std::string::npos && spec.find(':') < by) spec[by] = ':';
    std::vector<double> range;
    std::istringstream words(spec + ":");
    for (std::string word; std::getline(words, word, ':');) {
      const auto number = parse_number(word, -kMost, kMost);
      if (!number) return std::nullopt;
      range.push_back(*number);
      if (const size_t point = word.find('.'); point != std::string::npos)
        all.digits = std::max(all.digits, word.find_last_not_of('0') - point);
    }
    if (range.empty() || range.size() > 3) return std::nullopt;
    const double first = range[0], last = range.size() > 1 ? range[1] : first;
    const double step = range.size() > 2 ? range[2] : last < first ? -1 : 1;
    const double steps = (last - first) / step;
    if (!(steps >= 0 && steps < double(kMostFrames))) return std::nullopt;
    const auto count = static_cast<int>(std::floor(steps + 1e-6));
    for (int i = 0; i <= count; ++i) all.numbers.push_back(first + i * step);
    if (all.numbers.size() > kMostFrames) return std::nullopt;
  }
  return all.numbers.empty() ? std::nullopt : std::optional(all);
}

std::optional<double> parse_frame(const std::string& text) {
  const auto number = parse_numbers<int32_t>(text, "");
  return number.size() == 1 ? std::optional(double(number[0])) : std::nullopt;
}

std::optional<uint32_t> parse_tiles(const std::string& text) {
  const auto number = parse_numbers<uint32_t>(text, "");
  const bool is_side =
      number.size() == 1 &&
      (number[0] == 0 || (number[0] >= uint32_t(hd::host::kLeastTile) && number[0] <= uint32_t(hd::host::kMostTile)));
  return is_side ? std::optional(number[0]) : std::nullopt;
}

std::optional<uint32_t> parse_tasks(const std::string& text) {
  const auto number = parse_numbers<uint32_t>(text, "");
  return number.size() == 1 && number[0] >= 1 && number[0] <= 10000 ? std::optional(number[0]) : std::nullopt;
}

}  // namespace alabaster::cli
