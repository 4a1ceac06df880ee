// How far the tasks of a farm are, by the files that they wrote.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/farm_jobs.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/running_mark.h"
#include "delegate/cli/shell_word.h"
#include "delegate/support/lookup.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;
using hd::support::number_in;
using nlohmann::json;
using nlohmann::ordered_json;

/// lost: it ended without a word.
enum class State { waiting, running, lost, failed, degraded, done };
constexpr const char* kToldToEnd = "it was told to end, by a signal";
constexpr const char* kStates[] = {"waiting", "running", "lost", "failed", "degraded", "done"};

/// Of a task, or of one of its frames.
struct Progress {
  State state = State::waiting;
  std::optional<int> exit_code;
  std::string reason, host;
  double seconds = 0, noise = -1;  // of rendering, and relative RMSE; < 0: not known
};

struct Frame : Progress {
  double number = 0;
};

struct Task : Progress {
  uint32_t number = 0;
  std::vector<Frame> frames;
  uint32_t first = 0, end = 0;  // samples of a part
  double saved = 0;             // of these, per pixel
  std::optional<RunningSign> sign;
};

std::optional<json> json_in(const fs::path& file) {
  std::ifstream in(file);
  json found = json::parse(in, nullptr, false);
  return found.is_object() ? std::optional(std::move(found)) : std::nullopt;
}

bool is_over(State state) {
  return state == State::done || state == State::degraded;
}

class FarmStatus {
 public:
  explicit FarmStatus(const FarmArguments::Status& arguments) : a_(arguments) {}

  int run() {
    read_farm();
    for (Task& task : tasks_) look_at(&task);
    a_.json ? print_json() : print_text();
    return code();
  }

 private:
  void read_farm() {
    const std::optional<json> farm = json_in(in_folder("farm.json"));
    try {
      if (!farm) throw json::other_error::create(0, "", nullptr);
      home_ = farm->at("home").get<std::string>();
      const auto number = [&](const char* key) {
        constexpr int64_t kMost = std::numeric_limits<uint32_t>::max();
        const auto value = farm->at(key).get<int64_t>();
        if (value < 1 || value > kMost) throw json::other_error::create(0, key, nullptr);
        return static_cast<uint64_t>(value);
      };
      const uint64_t tasks = number("tasks");
      is_of_frames_ = farm->contains("frames");
      const uint64_t samples = is_of_frames_ ? tasks : number("samples");
      if (samples < tasks) throw json::other_error::create(0, "samples", nullptr);
      tasks_.resize(tasks);
      for (uint32_t k = 0; k < tasks_.size(); ++k) {
        Task& task = tasks_[k];
        task.number = k;
        task.first = static_cast<uint32_t>(k * samples / tasks_.size());
        task.end = static_cast<uint32_t>((k + 1) * samples / tasks_.size());
        if (!is_of_frames_) continue;
        const auto list = parse_frames(farm->at("frames").at(k).get<std::string>());
        for (const double number : list.value().numbers) task.frames.emplace_back().number = number;
      }
      if (is_of_frames_) stats_ = farm->at("stats").get<std::string>();
    } catch (const std::exception&) {
      console_.fail(kInput, a_.folder,
                    "It is no folder of a farm: its farm.json, which 'alabaster farm' writes, cannot be read.");
    }
  }

  fs::path in_folder(const std::string& name) const { return fs::path(a_.folder) / name; }

  void look_at(Task* task) {
    task->sign = read_running_mark(in_folder(task_file("task", task->number, "running")));
    if (task->frames.empty())
      look_at_part(task);
    else
      look_at_frames(task);
    if (is_over(task->state) || !task->sign) return;
    task->host = task->sign->host;
    task->exit_code.reset();
    task->state = task->sign->lives ? State::running : State::lost;
    task->reason = task->sign->lives ? "" : lost_reason(*task);
    if (!task->sign->lives && task->sign->told_to_end)
      task->state = State::failed, task->exit_code = kInterrupted, task->reason = kToldToEnd;
    // Frames are rendered one after the other.
    for (Frame& frame : task->frames)
      if (!is_over(frame.state)) {
        frame.state = task->state, frame.reason = task->reason, frame.exit_code = task->exit_code;
        break;
      }
  }

  std::string lost_reason(const Task& task) const {
    std::string text = task.sign->is_known
                           ? "it ended without a word: it was killed, or its machine failed"
                           : formatted(
                                 "it has given no sign for %s, where it gives one each half minute: it was killed, "
                                 "or its machine or the network fails",
                                 time_text(task.sign->age).c_str());
    const fs::path log = in_folder("task_" + std::to_string(task.number) + ".log");
    if (fs::exists(log)) text += "; its log is " + log.string();
    return text;
  }

