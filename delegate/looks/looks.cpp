#include "delegate/looks/looks.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/material/disney_material.h"
#include "core/subsurface/medium.h"
#include "delegate/looks/formulas.h"
#include "delegate/looks/look_tables.h"
#include "delegate/looks/patterns.h"
#include "delegate/support/color_space.h"
#include "delegate/support/lookup.h"
#include "delegate/support/parameters.h"

namespace alabaster::hd::looks {
namespace {

constexpr const char* kOurs = "AlabasterDisney";

const Look* look_of(const std::string& type) {
  for (const Look& look : look_tables())
    if (std::find(look.types.begin(), look.types.end(), type) != look.types.end()) return &look;
  return nullptr;
}

float clamped(float share) {
  return std::clamp(share, 0.0f, 1.0f);
}

// The albedo that shows the single-scattering albedo 1 - rest: one_minus_alpha the other way round.
double albedo_of(double rest, double g) {
  double low = 0, high = 1;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (one_minus_alpha(middle, AlbedoInversion::exact, g) > rest ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// Reads one network by the table of its surface.
class LookReader {
 public:
  LookReader(const MaterialNetwork& from, const Path& id, const MaterialNode& surface, const Look& look,
             const WarnLook& warn)
      : from_(from), id_(id), surface_(surface), look_(look), warn_(warn), patterns_(from, warn) {}

  MaterialNetwork run() {
    for (const LookRow& row : look_.rows)
      if (!row.when || is_used(row.when)) read_row(row);
    if (number("thin") != 0 && got_.contains("subsurfaceWeight")) join_sheet();
    if (got_.contains("transmissionColor")) join_transmission();
    for (const char* joined :
         {"transmissionColor", "transmissionDepth", "transmissionScatter", "transmissionAnisotropy"})
      got_.erase(joined);

    MaterialNode disney{kOurs, {}, {}};
    for (const auto& [target, signal] : got_) write(target, signal, &disney);
    to_.nodes[id_] = std::move(disney);
    to_.terminals["surface"] = {id_, "out"};
    read_displacement();
    tell_unread();
    return std::move(to_);
  }

 private:
  void tell(const std::string& text) {
    if (told_.insert(text).second) warn_("material.look", text);
  }

  // Inputs --------------------------------------------------------------------------------------------

  const MaterialConnection* connection_of(const char* name) const {
    return support::first_in(surface_.inputConnections, name);
  }

  /// Each input is read once.
  const Signal& input(const LookInput& wanted, bool is_normal = false) {
    const auto [at, is_new] = inputs_.try_emplace(wanted.name);
    Signal& read = at->second;
    if (!is_new) return read;
    if (const MaterialConnection* const from = connection_of(wanted.name)) {
      const Pattern found = is_normal ? patterns_.read_normals(*from) : patterns_.read(*from);
      if (found.signal) return read = *found.signal;
      warn_("material.node", std::string(wanted.name) + " is connected to " + found.fault + "; " +
                                 (is_normal ? "the mesh's normals are used" : "its constant is used"));
    }
    const bool is_text = wanted.may_be_word && !word(wanted.name).empty();
    const auto given = is_normal || is_text ? std::nullopt : patterns_.constant(surface_, wanted.name);
    return read = given ? Signal{*given, {}} : signal_of(wanted.initial);
  }

  std::string word(const char* name) const { return support::text_in(surface_.parameters, name); }

  bool is_used(const char* weight) {
    for (const LookRow& row : look_.rows)
      for (const LookInput& one : row.inputs)
        if (std::string_view(one.name) == weight) return input(one).is_used();
    for (const ToldInput& one : look_.told)
      if (std::string_view(one.input.name) == weight) return input(one.input).is_used();
    return false;
  }

  void read_row(const LookRow& row) {
    const Terms::Tell tell = [this](const std::string& text) { this->tell(text); };
    std::vector<Signal> signals;
    std::vector<std::string> words;
    for (const LookInput& one : row.inputs) {
      signals.push_back(input(one, row.formula == normals_of));
      words.push_back(word(one.name));
    }
    got_[row.target] = row.formula(Terms(row.inputs, std::move(signals), std::move(words), row.factor, tell));
  }

  // Lobes that AlabasterDisney does not have: what is nearest to them ---------------------------------

  Signal take(const char* target) const { return support::value_in(got_, target); }
  float number(const char* target) const { return got_.contains(target) ? take(target).constant.x : 0; }
  Vec3f color(const char* target, const char* what) {
    const Signal held = take(target);
    if (held.is_textured()) tell(std::string("a texture of ") + what + " is not read; its constant is used");
    return held.rgb();
  }

  /// (1 - share) a + share b, or the one that there is more of.
  Signal mixed(const Signal& a, const Signal& b, float share) const {
    return mixture(a, b, Vec4f(share)).value_or(share < 0.5f ? a : b);
  }

  // Below a sheet 1 + g of two halves of the light leave on the far side; constants are mixed without an error.
  void join_sheet() {
    const Signal weight = take("subsurfaceWeight"), below = take("subsurfaceColor"), base = take("baseColor");
    const float g = number("scatterAnisotropy"), beyond = clamped((1 + g) / 2);
    float w = clamped(weight.constant.x);
    if (weight.is_textured()) w = 1, tell("a texture of the weight of subsurface is not read; it is 1");
    got_["diffTrans"] = signal_of(2 * w * beyond);
    got_["diffTransColor"] = below;
    const float rest = 1 - w * beyond, share = rest > 0 ? w * (1 - beyond) / rest : 1;
    got_["baseColor"] = mixed(base, below, share);
    got_.erase("scatterAnisotropy");
    drop_subsurface();
    if (share > 0 && share < 1 && base.is_textured() && below.is_textured() && base.factors != below.factors)
      tell("two textures of colours are not mixed by the weight of subsurface; one of them is used");
  }

  void drop_subsurface() {
    for (const char* below : {"subsurfaceWeight", "subsurfaceColor", "meanFreePath"}) got_.erase(below);
  }

  // With a depth the colour is that of the interior, else that of the light at each crossing.
  void join_transmission() {
    const Signal clear = take("specTrans");
    const float t = clear.is_textured() ? 1 : clamped(clear.constant.x);
    if (t >= 1 && !clear.is_textured()) drop_subsurface();  // nothing is below
    Signal tint = take("transmissionColor");
    const float depth =
        got_.contains("transmissionDepth") ? color("transmissionDepth", "the transmission's depth").x : 0;
    if (depth > 0 && number("thin") == 0) {
      const Vec3f through = color("transmissionColor", "the transmission's colour");
      const Vec3f scatter = color("transmissionScatter", "the transmission's scatter");
      tint = signal_of(1.0f);
      if (scatter.x > 0 || scatter.y > 0 || scatter.z > 0) {
        if (t < 1) tell("a clear body that scatters is drawn as if transmission were 1");
        return join_cloudy_body(through, scatter, depth);
      }
      got_["attenuationColor"] = signal_of(through);
      got_["attenuationDistance"] = signal_of(depth);
    }
    // A clear solid takes the square root of its colour at each surface (Burley 2015), these looks the colour itself.
    if (number("thin") == 0) tint = product(tint, tint).value_or(tint);
    const Signal base = take("baseColor");
    const bool is_partly_clear = clear.is_textured() || (t > 0 && t < 1);
    if (is_partly_clear && (base.rgb() != tint.rgb() || base.factors != tint.factors))
      tell("the colours of a partly clear surface are mixed: its base and the light through it have one");
    got_["baseColor"] = mixed(base, tint, t);
  }

  // sigma_s = scatter / depth, sigma_t = -ln(color) / depth, both shifted by the least absorption if that is below 0.
  void join_cloudy_body(const Vec3f& through, const Vec3f& scatter, float depth) {
    const double g = double(number("transmissionAnisotropy"));
    std::array<double, 3> extinction{}, scattering{};
    double least = 0;
    for (int i = 0; i < 3; ++i) {
      extinction[size_t(i)] = -std::log(std::clamp(double(through[i]), 1e-30, 1.0)) / double(depth);
      scattering[size_t(i)] = std::max(double(scatter[i]), 0.0) / double(depth);
      least = std::min(least, extinction[size_t(i)] - scattering[size_t(i)]);
    }
    Vec3f albedo, path;
    for (size_t i = 0; i < 3; ++i) {
      const double total = std::max(extinction[i] - least, 1e-3 / double(depth));  // a walk must end
      albedo[int(i)] = float(albedo_of(1 - scattering[i] / total, g));
      path[int(i)] = float(1 / total);
    }
    got_["baseColor"] = signal_of(1.0f);
    got_["subsurfaceColor"] = signal_of(albedo);
    got_["meanFreePath"] = signal_of(path);
    got_["scatterAnisotropy"] = signal_of(float(g));
    got_["specTrans"] = signal_of(1.0f);
  }

  // Outputs -------------------------------------------------------------------------------------------

  /// A texture as a node of the network that is written; its path is that of the node that was read, where it can be.
  MaterialConnection add(const Factor& factor) {
    Path path = factor.id;
    for (int copy = 2; to_.nodes.contains(path) && to_.nodes[path] != factor.node; ++copy)
      path = factor.id.str() + "_" + std::to_string(copy);
    to_.nodes[path] = factor.node;
    return {path, factor.output};
  }

  void write(const std::string& target, const Signal& signal, MaterialNode* disney) {
    for (const Factor& factor : signal.factors) disney->inputConnections[target].push_back(add(factor));
    const MaterialParameter* const row = find_material_parameter(target);
    if (!row) return;  // normals
    const bool is_switch = std::holds_alternative<bool DisneyParameters::*>(row->member);
    const bool is_word = row->words[0] != nullptr;  // the signal is its number
    Value value = is_switch         ? Value(signal.constant.x != 0)
                  : is_word         ? Value(std::string(row->words[size_t(signal.constant.x)]))
                  : row->is_color() ? Value(signal.rgb())
                                    : Value(signal.constant.x);
    // What nobody gave: a constant of 1 beside a texture, and what AlabasterDisney has without it.
    static const DisneyParameters kDefaults;
    if (signal.is_textured() ? signal.constant == Vec4f(1) : value == support::get_parameter(*row, kDefaults)) return;
    disney->parameters[target] = std::move(value);
    if (row->texels == Texels::colors)
      disney->parameters[target + support::kColorSpace] = Token(support::kLinearRec709);
  }

  // UsdPreviewSurface's own input, or a node at the terminal "displacement".
  void read_displacement() {
    const MaterialNode* node = look_.types.front() == std::string_view("UsdPreviewSurface") ? &surface_ : nullptr;
    const auto terminal = from_.terminals.find("displacement");
    if (!node && terminal != from_.terminals.end()) node = support::find_in(from_.nodes, terminal->second.upstreamNode);
    if (!node) return;
    const bool ours = node->nodeTypeId == Token("AlabasterDisplacement");
    if (node != &surface_ && !ours && !node->nodeTypeId.str().starts_with("ND_displacement_"))
      return warn_("material.displacement", "a displacement of type '" + node->nodeTypeId.str() + "' is not read");
    const MaterialConnection* const from = support::first_in(node->inputConnections, "displacement");
    if (!from) {
      const Value constant = support::value_in(node->parameters, "displacement");
      if (!constant.empty() && constant.number_or(1) != 0)
        warn_("material.displacement", "a constant displacement is not read; connect a texture");
      return;
    }
    Pattern found = patterns_.read(*from);
    if (found.signal && found.signal->constant != Vec4f(1)) found.signal = folded(*found.signal);
    if (!found.signal || found.signal->factors.size() != 1)
      return warn_("material.node", "displacement is connected to " +
                                        (found.fault.empty() ? "no single texture" : found.fault) +
                                        "; meshes are not displaced");
    MaterialNode displaces{"AlabasterDisplacement", {}, {{"displacement", {add(found.signal->factors.front())}}}};
    if (ours) displaces.parameters = node->parameters;
    if (node != &surface_ && !ours) {
      displaces.parameters["scale"] = float(support::number_in(node->parameters, "scale", 1));
      if (node->nodeTypeId.str().find("vector") != std::string::npos) displaces.parameters["space"] = "tangent";
    }
    const Path path = id_.append("displacement");
    to_.nodes[path] = std::move(displaces);
    to_.terminals["displacement"] = {path, "out"};
  }

  // One sentence for the inputs that are drawn as if they had other values, one for those that are not known.
  void tell_unread() {
    std::string unread, unknown;
    const auto add_to = [](std::string* list, const std::string& name) { *list += (list->empty() ? "" : ", ") + name; };
    std::set<std::string> known(look_.ignored.begin(), look_.ignored.end());
    for (const ToldInput& one : look_.told) {
      known.insert(one.input.name);
      const bool matters = !one.when || is_used(one.when);
      const bool given = connection_of(one.input.name) || (matters && input(one.input).rgb() != Vec3f(one.drawn));
      if (matters && given) add_to(&unread, one.input.name);
    }
    if (!unread.empty()) warn_("material.look", unread + " of " + surface_.nodeTypeId.str() + " cannot be drawn yet");
    if (look_.has_others) return;
    for (const LookRow& row : look_.rows)
      for (const LookInput& one : row.inputs) known.insert(one.name);
    const auto check = [&](const auto& named) {
      for (const auto& [name, value] : named)
        if (name.str().find(':') == std::string::npos && known.insert(name.str()).second) add_to(&unknown, name.str());
    };
    check(surface_.parameters), check(surface_.inputConnections);
    if (!unknown.empty()) warn_("material.look", unknown + ": no input of " + surface_.nodeTypeId.str());
  }

  const MaterialNetwork& from_;
  const Path& id_;
  const MaterialNode& surface_;
  const Look& look_;
  const WarnLook& warn_;
  Patterns patterns_;
  MaterialNetwork to_;
  std::map<std::string, Signal> inputs_, got_;  // by the look's names; by ours
  std::set<std::string> told_;
};

// OpenUSD's scene index gives each parameter a companion "colorSpace:NAME", empty where the file gives none.
MaterialNetwork without_companions(MaterialNetwork network, const Path& surface) {
  std::erase_if(network.nodes[surface].parameters, [](const auto& parameter) {
    return parameter.first.str().starts_with("colorSpace:") && parameter.second.text_or("").empty();
  });
  return network;
}

}  // namespace

MaterialNetwork ReadLook(const MaterialNetwork& network, const WarnLook& warn) {
  const auto terminal = network.terminals.find("surface");
  if (terminal == network.terminals.end()) return network;
  const auto surface = network.nodes.find(terminal->second.upstreamNode);
  if (surface == network.nodes.end()) return network;
  const auto& [id, node] = *surface;
  if (node.nodeTypeId == Token(kOurs)) return without_companions(network, id);
  const Look* const look = look_of(node.nodeTypeId.str());
  return look ? LookReader(network, id, node, *look, warn).run() : network;
}

std::string LookTypes() {
  std::string all = kOurs;
  for (const Look& look : look_tables())
    for (const char* type : look.types) all += std::string(", ") + type;
  return all;
}

}  // namespace alabaster::hd::looks
