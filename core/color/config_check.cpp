#include "core/color/config_check.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <sstream>

namespace OCIO = OCIO_NAMESPACE;

namespace alabaster {
namespace {

// The ACES configurations have some five hundred colour spaces.
constexpr size_t kMostSpaces = 4000, kMostBytes = size_t(16) << 20;
// OpenColorIO follows references by recursion.
constexpr int kDeepest = 64;

// A CTF, an XML file, may name a further file for OpenColorIO to open: by an element, which an entity may spell. In
// encodings of two bytes every other one is zero.
bool refers_to_files(const InputFile& file) {
  constexpr std::string_view kWords[] = {"<Reference", "<!ENTITY"};
  constexpr uint64_t kAtOnce = uint64_t(1) << 20, kLongest = 10;
  std::string text, block;
  for (uint64_t at = 0; at < file.size(); at += kAtOnce) {
    block.resize(std::min(kAtOnce, file.size() - at));
    if (!file.read(at, block.data(), block.size())) return false;  // OpenColorIO will report it
    std::erase(block, '\0');
    text = text.substr(text.size() - std::min<size_t>(text.size(), kLongest)) + block;
    for (const std::string_view word : kWords)
      if (text.find(word) != std::string::npos) return true;
  }
  return false;
}

/// Walks from a colour space to those that its transforms name.
class References {
 public:
  References(const OCIO::ConstConfigRcPtr& config, const std::string& within, std::map<std::string, std::string>* luts)
      : config_(config), within_(within), luts_(luts) {}

  std::string check() {
    const int spaces = config_->getNumColorSpaces(OCIO::SEARCH_REFERENCE_SPACE_ALL, OCIO::COLORSPACE_ALL);
    for (int i = 0; i < spaces && fault_.empty(); ++i)
      enter_space(config_->getColorSpaceNameByIndex(OCIO::SEARCH_REFERENCE_SPACE_ALL, OCIO::COLORSPACE_ALL, i));
    for (int i = 0; i < config_->getNumLooks() && fault_.empty(); ++i) enter_look(config_->getLookNameByIndex(i));
    for (int i = 0; i < config_->getNumViewTransforms() && fault_.empty(); ++i)
      enter_view(config_->getViewTransformNameByIndex(i));
    for (int i = 0; i < config_->getNumNamedTransforms() && fault_.empty(); ++i)
      enter_named(config_->getNamedTransformNameByIndex(i));
    return fault_;
  }

 private:
  template <class Inside>
  void enter(const std::string& kind, const std::string& name, const Inside& inside) {
    if (!fault_.empty()) return;
    const auto [seen, is_new] = open_.emplace(kind + " '" + name + "'", true);
    if (!is_new && seen->second) fault_ = seen->first + " is made of itself";
    if (!is_new) return;
    if (++depth_ > kDeepest)
      fault_ = seen->first + " is reached through more than " + std::to_string(kDeepest) + " others";
    if (fault_.empty()) inside();
    --depth_;
    seen->second = false;
  }

  // A name may stand for a named transform, too, and hold variables of the environment.
  void enter_space(const std::string& written) {
    const std::string name = config_->getCurrentContext()->resolveStringVar(written.c_str());
    const auto space = config_->getColorSpace(name.c_str());
    if (!space) return enter_named(name.c_str());
    enter("colour space", space->getName(), [&] {
      visit(space->getTransform(OCIO::COLORSPACE_DIR_TO_REFERENCE));
      visit(space->getTransform(OCIO::COLORSPACE_DIR_FROM_REFERENCE));
    });
  }
  void enter_named(const char* name) {
    const auto named = config_->getNamedTransform(name);
    if (!named) return;
    enter("named transform", named->getName(), [&] {
      visit(named->getTransform(OCIO::TRANSFORM_DIR_FORWARD));
      visit(named->getTransform(OCIO::TRANSFORM_DIR_INVERSE));
    });
  }
  void enter_look(const char* name) {
    const auto look = config_->getLook(name);
    if (!look) return;
    enter("look", look->getName(), [&] {
      enter_space(look->getProcessSpace());
      visit(look->getTransform());
      visit(look->getInverseTransform());
    });
  }
  void enter_view(const char* name) {
    const auto view = config_->getViewTransform(name);
    if (!view) return;
    enter("view transform", view->getName(), [&] {
      visit(view->getTransform(OCIO::VIEWTRANSFORM_DIR_TO_REFERENCE));
      visit(view->getTransform(OCIO::VIEWTRANSFORM_DIR_FROM_REFERENCE));
    });
  }