  // What the statistics of a run tell.
  void read_stats(const fs::path& file, Progress* to) const {
    try {
      if (const std::optional<json> stats = json_in(file)) read_stats(*stats, to);
    } catch (const std::exception&) {
      to->state = State::failed, to->exit_code = kRender;
      to->reason = "its statistics cannot be read: " + file.string();
    }
  }
  void read_stats(const json& found, Progress* to) const {
    const json* const stats = &found;
    to->exit_code = stats->value("exitCode", int(kRender));
    to->state = *to->exit_code == kDone ? State::done : *to->exit_code == kDegraded ? State::degraded : State::failed;
    to->host = stats->value("host", "");
    to->reason = stats->value("reason", "");
    if (*to->exit_code == kInterrupted) to->reason = kToldToEnd;
    const auto faults = stats->find("faults");
    if (*to->exit_code == kDegraded && faults != stats->end() && !faults->empty())
      to->reason = "without " + faults->front().get<std::string>();
    for (const json& render : stats->value("delegate", json::array()))
      to->seconds += render.value("totalClockTime", 0.0);
    if (const auto error = stats->find("error"); error != stats->end()) to->noise = error->value("relativeRmse", -1.0);
    for (const json& written : stats->value("files", json::array()))
      if (to->state == State::done && is_missing(written.get<std::string>()))
        to->state = State::waiting, to->reason = written.get<std::string>() + " is no longer there";
  }

  /// Not of folders that this machine does not have.
  bool is_missing(const std::string& written) const {
    std::error_code error;
    const fs::path file = fs::path(home_) / written;
    return !fs::exists(file, error) && fs::is_directory(file.parent_path(), error);
  }

  void look_at_frames(Task* task) {
    State least = State::done;
    for (Frame& frame : task->frames) {
      read_stats(in_folder(frame_file(stats_, frame.number)), &frame);
      least = std::min(least, frame.state);
      task->seconds += frame.seconds;
      task->noise = std::max(task->noise, frame.noise);
      if (!frame.host.empty()) task->host = frame.host;
      if (task->reason.empty()) task->reason = frame.reason;
      if (frame.state == State::failed) task->exit_code = frame.exit_code;
    }
    const bool failed = std::any_of(task->frames.begin(), task->frames.end(),
                                    [](const Frame& frame) { return frame.state == State::failed; });
    task->state = failed ? State::failed : least;
    if (is_over(task->state)) task->exit_code = task->state == State::done ? kDone : kDegraded;
  }

  void look_at_part(Task* task) {
    read_stats(in_folder(task_file("stats", task->number, "json")), task);
    const fs::path part = in_folder(task_file("part", task->number, "checkpoint"));
    if (!fs::exists(part)) {
      if (is_over(task->state)) task->state = State::waiting, task->reason = part.string() + " is no longer there";
      return;
    }
    const bool is_known = is_over(task->state) && task->noise >= 0;
    const auto described = describe(part, !is_known, task);
    if (!described) return;
    const double count = task->end - task->first;
    const bool is_whole = described->at("complete").get_or(false);
    task->saved = is_whole ? count : number_in(*described, "meanSamples");
    if (!is_known) task->noise = number_in(*described, "error.relativeRmse", -1);
    if (is_over(task->state) && !is_whole) task->state = State::waiting;
  }

  std::shared_ptr<const hd::Dictionary> describe(const fs::path& part, bool measure, Task* task) {
    if (!session_.delegate()) session_.start(console_.sink());
    const hd::CommandResult described =
        session_.delegate()->InvokeCommand("describeCheckpoint", {{"file", part.string()}, {"measure", measure}});
    if (described.ok()) return described.value.get_or(std::make_shared<const hd::Dictionary>());
    task->state = State::failed;
    task->reason = part.string() + ": " + described.fault;
    return {};
  }

  size_t count(State state) const {
    return static_cast<size_t>(
        std::count_if(tasks_.begin(), tasks_.end(), [=](const Task& task) { return task.state == state; }));
  }

  int code() const {
    if (count(State::failed) + count(State::lost) > 0) return kRender;
    if (count(State::waiting) + count(State::running) > 0) return kToDo;
    return count(State::degraded) > 0 ? kDegraded : kDone;
  }

  /// Of the sum of the parts so far: the error of the mean of independent pictures is the root of the sum of squares.
  double noise_of_parts() const {
    double samples = 0, squares = 0;
    for (const Task& task : tasks_) {
      if (task.noise < 0 || !std::isfinite(task.noise) || is_of_frames_) continue;
      samples += task.saved;
      squares += task.saved * task.saved * task.noise * task.noise;
    }
    return samples > 0 ? std::sqrt(squares) / samples : -1;
  }

  static std::string list_of(const Task& task) {
    if (task.frames.empty()) return formatted("samples %u to %u", task.first, task.end - 1);
    const double first = task.frames.front().number, last = task.frames.back().number;
    return task.frames.size() == 1 ? formatted("frame %g", first)
                                   : formatted("%zu frames, %g to %g", task.frames.size(), first, last);
  }

