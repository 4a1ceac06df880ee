#include "delegate/rendering/checkpoints.h"

#include <algorithm>

#include "core/convergence/frame_error.h"
#include "core/session/frame_memory.h"
#include "delegate/prims/scene_digest.h"
#include "delegate/rendering/commands.h"
#include "delegate/rendering/delegate_state.h"
#include "delegate/rendering/render_pass.h"

namespace alabaster::hd::rendering {
namespace {

// Samples that a film is to get: {0, N} of a whole frame.
nlohmann::json samples_of(const RenderRequest& request) {
  return {request.settings.first_sample, request.settings.samples};
}

SampleRange range_of(const CheckpointHeader& header) {
  const auto samples = header.value("samples", std::vector<uint64_t>());
  if (samples.size() != 2 || std::max(samples[0], samples[1]) > kMostSummedSamples) return {};
  return {static_cast<uint32_t>(samples[0]), static_cast<uint32_t>(samples[1])};
}

// Without samples a part would lie before itself.
std::string range_fault(const SampleRange& range) {
  return range.begin < range.end ? "" : "it does not say which samples it has; render its part again";
}

std::string range_text(const SampleRange& range) {
  return std::to_string(range.begin) + ":" + std::to_string(range.end);
}

bool is_complete(const CheckpointHeader& header) {
  return header.value("complete", false);
}

std::string note_of(const CheckpointHeader& header) {
  return header.value("note", std::string());
}

CommandResult done_unless(std::string fault) {
  return fault.empty() ? command_done() : command_failed(std::move(fault));
}

std::string in_quotes(const std::string& file) {
  return "'" + file + "'";
}

}  // namespace

std::shared_ptr<const Checkpoints::Pending> Checkpoints::pending() const {
  const std::lock_guard lock(mutex_);
  return pending_;
}

void Checkpoints::set_pending(std::shared_ptr<const Pending> pending, bool shown) {
  std::shared_ptr<const prims::IdNames> names;
  if (shown) names = std::make_shared<const prims::IdNames>(names_of(pending->header));
  const std::lock_guard lock(mutex_);
  pending_.swap(pending);
  shown_names_.swap(names);
  shown_ = shown;
}

std::shared_ptr<const prims::IdNames> Checkpoints::shown_names() const {
  const std::lock_guard lock(mutex_);
  return shown_names_;
}

CheckpointHeader Checkpoints::header_of(const RenderRequest& request, const DelegateState& delegate,
                                        const BuiltScene& scene) const {
  const auto names = request.aovs & kNamedAovs ? delegate.names_of(scene) : nullptr;
  return checkpoint_header(request, *digests_of(scene), names.get());
}

// Made once for each snapshot.
std::shared_ptr<const Checkpoints::Digests> Checkpoints::digests_of(const BuiltScene& scene) const {
  const std::lock_guard lock(digests_mutex_);
  if (!digests_ || digested_ != scene.snapshot->number)
    digests_ = std::make_shared<const Digests>(prims::digest_scene(scene.translation));
  digested_ = scene.snapshot->number;
  return digests_;
}

CommandResult Checkpoints::write(const DelegateState& delegate, const std::string& file,
                                 const std::string& note) const {
  const auto request = delegate.last_request();
  const auto pass = delegate.last_pass();
  if (!request || !request->scene || !pass) return command_failed("nothing has been rendered");
  const auto scene = delegate.scene(request->scene);
  if (!scene) return command_failed("the scene has changed since it was rendered");
  if (note.size() > kMostNoteBytes)
    return {CommandStatus::invalid, "the note is longer than " + std::to_string(kMostNoteBytes) + " bytes", {}};
  CheckpointHeader header = header_of(*request, delegate, *scene);
  header["samples"] = samples_of(*request);
  header["complete"] = pass->progress().state == SessionState::finished;
  header["note"] = note;
  const auto save = [&](const BlockSink& sink) { return pass->save(sink); };
  return done_unless(write_checkpoint(file, header, save));
}

namespace {

// Has the text of refused memory name the file.
template <class Body>
void naming(const std::string& file, Body&& body) {
  try {
    body();
  } catch (const MemoryRefused& e) {
    throw MemoryRefused(in_quotes(file) + ": " + e.what());
  }
}

// Answers with the reader's fault.
std::string read(CheckpointReader* reader, const MemoryBudget& memory, RenderState* state) {
  if (reader->fault().empty()) reader->finish(read_state(reader->source(), memory, state));
  return reader->fault();
}

}  // namespace

CommandResult Checkpoints::resume(const std::string& file, const Memory& memory) {
  set_pending(nullptr, false);
  if (file.empty()) return command_done();
  CheckpointReader reader(file, memory);
  auto state = std::make_shared<RenderState>();
  if (std::string fault = read(&reader, *memory, state.get()); !fault.empty()) return command_failed(std::move(fault));
  set_pending(std::make_shared<const Pending>(Pending{file, reader.header(), std::move(state), reader.take_memory()}),
              false);
  return command_done();
}

namespace {

// How far the pixels are: the mean number of samples that they have, and the noise of those.
std::string measure_pixels(CheckpointReader* reader, const MemoryBudget& memory, Dictionary* description) {
  RenderState state;
  if (std::string fault = read(reader, memory, &state); !fault.empty()) return fault;
  const NoiseImage noise = film_noise(*state.film);
  double taken = 0;
  for (const PixelNoise& pixel : noise.pixels) taken += pixel.samples;
  (*description)["meanSamples"] = noise.pixels.empty() ? 0.0 : taken / static_cast<double>(noise.pixels.size());
  if (const FrameError error = estimate_frame_error(noise); error.known)
    (*description)["error.relativeRmse"] = error.relative_rmse;
  return {};
}

}  // namespace

CommandResult Checkpoints::describe(const std::string& file, bool measure, const Memory& memory) {
  CheckpointReader reader(file, memory);
  if (!reader.fault().empty()) return command_failed(reader.fault());
  const SampleRange range = range_of(reader.header());
  if (const std::string fault = range_fault(range); !fault.empty()) return command_failed(fault);
  Dictionary description;
  description["firstSample"] = static_cast<int64_t>(range.begin);
  description["samples"] = static_cast<int64_t>(range.end);
  description["complete"] = is_complete(reader.header());
  description["note"] = note_of(reader.header());
  description["lightGroups"] = Array<std::string>(names_of(reader.header()).light_groups);
  if (measure)
    if (std::string fault = measure_pixels(&reader, *memory, &description); !fault.empty())
      return command_failed(std::move(fault));
  return command_done(std::make_shared<const Dictionary>(std::move(description)));
}

namespace {

struct Part {
  std::string file;
  SampleRange range;
  std::unique_ptr<CheckpointReader> reader;
};

// In the order of their samples. Empty, with the reason in *fault, if they are not all samples of one frame.
std::vector<Part> open_parts(const Array<std::string>& files, const std::shared_ptr<MemoryBudget>& memory,
                             std::string* fault) {
  std::vector<Part> parts;
  for (const std::string& file : files) {
    std::unique_ptr<CheckpointReader> reader;
    naming(file, [&] { reader = std::make_unique<CheckpointReader>(file, memory); });
    *fault = reader->fault();
    if (fault->empty() && !is_complete(reader->header()))
      *fault = "it does not have all samples of its part yet; continue its render to the end first";
    const SampleRange range = range_of(reader->header());
    if (fault->empty()) *fault = range_fault(range);
    if (!fault->empty()) return *fault = in_quotes(file) + ": " + *fault, std::vector<Part>();
    parts.push_back({file, range, std::move(reader)});
  }
  std::stable_sort(parts.begin(), parts.end(),
                   [](const Part& a, const Part& b) { return a.range.begin < b.range.begin; });
  uint32_t end = 0;
  for (const Part& part : parts) {
    const std::string difference = checkpoint_difference(part.reader->header(), parts[0].reader->header());
    if (!difference.empty())
      *fault = in_quotes(part.file) + " is of another render than " + in_quotes(parts[0].file) + ": " + difference;
    else if (part.range.begin > end)
      *fault = "samples " + range_text({end, part.range.begin}) + " are missing: no part has them";
    else if (part.range.begin < end)
      *fault = in_quotes(part.file) + " has samples " + range_text(part.range) +
               ", of which another part has those before " + std::to_string(end);
    if (!fault->empty()) return {};
    end = part.range.end;
  }
  return parts;
}

}  // namespace

CommandResult Checkpoints::show(const Array<std::string>& files, const Memory& memory) {
  set_pending(nullptr, false);
  if (files.empty()) return command_done();
  std::string fault;
  const std::vector<Part> parts = open_parts(files, memory, &fault);
  if (!fault.empty()) return command_failed(fault);
  auto state = std::make_shared<RenderState>();
  for (const Part& part : parts) {
    CheckpointReader& reader = *part.reader;
    naming(part.file, [&] {
      if (&part == parts.data())
        fault = read(&reader, *memory, state.get());
      else
        reader.finish(append_state(reader.source(), state.get())), fault = reader.fault();
    });
    if (!fault.empty()) return command_failed(in_quotes(part.file) + ": " + fault);
  }
  set_pending(std::make_shared<const Pending>(
                  Pending{parts[0].file, parts[0].reader->header(), std::move(state), parts[0].reader->take_memory()}),
              true);
  return command_done();
}

namespace {

// True if a render with these settings may have left the state: its header and its blocks agree.
bool has_state_of(const RenderRequest& request, const RenderState& state) {
  const RenderSettings& settings = request.settings;
  const bool decides = settings.adaptive || settings.target_error > 0;
  return state.film->extras() == film_extras(settings, request.light_groups.size()) &&
         (!decides || state.round.end <= settings.samples);
}

}  // namespace

std::string Checkpoints::fault(const DelegateState& delegate, const BuiltScene* scene,
                               const RenderRequest& request) const {
  const std::shared_ptr<const Pending> pending = this->pending();
  if (!pending) return {};
  const Film& film = *pending->state->film;
  std::string fault;
  const AovSet aovs = with_guides(request.aovs);
  if (film.data_window() != request.data_window || (aovs & ~film.aovs()) != 0 || (!shown_ && aovs != film.aovs()))
    fault = "it has another size or other AOVs";
  if (!shown_ && scene) {
    const std::string difference = checkpoint_difference(pending->header, header_of(request, delegate, *scene));
    const RenderSettings& settings = request.settings;
    const SampleRange range = range_of(pending->header), now{settings.first_sample, settings.samples};
    if (!difference.empty())
      fault = "it is of another render: " + difference;
    else if (range.begin != now.begin || (now.begin > 0 && range.end != now.end))
      fault = "it has samples " + range_text(range) + " of each pixel, and the render those of " + range_text(now);
    else if (!has_state_of(request, *pending->state))
      fault = "it is damaged: it does not hold what its header says";
    else if (!settings.adaptive && film.most_samples() > now.end - now.begin)
      fault = "it has " + std::to_string(film.most_samples()) + " samples per pixel, more than the " +
              std::to_string(now.end - now.begin) + " that are asked for";
  }
  return fault.empty() ? fault : "the render cannot go on from checkpoint " + in_quotes(pending->file) + ": " + fault;
}

std::shared_ptr<RenderState> Checkpoints::take() {
  const std::lock_guard lock(mutex_);
  const std::shared_ptr<const Pending> taken = std::move(pending_);
  return taken ? taken->state : nullptr;
}

}  // namespace alabaster::hd::rendering