  // "a, +b | c"
  void enter_looks(std::string names) {
    std::replace_if(
        names.begin(), names.end(), [](char c) { return std::strchr(",:|+-", c) != nullptr; }, ' ');
    std::istringstream words(names);
    for (std::string name; words >> name;) enter_look(name.c_str());
  }

  bool is_of_display(const std::string& written) const {
    const auto space = config_->getColorSpace(config_->getCurrentContext()->resolveStringVar(written.c_str()));
    return space && space->getReferenceSpaceType() == OCIO::REFERENCE_SPACE_DISPLAY;
  }
  // From a space of the scene to one of a display, or back, the way leads through a view transform.
  void enter_conversion(const std::string& from, const std::string& to, const std::string& view_transform) {
    enter_space(from);
    enter_space(to);
    if (!view_transform.empty()) return enter_view(view_transform.c_str());
    const auto usual = config_->getDefaultSceneToDisplayViewTransform();
    if (usual && is_of_display(from) != is_of_display(to)) enter_view(usual->getName());
  }
  void enter_display(const OCIO::DisplayViewTransform& transform) {
    const char *display = transform.getDisplay(), *view = transform.getView();
    std::string space = config_->getDisplayViewColorSpaceName(display, view);
    if (space == OCIO::OCIO_VIEW_USE_DISPLAY_NAME) space = display;
    enter_conversion(transform.getSrc(), space, config_->getDisplayViewTransformName(display, view));
    enter_looks(config_->getDisplayViewLooks(display, view));
  }

  void visit(const OCIO::ConstTransformRcPtr& transform) {
    if (!transform || !fault_.empty()) return;
    if (const auto group = OCIO::DynamicPtrCast<const OCIO::GroupTransform>(transform)) {
      if (++depth_ > kDeepest) fault_ = "transforms are nested more than " + std::to_string(kDeepest) + " deep";
      for (int i = 0; i < group->getNumTransforms(); ++i) visit(group->getTransform(i));
      --depth_;
    } else if (const auto spaces = OCIO::DynamicPtrCast<const OCIO::ColorSpaceTransform>(transform)) {
      enter_conversion(spaces->getSrc(), spaces->getDst(), "");
    } else if (const auto display = OCIO::DynamicPtrCast<const OCIO::DisplayViewTransform>(transform)) {
      enter_display(*display);
    } else if (const auto looks = OCIO::DynamicPtrCast<const OCIO::LookTransform>(transform)) {
      enter_conversion(looks->getSrc(), looks->getDst(), "");
      enter_looks(looks->getLooks());
    } else if (const auto file = OCIO::DynamicPtrCast<const OCIO::FileTransform>(transform)) {
      check_file(file->getSrc());
    }
  }

  // A LUT that is missing is reported where it is used.
  void check_file(const char* name) {
    std::string found;
    try {
      found = config_->getCurrentContext()->resolveFileLocation(name);
    } catch (const OCIO::Exception&) {
      // `found` stays empty.
    }
    if (luts_) (*luts_)[name] = found;
    if (found.empty()) return;
    const InputFile file(found, within_);
    if (file.fault() == InputFile::Fault::outside) fault_ = "the LUT " + file.reason();
    if (file.fault() == InputFile::Fault::not_regular) fault_ = "the LUT '" + found + "' is not a regular file";
    if (file && refers_to_files(file))
      fault_ = "the LUT '" + found + "' refers to other files, which is not supported; put them into the configuration";
  }

  const OCIO::ConstConfigRcPtr& config_;
  const std::string& within_;
  std::map<std::string, std::string>* const luts_;  // null: they are not listed
  std::map<std::string, bool> open_;                // by name: true while inside it
  int depth_ = 0;
  std::string fault_;
};

}  // namespace

std::string read_config_text(const InputFile& file, std::string* text) {
  if (!file) return file.reason();
  if (file.size() > kMostBytes) return "it is larger than " + std::to_string(kMostBytes >> 20) + " MiB";
  return file.read(text) ? std::string() : "it cannot be read to its end";
}

std::string config_text_fault(const std::string& text) {
  const std::string mark = "!<ColorSpace>";
  size_t spaces = 0;
  for (size_t at = text.find(mark); at != std::string::npos; at = text.find(mark, at + mark.size())) ++spaces;
  if (spaces <= kMostSpaces) return {};
  return "it has " + std::to_string(spaces) + " colour spaces, and the limit is " + std::to_string(kMostSpaces);
}

std::string config_fault(const OCIO::ConstConfigRcPtr& config, const std::string& within,
                         std::map<std::string, std::string>* luts) {
  return References(config, within, luts).check();
}

}  // namespace alabaster
