#include "delegate/host/product_plan.h"

#include <algorithm>
#include <set>

#include "core/film/aov.h"
#include "core/images/format_limits.h"
#include "delegate/host/light_paths.h"
#include "delegate/host/product_writer.h"
#include "delegate/support/extension.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::host {
namespace {

std::string known_aov_names() {
  std::string names;
  for (const std::string& name : ProductAovs()) names += (names.empty() ? "" : ", ") + name;
  return names + ", lightGroup:NAME, primvars:NAME, lpe:EXPRESSION";
}

bool kind_of(const std::string& file, FileKind& kind) {
  const std::string ending = support::lower_extension(file);
  if (ending == ".exr") return kind = FileKind::exr, true;
  if (ending == ".png") return kind = FileKind::png, true;
  if (ending == ".tif" || ending == ".tiff") return kind = FileKind::tiff, true;
  if (ending == ".jpg" || ending == ".jpeg") return kind = FileKind::jpeg, true;
  return false;
}

/// Chooses how colours are stored. Returns false if the file cannot hold the product's data type.
bool store_of(FileKind kind, const std::string& type, ChannelStore& store) {
  switch (kind) {
    case FileKind::exr:
      if (type == "float") return store = ChannelStore::float32, true;
      return store = ChannelStore::half, type.empty() || type == "half";
    case FileKind::png:
    case FileKind::tiff:
      if (type == "uint16") return store = ChannelStore::uint16, true;
      break;
    case FileKind::jpeg:
      break;
  }
  return store = ChannelStore::uint8, type.empty() || type == "uint8";
}

/// 16 bits of float are not enough.
bool needs_full_precision(const AovInfo& aov) {
  return aov.value == AovValue::exact || aov.value == AovValue::distance;
}

/// Counts of samples. OpenImageIO reads integers as shares of their largest, so that a count of 64 became 1.5e-08.
bool is_count(const AovInfo& aov) {
  return aov.is_integer() && aov.source == AovSource::samples;
}

ChannelStore exr_store(const AovInfo& aov, const RenderVar& var, ChannelStore product_store) {
  const bool wants_float = var.dataType == Token("float") || (is_count(aov) && var.dataType != Token("int"));
  if (aov.is_integer()) return wants_float ? ChannelStore::float32 : ChannelStore::uint32;
  return wants_float || needs_full_precision(aov) ? ChannelStore::float32 : product_store;
}

std::vector<PlannedChannel> channels_of(const RenderVar& var, const AovInfo& aov, ChannelStore store) {
  const bool usual = var.name.empty() || var.name == var.aov.str();
  std::string layer = !usual ? var.name : is_primvar(aov.aov) ? var.aov.str() : aov.layer;
  if (usual && is_light_group(var.aov.str()) && !light_group_of_aov(var.aov.str()).empty())
    layer += "_" + std::string(light_group_of_aov(var.aov.str()));
  if (usual && aov.source == AovSource::ids) layer.back() = static_cast<char>('0' + rank_pair(var.aov.str()).number);
  std::vector<PlannedChannel> channels;
  const std::string suffixes = aov.channels;
  const bool distance = aov.value == AovValue::distance;
  for (size_t i = 0; i < suffixes.size(); ++i) {
    const bool color = aov.is_color() && suffixes[i] != 'A';
    channels.push_back({(layer.empty() ? "" : layer + ".") + suffixes[i], var.aov, int(i), color, distance, store});
  }
  return channels;
}

bool check_var(const RenderVar& var, FileKind kind, std::string& error) {
  const AovInfo* aov = find_aov(var.aov.str());
  const std::string& type = var.dataType.str();
  if (const std::string fault = light_paths_fault(var.aov.str()); !fault.empty()) {
    error = fault;
  } else if (!aov) {
    error = "there is no AOV '" + var.aov.str() + "'; use one of: " + known_aov_names();
  } else if (type != "half" && type != "float" && type != "int" && !type.empty()) {
    error = "AOV '" + var.aov.str() + "' has the unknown data type '" + type + "'; use half, float or int";
  } else if (type == "int" && !aov->is_integer()) {
    error = "AOV '" + var.aov.str() + "' does not hold integers; use data type half or float";
  } else if (kind != FileKind::exr && !aov->is_color() && var.aov != Token("alpha")) {
    error = "AOV '" + var.aov.str() + "' cannot be stored in this kind of file; write it to an .exr file";
  } else if (kind == FileKind::jpeg && !aov->is_color()) {
    error = "a JPEG file has no alpha; write AOV 'alpha' to a .png, .tif or .exr file";
  } else {
    return true;
  }
  return false;
}

/// What lossy compression would break: ids, names, distances and places, of which all bits count.
bool must_be_kept(const AovInfo& aov) {
  return aov.is_integer() || needs_full_precision(aov);
}

bool plan_compression(const RenderProduct& product, ProductPlan& plan, std::string& error) {
  const Token& wanted = product.compression;
  plan.compression = wanted.empty() ? "zip" : wanted.str();
  if (wanted.empty()) return true;
  if (plan.kind != FileKind::exr) {
    error = "compression '" + wanted.str() + "' is one of .exr files; leave it out for this file";
    return false;
  }
  const auto is_among = [&](const auto& all) { return std::find(all.begin(), all.end(), wanted.str()) != all.end(); };
  if (!is_among(kCompressions)) {
    error = "there is no compression '" + wanted.str() + "'; use one of:";
    for (const char* name : kCompressions) error += std::string(" ") + name;
    return false;
  }
  if (!is_among(kLossyCompressions)) return true;
  for (const RenderVar& var : WantedVars(product))
    if (const AovInfo* aov = find_aov(var.aov.str()); aov && must_be_kept(*aov)) {
      error = "AOV '" + var.aov.str() + "' needs all its bits, and compression '" + wanted.str() +
              "' loses some; write it to a product of its own with compression zip, or choose zip for this file";
      return false;
    }
  return true;
}

bool plan_tiles(const RenderProduct& product, ProductPlan& plan, std::string& error) {
  plan.tiles = product.tiles;
  if (product.tiles == 0) return true;
  const std::string given = "tiles of " + std::to_string(product.tiles) + " pixels ";
  if (plan.kind != FileKind::exr)
    error = given + "are of .exr files; leave them out for this file";
  else if (product.tiles < kLeastTile || product.tiles > kMostTile)
    error = given + "cannot be written; give a side of " + std::to_string(kLeastTile) + " to " +
            std::to_string(kMostTile) + ", or 0 for scanlines";
  return error.empty();
}

bool plan_channels(const RenderProduct& product, ChannelStore store, ProductPlan& plan, std::string& error) {
  const std::vector<RenderVar> vars = WantedVars(product);
  if (plan.kind != FileKind::exr && vars.size() > 1) {
    error = "this kind of file holds one AOV, but the product has " + std::to_string(vars.size()) +
            "; write an .exr file, or one file for each";
    return false;
  }
  std::set<std::string> names;
  for (const RenderVar& var : vars) {
    if (!check_var(var, plan.kind, error)) return false;
    const AovInfo& aov = *find_aov(var.aov.str());
    for (PlannedChannel& c : channels_of(var, aov, plan.kind == FileKind::exr ? exr_store(aov, var, store) : store)) {
      if (plan.kind == FileKind::jpeg && !c.is_color) continue;
      if (plan.kind != FileKind::exr) c.name = c.name.back();  // these files have no layers
      if (c.name.size() > kLongestExrName) {
        error = "channel '" + c.name.substr(0, 40) + "...' has a name of " + std::to_string(c.name.size()) +
                " bytes, and an EXR holds " + std::to_string(kLongestExrName) + "; give its AOV a shorter name";
        return false;
      }
      if (!names.insert(c.name).second) {
        error = "two AOVs would both be stored as channel '" + c.name + "'; give each its own name";
        return false;
      }
      plan.channels.push_back(std::move(c));
    }
  }
  return true;
}

}  // namespace

