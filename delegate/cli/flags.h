// Options of the command line whose values get their types as they are read. Values of settings stay texts (main.cpp).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "delegate/api/scene_types.h"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace alabaster::cli {

/// Adds an option whose text `read` takes. Where it returns false, reading the command line ends with "FLAG: 'TEXT'
/// `fault`".
void add_read(CLI::App* command, const char* flag, const std::function<bool(const std::string&)>& read,
              const char* fault, const char* type, const char* help);

/// The same with a value that `parse` makes of the text.
template <class Held, class T>
void add_parsed(CLI::App* command, const char* flag, Held* value, std::optional<T> (*parse)(const std::string&),
                const char* fault, const char* type, const char* help) {
  const auto read = [=](const std::string& text) {
    const std::optional<T> parsed = parse(text);
    if (parsed) *value = *parsed;
    return parsed.has_value();
  };
  add_read(command, flag, read, fault, type, help);
}

/// An option that may be given several times, each time with one value.
void add_repeated(CLI::App* command, const char* flags, std::vector<std::string>* values, const char* type,
                  const char* help);
/// --size WxH.
void add_size(CLI::App* command, std::optional<hd::Vec2i>* size, const char* help);

/// Prints why a command line was not read, or the help that it requests; an exit code. `fault`: of its words; empty:
/// the parser's own text will do.
int parse_fault(const CLI::ParseError& error, const CLI::App& app, const std::string& fault);

// Each is empty if the text is malformed.
/// Finite and not negative, or above 0.
std::optional<double> parse_nonnegative(const std::string& text);
std::optional<double> parse_positive(const std::string& text);
std::optional<double> parse_minutes(const std::string& text);       // above 0, at most a week
std::optional<double> parse_target_error(const std::string& text);  // above 0, at most 1
std::optional<float> parse_stops(const std::string& text);          // -64 to 64
/// "1280x720", with sides of 1 to 65536.
std::optional<hd::Vec2i> parse_size(const std::string& text);
/// "x0,y0,x1,y1".
std::optional<hd::Rect2i> parse_crop(const std::string& text);
struct PixelChoice {
  int x = 0, y = 0;  // from the frame's upper left corner
  std::optional<uint32_t> sample;
};
/// "x,y" and "x,y,sample"; the sample is not negative.
std::optional<PixelChoice> parse_pixel(const std::string& text);
/// "open:close", two finite numbers in order.
std::optional<std::pair<double, double>> parse_interval(const std::string& text);
/// "begin:end", whole numbers, 0 <= begin < end <= 1048576.
std::optional<std::pair<uint32_t, uint32_t>> parse_samples(const std::string& text);
/// Frames, which are time codes of a stage.
struct FrameList {
  std::vector<double> numbers;
  size_t digits = 0;  // after the point, that a file's name needs to tell them apart
};
/// Lists as usdrecord has them: "number", "first:last" and "first:lastxstep", also backwards, and "first:last:step"; 1
/// to 100,000 of them.
std::optional<FrameList> parse_frames(const std::string& text);
/// A whole number of 32 bits.
std::optional<double> parse_frame(const std::string& text);
/// A whole number from 16 to 1024, or 0.
std::optional<uint32_t> parse_tiles(const std::string& text);
/// A whole number from 1 to 10,000.
std::optional<uint32_t> parse_tasks(const std::string& text);

}  // namespace alabaster::cli
