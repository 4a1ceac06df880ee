// alabaster compare: variants of a scene side by side.
#include <algorithm>
#include <cmath>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/scene_session.h"
#include "delegate/support/extension.h"
#include "delegate/support/lookup.h"
#include "delegate/support/output_file.h"
#include "delegate/support/size_text.h"
#include "delegate/tradeoff/gnuplot.h"
#include "delegate/tradeoff/tiles.h"

namespace alabaster::cli {
namespace {

constexpr int kLongestSide = 480;

struct Look {
  std::string name;
  std::vector<hd::description::Override> overrides;
};

/// The parts of `text` between semicolons outside of quotes, without the spaces about them.
std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts(1);
  bool quoted = false;
  for (const char c : text) {
    if (c == '"') quoted = !quoted;
    if (c == ';' && !quoted)
      parts.emplace_back();
    else if (c != ' ' || !parts.back().empty())
      parts.back() += c;
  }
  for (std::string& part : parts) part.erase(part.find_last_not_of(' ') + 1);
  std::erase(parts, "");
  return parts;
}

class CompareCommand {
 public:
  explicit CompareCommand(CompareArguments arguments) : a_(std::move(arguments)), console_(a_.render.quiet) {}

  int run() {
    catch_interrupts();
    check_arguments();
    std::vector<tradeoff::CaptionedTile> tiles;
    std::vector<tradeoff::Image> pictures;
    pictures.reserve(looks_.size());
    for (const Look& look : looks_) {
      console_.note(formatted("%s (%zu of %zu)", look.name.c_str(), pictures.size() + 1, looks_.size()));
      tradeoff::CaptionedTile tile{look.name, {}, &pictures.emplace_back()};
      if (const int code = render(look, &pictures.back(), &tile.detail); code != kDone) return code;
      if (pictures.back().width != pictures.front().width || pictures.back().height != pictures.front().height)
        console_.usage_error("--look " + look.name, "Its size differs from that of the first: give --size for all.");
      console_.note(look.name + ": " + tile.detail);
      tiles.push_back(tile);
    }
    set_writing(true);
    if (const std::string fault = draw_tiles(tiles, a_.output); !fault.empty())
      console_.fail(kOutput, a_.output, fault);
    console_.note("wrote " + a_.output);
    return kDone;
  }

 private:
  void check_arguments() {
    if (a_.looks.size() < 2)
      console_.usage_error(
          "--look", "Name two variants at least: --look 'as it is:' --look 'rough: materials/NAME.roughness=0.8'");
    for (const std::string& text : a_.looks) {
      const std::string origin = "--look '" + text + "'";
      const size_t colon = text.find(':');
      Look look{text.substr(0, colon), {}};
      if (colon == std::string::npos || look.name.find_first_not_of(' ') == std::string::npos ||
          look.name.find('=') != std::string::npos)
        console_.usage_error(origin, "It has no name: write 'NAME: KEY=VALUE; KEY=VALUE'.");
      for (const std::string& part : parts_of(text.substr(colon + 1)))
        look.overrides.emplace_back(part).origin = "--look " + look.name + ": " + part;
      looks_.push_back(std::move(look));
    }
    if (hd::support::lower_extension(a_.output) != ".png")
      console_.usage_error("-o", "'" + a_.output + "' is no .png file: a sheet is one.");
    console_.require(kOutput, a_.output, hd::support::OutputFault(a_.output));
    console_.require(kOutput, a_.output, tradeoff::gnuplot_fault());
  }

  int render(const Look& look, tradeoff::Image* picture, std::string* detail) {
    SceneSession session;
    hd::description::LoadOptions options = load_options(a_.render);
    options.overrides.insert(options.overrides.end(), look.overrides.begin(), look.overrides.end());
    session.load(a_.render.scene, options, console_.sink());
    session.choose_colors(a_.render.ocio, console_.sink(), kInput);
    const std::string fault = input_overwritten({a_.output}, session, a_.render.scene);
    console_.require_usage("-o", fault);
    const hd::RenderSettingsDescription settings = prepare(&session);
    hd::RenderProduct shown;
    shown.display = a_.render.display, shown.view = a_.render.view, shown.exposure = a_.render.exposure.value_or(0);

    session.start(console_.sink());
    hd::host::RecordOptions record;
    record.colors = session.colors();
    record.faults = session.faults();
    record.cancel = &interrupted();
    record.diagnostics = console_.sink();
    if (a_.render.denoise) record.aovs = {"denoised"};
    record.progress = [&](const hd::host::RecordProgress& progress) { console_.progress(progress); };
    bool is_shown = false;
    record.picture = [&](const hd::host::ProductImage& image) {
      *picture = tradeoff::picture_of(image, a_.render.denoise ? "denoised" : "color");
      const auto displayed = tradeoff::to_display(*picture, shown, session.colors(), console_.sink());
      is_shown = displayed.has_value();
      if (displayed) *picture = *displayed;
    };
    const auto result = hd::host::RecordFrame(session.index(), &session.scene, session.file.settings, record);
    console_.end_progress();
    if (result.status != hd::host::RecordStatus::done) {
      if (exit_code(result) == kInterrupted) console_.note("interrupted: nothing was written");
      return exit_code(result);
    }
    if (!is_shown) return kUsage;
    if (picture->rgb.empty())
      console_.fail(kRender, look.name,
                    "The picture holds values that are not finite; find lights that are too large.");
    *detail =
        noise_in_words(result.stats) + formatted("%.3g s", hd::support::number_in(result.stats, "phase.render.wall"));
    return kDone;
  }

  /// Gives all looks the frame of the first: its size, and its view where that was made for its objects.
  hd::RenderSettingsDescription prepare(SceneSession* session) {
    hd::RenderSettingsDescription settings = session->scene.GetAllRenderSettings().at(session->file.settings);
    settings.products.clear(), settings.crop.reset();
    if (const int longest = std::max(settings.width, settings.height); !a_.render.size && longest > kLongestSide) {
      const auto reduced = [&](int side) {
        return std::max(1, int(std::lround(double(side) * kLongestSide / longest)));
      };
      settings.width = reduced(settings.width), settings.height = reduced(settings.height);
    }
    session->scene.SetRenderSettings(session->file.settings, settings);
    if (session->file.framed) {
      hd::host::CameraDescription camera = session->scene.GetCameras().at(settings.camera);
      if (!framed_) framed_ = camera.transform;
      camera.transform = *framed_;
      session->scene.SetCamera(settings.camera, std::move(camera));
    }
    return settings;
  }

  static std::string noise_in_words(const hd::Dictionary& stats) {
    const double noise = hd::support::number_in(stats, "error.relativeRmse", -1);
    if (!(noise >= 0) || std::isinf(noise) || hd::support::number_in(stats, "error.isKnown", 1) == 0)
      return "noise not known, ";
    return formatted("noise %.2f %%, ", 100 * noise);
  }

  CompareArguments a_;
  Console console_;
  std::vector<Look> looks_;
  std::optional<hd::Matrix4d> framed_;  // the first look's view
};

}  // namespace

int run_compare(CompareArguments arguments) {
  return CompareCommand(std::move(arguments)).run();
}

}  // namespace alabaster::cli