const std::vector<std::string>& ProductAovs() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const AovInfo& aov : kAovs) all.emplace_back(aov.name);
    return all;
  }();
  return names;
}

std::vector<RenderVar> WantedVars(const RenderProduct& product) {
  std::vector<RenderVar> vars = product.vars;
  if (vars.empty()) vars.push_back({"", "color", "half"});
  const auto usual = [](const RenderVar& v, const char* aov) {
    return v.aov == Token(aov) && (v.name.empty() || v.name == aov);
  };
  const auto has = [&](const auto& is) { return std::any_of(vars.begin(), vars.end(), is); };
  if (has([&](const RenderVar& v) { return usual(v, "color"); }))
    std::erase_if(vars, [&](const RenderVar& v) { return usual(v, "alpha"); });
  if (!product.denoise.value_or(false) || !has([](const RenderVar& v) { return v.aov == Token("color"); })) return vars;
  FileKind kind{};
  if (!kind_of(product.file, kind) || kind == FileKind::exr) {
    if (!has([](const RenderVar& v) { return v.aov == Token("denoised"); })) vars.push_back(UsualRenderVar("denoised"));
  } else {
    for (RenderVar& v : vars)
      if (v.aov == Token("color")) v.aov = "denoised";
  }
  return vars;
}

std::string LightPathsFault(const RenderVar& var) {
  return light_paths_fault(var.aov.str());
}

