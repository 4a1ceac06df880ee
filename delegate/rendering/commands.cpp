#include "delegate/rendering/commands.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "core/session/sample_report.h"
#include "delegate/rendering/render_pass.h"
#include "delegate/support/lookup.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::rendering {
namespace {

struct BadArgument : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The arguments of a command, by name. A value of another type than is asked for throws BadArgument.
class Arguments {
 public:
  explicit Arguments(const Dictionary& all) : all_(all) {}

  bool has(const char* name) const { return all_.contains(name); }
  std::string text(const char* name) const {
    const Value* value = support::find_in(all_, name);
    if (!value) return {};
    const std::string text = value->text_or({});
    if (text.empty() && !value->get<std::string>() && !value->get<Token>() && !value->get<AssetPath>())
      throw BadArgument(std::string("'") + name + "' must be a text");
    return text;
  }
  std::string file() const {
    std::string file = text("file");
    if (file.empty()) throw BadArgument("it needs the argument 'file'");
    return file;
  }
  bool flag(const char* name) const { return typed<bool>(name, "true or false"); }
  Array<std::string> texts(const char* name) const { return typed<Array<std::string>>(name, "an array of texts"); }
  int64_t whole(const char* name, int64_t least, int64_t most) const {
    const Value* value = support::find_in(all_, name);
    const double number = value ? value->number_or(NAN) : NAN;
    if (number >= double(least) && number <= double(most) && number == std::floor(number))
      return static_cast<int64_t>(number);
    throw BadArgument(std::string("'") + name + "' must be a whole number from " + std::to_string(least) + " to " +
                      std::to_string(most));
  }
  double number(const char* name, double fallback) const {
    const Value* value = support::find_in(all_, name);
    const double number = value ? value->number_or(NAN) : fallback;
    if (std::isnan(number)) throw BadArgument(std::string("'") + name + "' must be a number");
    return number;
  }

 private:
  template <class T>
  T typed(const char* name, const char* kind) const {
    const Value* value = support::find_in(all_, name);
    if (!value) return {};
    if (const T* held = value->get<T>()) return *held;
    throw BadArgument(std::string("'") + name + "' must be " + kind);
  }
  const Dictionary& all_;
};

CommandResult trace_pixel(DelegateState& delegate, const Arguments& arguments) {
  const auto request = delegate.last_request();
  if (!request) return command_failed("no frame has been drawn yet");
  const PixelRect& window = request->data_window;
  const auto x = static_cast<int>(arguments.whole("x", window.x0, window.x1 - 1));
  const auto y = static_cast<int>(arguments.whole("y", window.y0, window.y1 - 1));
  std::optional<uint32_t> sample;
  if (arguments.has("sample"))
    sample = static_cast<uint32_t>(arguments.whole("sample", 0, std::numeric_limits<uint32_t>::max()));
  return command_done(report_sample(*request, x, y, sample));
}

CommandResult measure_noise(DelegateState& delegate, const Arguments&) {
  if (const auto passes = delegate.passes(); !passes.empty()) passes.back()->ask_for_noise();
  return command_done();
}

CommandResult wait_for_scene(DelegateState& delegate, const Arguments& arguments) {
  return command_done(delegate.wait_for_build(arguments.number("seconds", std::numeric_limits<double>::infinity())));
}

CommandResult reload(DelegateState& delegate, const std::string& file) {
  delegate.param->reload(file);
  return command_done();
}

struct Command {
  const char* name;
  const char* arguments[3];
  CommandResult (*run)(DelegateState&, const Arguments&);
};
constexpr Command kCommands[] = {
    {"dumpScene", {}, [](DelegateState& delegate, const Arguments&) { return command_done(delegate.dump()); }},
    {"requirements",
     {},
     [](DelegateState& delegate, const Arguments&) { return command_done(delegate.requirements()); }},
    {"names",
     {},
     [](DelegateState& delegate, const Arguments&) {
       return command_done(std::make_shared<const Dictionary>(delegate.names()));
     }},
    {"waitForScene", {"seconds"}, wait_for_scene},
    {"tracePixel", {"x", "y", "sample"}, trace_pixel},
    {"measureNoise", {}, measure_noise},
    {"reloadResource",
     {"file"},
     [](DelegateState& delegate, const Arguments& a) { return reload(delegate, a.file()); }},
    {"flush", {}, [](DelegateState& delegate, const Arguments&) { return reload(delegate, {}); }},
    {"writeCheckpoint",
     {"file", "note"},
     [](DelegateState& delegate, const Arguments& a) {
       return delegate.checkpoints.write(delegate, a.file(), a.text("note"));
     }},
    {"resumeCheckpoint",
     {"file"},
     [](DelegateState& delegate, const Arguments& a) {
       return delegate.checkpoints.resume(a.text("file"), delegate.param->memory());
     }},
    {"showCheckpoints",
     {"files"},
     [](DelegateState& delegate, const Arguments& a) {
       return delegate.checkpoints.show(a.texts("files"), delegate.param->memory());
     }},
    {"describeCheckpoint", {"file", "measure"}, [](DelegateState& delegate, const Arguments& a) {
       return Checkpoints::describe(a.file(), a.flag("measure"), delegate.param->memory());
     }}};

// An argument that the command does not have is named wrongly: it would be left out without a word.
void check_names(const Command& command, const Dictionary& arguments) {
  std::vector<std::string> known;
  for (const char* name : command.arguments)
    if (name) known.emplace_back(name);
  for (const auto& [name, value] : arguments)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw BadArgument("there is no argument '" + name + "'" + support::DidYouMean(name, known));
}

CommandResult unknown_command(const std::string& name) {
  std::vector<std::string> known;
  for (const Command& command : kCommands) known.emplace_back(command.name);
  return {CommandStatus::unknown, "there is no command '" + name + "'" + support::DidYouMean(name, known), {}};
}

}  // namespace

CommandResult run_command(DelegateState& delegate, const Token& command, const Dictionary& arguments) {
  for (const Command& known : kCommands) {
    if (command.str() != known.name) continue;
    try {
      check_names(known, arguments);
      return known.run(delegate, Arguments(arguments));
    } catch (const BadArgument& e) {
      return {CommandStatus::invalid, std::string(known.name) + ": " + e.what(), {}};
    } catch (const MemoryRefused& e) {
      return {CommandStatus::out_of_memory, e.what(), {}};
    } catch (const std::bad_alloc&) {
      return {CommandStatus::out_of_memory, "not enough memory", {}};
    } catch (const std::exception& e) {
      return command_failed(e.what());
    }
  }
  return unknown_command(command.str());
}

}  // namespace alabaster::hd::rendering