  static std::string line_of(const Task& task) {
    std::string text = formatted("task %-5u %-9s ", task.number, kStates[int(task.state)]) + list_of(task);
    const auto add = [&](const std::string& more) { text += ", " + more; };
    const auto over =
        std::count_if(task.frames.begin(), task.frames.end(), [](const Frame& frame) { return is_over(frame.state); });
    if (task.frames.size() > 1 && !is_over(task.state)) add(std::to_string(over) + " done");
    if (task.frames.empty() && !is_over(task.state) && task.saved > 0)
      add(formatted("%.1f of these saved", task.saved));
    if (task.seconds > 0) add(formatted("%.1f s", task.seconds));
    if (task.state == State::running) add("since " + time_text(task.sign->began));
    if (task.noise >= 0) add(formatted("noise %.3g %%", 100 * task.noise));
    if (!task.host.empty()) add("on " + task.host);
    if (task.state == State::failed) add(formatted("exit code %d", task.exit_code.value_or(kRender)));
    return task.reason.empty() ? text : text + ": " + task.reason;
  }

  void print_text() const {
    for (const Task& task : tasks_) std::printf("%s\n", printable(line_of(task)).c_str());
    std::string states;
    for (const State state : {State::done, State::degraded, State::running, State::waiting, State::failed, State::lost})
      if (const size_t found = count(state); found > 0 || state == State::done)
        states += (states.empty() ? "" : ", ") + std::to_string(found) + " " + kStates[int(state)];
    std::printf("%zu tasks: %s\n", tasks_.size(), states.c_str());
    if (const double noise = noise_of_parts(); noise >= 0)
      std::printf("noise of all that is saved: about %.3g %%\n", 100 * noise);
    print_slowest();
    if (count(State::failed) + count(State::lost) == 0) return;
    const fs::path submit = in_folder("submit.sh");
    std::printf("render what is missing: %s\n",
                fs::exists(submit)
                    ? ("sh " + shell_path(submit)).c_str()
                    : ("sh " + shell_path(in_folder("task.sh")) + " K, K the number of the task").c_str());
  }

  void print_slowest() const {
    std::vector<const Task*> timed;
    for (const Task& task : tasks_)
      if (is_over(task.state) && task.seconds > 0) timed.push_back(&task);
    if (timed.size() < 2) return;
    std::sort(timed.begin(), timed.end(), [](const Task* a, const Task* b) { return a->seconds < b->seconds; });
    const Task& slowest = *timed.back();
    std::printf("half of the tasks took %.1f s or less, task %u on %s took %.1f s\n",
                timed[(timed.size() - 1) / 2]->seconds, slowest.number, printable(slowest.host).c_str(),
                slowest.seconds);
  }

  static void add_progress(const Progress& from, ordered_json* to) {
    (*to)["state"] = kStates[int(from.state)];
    if (from.exit_code) (*to)["exitCode"] = *from.exit_code;
    if (!from.reason.empty()) (*to)["reason"] = from.reason;
    if (!from.host.empty()) (*to)["host"] = from.host;
    if (from.seconds > 0) (*to)["seconds"] = from.seconds;
    if (from.noise >= 0) (*to)["noise"] = from.noise;
  }

  void print_json() const {
    ordered_json all = {{"folder", a_.folder}, {"exitCode", code()}};
    for (size_t state = std::size(kStates); state-- > 0;) all["counts"][kStates[state]] = count(State(state));
    if (const double noise = noise_of_parts(); noise >= 0) all["noise"] = noise;
    all["tasks"] = ordered_json::array();
    for (const Task& task : tasks_) {
      ordered_json& one = all["tasks"].emplace_back(ordered_json{{"task", task.number}});
      add_progress(task, &one);
      if (task.sign && !is_over(task.state))
        one["secondsSinceBegin"] = task.sign->began, one["secondsSinceSign"] = task.sign->age;
      if (!is_of_frames_) one["samples"] = {task.first, task.end}, one["samplesSaved"] = task.saved;
      for (const Frame& frame : task.frames) {
        const bool is_whole = std::nearbyint(frame.number) == frame.number;
        const ordered_json number = is_whole ? ordered_json(int64_t(frame.number)) : ordered_json(frame.number);
        add_progress(frame, &one["frames"].emplace_back(ordered_json{{"frame", number}}));
      }
    }
    std::printf("%s\n", all.dump(2, ' ', false, json::error_handler_t::replace).c_str());
  }

  const FarmArguments::Status& a_;
  Console console_{false};
  SceneSession session_;
  std::string home_, stats_;
  bool is_of_frames_ = false;
  std::vector<Task> tasks_;
};

}  // namespace

int run_farm_status(const FarmArguments::Status& arguments) {
  return FarmStatus(arguments).run();
}

}  // namespace alabaster::cli