void ResolveRenderVars(int ranks, std::vector<RenderVar>* vars) {
  resolve_light_paths(vars);
  const int pairs = std::clamp((ranks + 1) / 2, 1, kMostRankPairs);
  std::vector<RenderVar> all;
  for (const RenderVar& var : *vars) {
    const AovInfo* aov = find_aov(var.aov.str());
    const bool has_layers = aov && aov->source == AovSource::ids && var.aov == Token(aov->name);
    for (int pair = 0; pair < pairs && has_layers; ++pair) {  // the number of the pair ends the layer's name
      const std::string digits = "0" + std::to_string(pair);
      all.push_back({var.name.empty() ? "" : var.name + digits, var.aov.str() + digits, "float"});
    }
    if (!has_layers) all.push_back(var);
  }
  *vars = std::move(all);
}

RenderVar UsualRenderVar(const std::string& name) {
  const std::string aov = aov_of_light_paths(name);
  const AovInfo* known = find_aov(aov);
  if (!known) return {aov, aov, "half"};
  const bool is_float = is_count(*known) || needs_full_precision(*known);
  return {aov, aov, is_float ? "float" : known->is_integer() ? "int" : "half"};
}

std::string window_fault(const ProductPlan& plan, const Rect2i& window) {
  const int64_t width = int64_t(window.maxX) - window.minX, height = int64_t(window.maxY) - window.minY;
  const std::string size = support::size_text(width, height);
  if (width > kMostPixels || height > kMostPixels)
    return "a picture has " + support::size_text(kMostPixels, kMostPixels) + " pixels at most, and this one has " +
           size + "; render it smaller or in crops";
  const int64_t most = most_pixels(plan.kind);
  if (width <= most && height <= most) return {};
  return "this kind of file holds " + support::size_text(most, most) + " pixels at most, and the picture has " + size +
         "; write an .exr or .tif file, or render it smaller or in crops";
}

bool PlanProduct(const RenderProduct& product, ProductPlan& plan, std::string& error) {
  plan = {};
  if (!kind_of(product.file, plan.kind)) {
    error = "the file's extension names no format that can be written; use .exr, .png, .tif, .tiff, .jpg or .jpeg";
    return false;
  }
  ChannelStore store{};
  if (!store_of(plan.kind, product.dataType.str(), store)) {
    error = "this kind of file does not hold data type '" + product.dataType.str() +
            "'; use half or float for .exr, uint8 or uint16 for .png and .tif, uint8 for .jpg";
    return false;
  }
  const bool wants_display = !product.display.empty() || !product.view.empty();
  if (wants_display && !product.colorSpace.empty()) {
    error = "the product has both a colour space ('" + product.colorSpace + "') and a display or view; give only one";
    return false;
  }
  plan.display_referred = wants_display || (plan.kind != FileKind::exr && product.colorSpace.empty());
  return plan_compression(product, plan, error) && plan_tiles(product, plan, error) &&
         plan_channels(product, store, plan, error);
}

}  // namespace alabaster::hd::host
